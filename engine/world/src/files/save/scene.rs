//! From a world to a scene file.

use super::disk::write_atomically;
use super::rewrite::rewritten;
use super::text::to_text;
use super::writer::{Writer, scene_without_entities};
use crate::files::error::{FileError, FileErrorKind as Kind};
use crate::files::format::custom_components::ComponentTypes;
use crate::files::format::scene_file::*;
use crate::files::format::validate::Validator;
use crate::files::load::source::SceneInfo;
use crate::files::ron::document::{check_replaced, read_text};
use crate::files::ron::tree::Step;
use crate::world::GameWorld;
use bevy_ecs::prelude::Entity;
use std::borrow::Cow;
use std::path::Path;

/// Writes the world as a scene file: the rest pose, entities and assets as they were described where they have not
/// changed. What has not changed keeps its text: that of the file which the scene was loaded from, also under another
/// name. The file is replaced in one step; the one before is kept as `NAME.bak`.
///
/// # Errors
/// When the world holds something that has no form in a file (a mesh made by code, a value that is not finite), or
/// when the file cannot be written. The file is untouched then.
pub fn save_scene(world: &GameWorld, path: &Path) -> Result<(), FileError> {
    check_replaced(path)?;
    let text = scene_text(world, path)?;
    write_atomically(path, &text)
}

/// The text of the scene file: the one that is there with what has changed, or else a new one.
pub fn scene_text(world: &GameWorld, path: &Path) -> Result<String, FileError> {
    text_of(world, path, &saved_file(world, path)?)
}

/// The contents of the scene file to write.
pub(in crate::files) fn saved_file(world: &GameWorld, path: &Path) -> Result<SceneFile, FileError> {
    let default_info = SceneInfo::default();
    let info = world.ecs.get_resource::<SceneInfo>().unwrap_or(&default_info);
    let writer = Writer::saving(world, info, path);
    let mut file = SceneFile { entities: writer.entities(&world.roots())?, ..scene_without_entities(world) };
    if let Some(overridden) = writer.overridden {
        file.settings = overridden.saved_settings(file.settings);
    }
    check(&file, path)?;
    Ok(file)
}

/// The text of a scene file that says so.
pub(in crate::files) fn text_of(world: &GameWorld, path: &Path, file: &SceneFile) -> Result<String, FileError> {
    let default_info = SceneInfo::default();
    let info = world.ecs.get_resource::<SceneInfo>().unwrap_or(&default_info);
    let default_types = ComponentTypes::default();
    let types = world.ecs.get_resource().unwrap_or(&default_types);
    match bases(info, path).find_map(|base| rewritten(&base, path, file, types)) {
        Some(text) => Ok(text),
        None => new_text(file, info, path, types),
    }
}

/// The texts that a save may edit: the scene's file as it is now, or as it was read; for a scene that comes from none the
/// file that is replaced.
fn bases<'a>(info: &'a SceneInfo, path: &'a Path) -> impl Iterator<Item = Cow<'a, str>> {
    let (file, read) = info.file.as_ref().map_or((path, None), |(file, read)| (file.as_path(), Some(&**read)));
    let present = std::iter::once_with(move || read_text(file)).flatten();
    present.map(Cow::Owned).chain(read.map(Cow::Borrowed))
}

/// The entity with all below it, as a file would say it.
pub(in crate::files) fn saved_subtree(world: &GameWorld, entity: Entity, path: &Path) -> Result<EntityFile, FileError> {
    let default_info = SceneInfo::default();
    let info = world.ecs.get_resource().unwrap_or(&default_info);
    Writer::saving(world, info, path).entity(entity)
}

fn new_text(file: &SceneFile, info: &SceneInfo, path: &Path, types: &ComponentTypes) -> Result<String, FileError> {
    let body = to_text(file, Some(types)).map_err(|e| FileError::new(path, Kind::Unsavable, e.to_string()))?;
    let header = if info.header.is_empty() { String::new() } else { format!("{}\n", info.header) };
    Ok(format!("{header}{body}\n"))
}

/// Whether what was read out of a world can be read in again.
pub(in crate::files) fn check(file: &SceneFile, path: &Path) -> Result<(), FileError> {
    Validator::scene(file).map_err(|fault| {
        let place = readable(file, &fault.path);
        let error = FileError::new(path, Kind::Unsavable, format!("cannot save {place}: {}", fault.message));
        match fault.help {
            Some(help) => error.with_help(help),
            None => error,
        }
    })
}

/// The path with entities by their names.
fn readable(file: &SceneFile, path: &[Step]) -> String {
    let mut entities = &file.entities;
    let mut words: Vec<String> = Vec::new();
    for pair in path.iter().enumerate() {
        match pair {
            (_, Step::Index(i))
                if entities.len() > *i && words.last().is_some_and(|w| w == "entities" || w == "children") =>
            {
                words.pop();
                words.push(format!("`{}`", entities[*i].name));
                entities = &entities[*i].children;
            }
            (_, Step::Index(i)) => words.push(i.to_string()),
            (_, Step::Key(key)) => words.push(key.clone()),
        }
    }
    words.join(", ")
}
