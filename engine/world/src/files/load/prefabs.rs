//! Instances of prefabs: their files, what they hold, and errors of what overrides them.

use super::loader::{Context, Level, Loader, Prefab, canonical, canonical_entities};
use crate::files::error::{FileError, FileErrorKind as Kind};
use crate::files::format::scene_file::{EntityFile, PrefabFile};
use crate::files::format::validate::Validator;
use crate::files::ron::document::{Document, folder_of, io_error};
use crate::files::ron::steps::{extended, fault_error, key};
use crate::files::ron::suggest::suggestion;
use crate::files::ron::tree::Step;
use bevy_ecs::prelude::Entity;
use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::rc::Rc;

impl Loader<'_> {
    /// Spawns the entities of a prefab below the instance; gives their paths.
    pub(in crate::files) fn instance(
        &mut self,
        file: &EntityFile,
        context: &Rc<Context>,
        entity: Entity,
        at: &[Step],
    ) -> Result<Vec<String>, FileError> {
        let written = file.prefab.as_deref().unwrap_or_default();
        let place = extended(at, &[key("prefab")]);
        let (path, prefab) = self.prefab(written, context, &place)?;
        self.chain.push(path);
        self.levels.push(Level {
            overrides: file.overrides.clone(),
            context: context.clone(),
            at: extended(at, &[key("overrides")]),
            trail: Vec::new(),
            members: Vec::new(),
        });
        match &file.repeat {
            None => self.prefab_entities(&prefab.0, &prefab.1, entity)?,
            Some(repeat) => {
                for index in 0..repeat.count() {
                    let name = (index + 1).to_string();
                    let holder = EntityFile { name, transform: Some(repeat.place(index)), ..Default::default() };
                    self.holder(&holder, &prefab.0, Some(entity), &[key("entities")], Some(&*prefab))?;
                }
            }
        }
        self.chain.pop();
        let level = self.levels.pop();
        let members = level.map(|l| l.members).unwrap_or_default();
        check_overrides(file, context, at, written, &members)?;
        let own: Vec<&str> = match &file.repeat {
            None => prefab.1.iter().map(|entity| entity.name.as_str()).collect(),
            Some(_) => members.iter().filter(|path| !path.contains('/')).map(String::as_str).collect(),
        };
        check_children(file, context, at, &own)?;
        Ok(members)
    }

    /// Spawns the entities of a prefab's file.
    pub(in crate::files) fn prefab_entities(
        &mut self,
        context: &Rc<Context>,
        entities: &[EntityFile],
        parent: Entity,
    ) -> Result<(), FileError> {
        for (i, child) in entities.iter().enumerate() {
            self.entity(child, context, Some(parent), &[key("entities"), Step::Index(i)])?;
        }
        Ok(())
    }

    fn prefab(&mut self, written: &str, context: &Context, at: &[Step]) -> Result<(PathBuf, Rc<Prefab>), FileError> {
        let path = context.document.folder().join(written);
        self.roots.check("prefab", written, &path, &context.document, at)?;
        self.library.ask(&path);
        let identity = canonical(&path);
        if let Some(start) = self.chain.iter().position(|p| *p == identity) {
            return Err(cycle_error(&self.chain[start..], &identity, context, at));
        }
        if let Some(known) = self.prefabs.get(&identity) {
            return Ok((identity, known.clone()));
        }
        if !path.is_file() {
            let looked = io_error(&path, "", &std::io::ErrorKind::NotFound.into());
            let message = format!("there is no prefab `{written}` (looked for {})", path.display());
            let error = context.document.error(at, Kind::MissingFile, message);
            let help = looked.help.unwrap_or_else(|| "paths of prefabs start at the folder of this file".into());
            return Err(error.with_help(help));
        }
        let (document, mut file) = Document::read::<PrefabFile>(&path)?;
        let spent = self.library.meter().bytes(&path, document.text.len() as u64);
        spent.map_err(|e| context.document.asset_error(at, Kind::Budget, &e))?;
        Validator::prefab(&file).map_err(|fault| fault_error(&document, *fault))?;
        canonical_entities(&document, &mut file.entities, &self.options.types)?;
        let context = Rc::new(Context { document, materials: file.materials, is_root: false });
        let prefab = Rc::new((context, file.entities));
        self.library.note(&identity);
        self.prefabs.insert(identity.clone(), prefab.clone());
        Ok((identity, prefab))
    }
}

fn check_overrides(
    file: &EntityFile,
    context: &Context,
    at: &[Step],
    prefab: &str,
    members: &[String],
) -> Result<(), FileError> {
    let known: HashSet<&str> = members.iter().map(String::as_str).collect();
    for path in file.overrides.keys() {
        if known.contains(path.as_str()) {
            continue;
        }
        let at = extended(at, &[key("overrides"), key(path)]);
        let error = context.document.error(&at, Kind::UnknownName, format!("`{prefab}` has no entity `{path}`"));
        return Err(match suggestion(path, members.iter().map(String::as_str)) {
            Some(help) => error.with_help(help),
            None => error,
        });
    }
    Ok(())
}

/// An instance's own children must not bear the names of the prefab's.
fn check_children(file: &EntityFile, context: &Context, at: &[Step], prefab: &[&str]) -> Result<(), FileError> {
    for (i, child) in file.children.iter().enumerate() {
        if prefab.contains(&child.name.as_str()) {
            let at = extended(at, &[key("children"), Step::Index(i), key("name")]);
            let message = format!("the prefab has a child named `{}` already", child.name);
            let error = context.document.error(&at, Kind::DuplicateName, message);
            return Err(error.with_help("give it another name, or change the prefab's child under `overrides`"));
        }
    }
    Ok(())
}

fn cycle_error(chain: &[PathBuf], again: &Path, context: &Context, at: &[Step]) -> FileError {
    let names: Vec<String> =
        chain.iter().map(PathBuf::as_path).chain([again]).map(|p| short_name(p, folder_of(again))).collect();
    let message = format!("the prefab contains itself: {}", names.join(" → "));
    let error = context.document.error(at, Kind::PrefabCycle, message);
    error.with_help("take one of these instances out")
}

fn short_name(path: &Path, folder: &Path) -> String {
    path.strip_prefix(folder).unwrap_or(path).display().to_string()
}
