//! Overrides of an instance, applied to its prefab's file.

use super::context::fault_error;
use crate::files::error::{FileError, FileErrorKind as Kind};
use crate::files::format::custom_components::ComponentTypes;
use crate::files::format::scene_file::*;
use crate::files::format::validate::Validator;
use crate::files::load::loader::canonical_entities;
use crate::files::load::source::SceneInfo;
use crate::files::ron::document::{Document, folder_of};
use crate::files::ron::steps;
use crate::files::save::describe::is_in_prefab;
use crate::files::save::disk::write_atomically;
use crate::files::save::paths::Rebase;
use crate::files::save::rewrite::rewritten;
use crate::files::save::scene::saved_subtree;
use crate::files::save::text::prefab_text;
use crate::world::GameWorld;
use bevy_ecs::prelude::Entity;
use std::collections::BTreeMap;
use std::path::Path;

/// Writes what an instance changes of its prefab into the prefab's file, which keeps its text where nothing changes.
///
/// # Errors
/// If something has no form in a file, or the prefab's file cannot be read or written.
pub fn apply_to_prefab(world: &GameWorld, instance: Entity, scene: &Path, path: &Path) -> Result<(), FileError> {
    if is_in_prefab(world, instance) {
        let message = format!("`{}` belongs to another prefab", world.name(instance));
        return Err(FileError::new(path, Kind::Unsavable, message).with_help("apply the instance of that one"));
    }
    let default_types = ComponentTypes::default();
    let types = world.ecs.get_resource().unwrap_or(&default_types);
    let (document, mut prefab) = Document::read::<PrefabFile>(path)?;
    Validator::prefab(&prefab).map_err(|fault| steps::fault_error(&document, *fault))?;
    canonical_entities(&document, &mut prefab.entities, types)?;
    let mut described = saved_subtree(world, instance, scene)?;
    let rebase = Rebase::new(folder_of(scene), folder_of(path));
    rebase.entity(&mut described).map_err(|error| error.at_file(path))?;
    let materials = world.ecs.get_resource::<SceneInfo>().map(|info| info.materials.clone()).unwrap_or_default();
    let mut names = Names { scene: materials, prefab: &mut prefab.materials, rebase };
    for (at, mut patch) in described.overrides {
        names.patch(&mut patch);
        let steps: Vec<&str> = at.split('/').collect();
        apply(&mut prefab.entities, &steps, patch);
    }
    for mut child in described.children {
        names.entity(&mut child);
        prefab.entities.push(child);
    }
    Validator::prefab(&prefab).map_err(|fault| fault_error(path, *fault))?;
    let new = || prefab_text(&prefab, Some(types)).map_err(|e| FileError::new(path, Kind::Unsavable, e.to_string()));
    match rewritten(&document.whole_text(), path, &prefab, types) {
        Some(text) => write_atomically(path, &text),
        None => write_atomically(path, &new()?),
    }
}

/// Makes a change of the entity at a path: in the file's own entities, or in what the file changes of an inner instance.
fn apply(entities: &mut Vec<EntityFile>, path: &[&str], patch: OverrideFile) {
    let Some((name, rest)) = path.split_first() else { return };
    let Some(index) = entities.iter().position(|entity| entity.name == *name) else { return };
    if rest.is_empty() {
        match patch.remove {
            true => drop(entities.remove(index)),
            false => change(&mut entities[index], patch),
        }
        return;
    }
    let entity = &mut entities[index];
    let is_own = rest.first().is_some_and(|next| entity.children.iter().any(|child| child.name == *next));
    if entity.prefab.is_none() || is_own {
        return apply(&mut entity.children, rest, patch);
    }
    let known = entity.overrides.entry(rest.join("/")).or_default();
    if patch.remove {
        *known = patch;
        return;
    }
    change_override(known, patch);
}

fn change(entity: &mut EntityFile, patch: OverrideFile) {
    let mut components = entity.components();
    patch.without.iter().for_each(|kind| components.take_away(kind));
    if patch.mesh.is_some() || patch.model.is_some() {
        (components.mesh, components.model) = (None, None);
    }
    components.replace_with(&patch);
    let changed = EntityFile::with_components(std::mem::take(&mut entity.name), components);
    let (prefab, repeat) = (entity.prefab.take(), entity.repeat.take());
    let (overrides, mut children) = (std::mem::take(&mut entity.overrides), std::mem::take(&mut entity.children));
    children.extend(patch.children);
    *entity = EntityFile { prefab, repeat, overrides, children, ..changed };
}

fn change_override(known: &mut OverrideFile, patch: OverrideFile) {
    patch.without.iter().for_each(|kind| known.take_away(kind));
    let new = patch.without.iter().filter(|kind| !known.without.contains(kind)).cloned().collect::<Vec<_>>();
    known.without.extend(new);
    if patch.mesh.is_some() || patch.model.is_some() {
        (known.mesh, known.model) = (None, None);
    }
    known.replace_with(&patch);
    known.children.extend(patch.children);
}

/// Materials that the scene knows by names which the prefab may not know, or know otherwise.
struct Names<'a> {
    scene: BTreeMap<String, MaterialFile>,
    prefab: &'a mut BTreeMap<String, MaterialFile>,
    rebase: Rebase,
}

impl Names<'_> {
    fn entity(&mut self, entity: &mut EntityFile) {
        self.material(&mut entity.material);
        entity.overrides.values_mut().for_each(|patch| self.patch(patch));
        entity.children.iter_mut().for_each(|child| self.entity(child));
    }

    fn patch(&mut self, patch: &mut OverrideFile) {
        self.material(&mut patch.material);
        patch.children.iter_mut().for_each(|child| self.entity(child));
    }

    fn material(&mut self, material: &mut Option<MaterialRef>) {
        let Some(MaterialRef::Named(name)) = material else { return };
        let Some(mut file) = self.scene.get(name).cloned() else { return };
        // Its images are looked for where they were, if there is no way to them.
        let _ = self.rebase.material(&mut file);
        if *self.prefab.entry(name.clone()).or_insert_with(|| file.clone()) != file {
            *material = Some(MaterialRef::Inline(Box::new(file)));
        }
    }
}
