//! Prefabs made of what a world holds, and instances made plain entities.

use super::context::fault_error;
use crate::files::error::{FileError, FileErrorKind as Kind};
use crate::files::format::custom_components::ComponentTypes;
use crate::files::format::scene_file::*;
use crate::files::format::validate::Validator;
use crate::files::load::source::{Origin, SceneInfo, Source};
use crate::files::ron::document::{check_replaced, folder_of};
use crate::files::save::paths::Rebase;
use crate::files::save::scene::saved_subtree;
use crate::world::GameWorld;
use bevy_ecs::prelude::Entity;
use std::path::Path;

/// Makes an instance of a prefab plain entities of the scene file.
pub fn break_prefab(world: &mut GameWorld, instance: Entity) {
    for entity in world.subtree(instance) {
        let material = world.ecs.get::<Source>(entity).and_then(|s| s.material.clone());
        let info = world.ecs.get_resource::<SceneInfo>();
        let described = info.zip(material).and_then(|(info, m)| info.materials_by_id.get(&m.id).cloned());
        let Some(mut source) = world.ecs.get_mut::<Source>(entity) else { continue };
        let is_part = matches!(source.origin, Origin::Prefab { .. });
        if is_part {
            if source.components.material.is_some() {
                source.components.material = described.or(source.components.material.take());
            }
            source.origin = Origin::File;
        }
        // Inner instances become plain too: the paths of their prefabs start at the folder of this one.
        if is_part || entity == instance {
            source.prefab = None;
            source.repeat = None;
            source.overrides.clear();
            source.members.clear();
        }
    }
}

/// Writes a prefab file of the entity with all below it: its children, or the entity itself if it has components
/// besides its place. Entities of inner prefabs are written in full.
///
/// # Errors
/// If something has no form in a file, or the file cannot be written.
pub fn save_prefab(world: &GameWorld, entity: Entity, scene: &Path, path: &Path) -> Result<(), FileError> {
    let tree = saved_subtree(world, entity, scene)?;
    let bare = EntityFile { name: tree.name.clone(), transform: tree.transform, ..Default::default() };
    let only_children = EntityFile { children: Vec::new(), ..tree.clone() } == bare;
    let entities = match only_children {
        true => tree.children,
        false => vec![EntityFile { transform: None, ..tree }],
    };
    write_prefab(world, entities, scene, path)
}

fn write_prefab(world: &GameWorld, entities: Vec<EntityFile>, scene: &Path, path: &Path) -> Result<(), FileError> {
    check_replaced(path)?;
    let info = world.ecs.get_resource::<SceneInfo>();
    let mut names = std::collections::BTreeSet::new();
    entities.iter().for_each(|entity| material_names_of(entity, &mut names));
    let materials = info.map(|info| info.materials.clone()).unwrap_or_default();
    let materials = materials.into_iter().filter(|(name, _)| names.contains(name)).collect();
    let mut prefab = PrefabFile { materials, entities, ..Default::default() };
    let rebase = Rebase::new(folder_of(scene), folder_of(path));
    rebase.prefab(&mut prefab).map_err(|no_way| no_way.at_file(path))?;
    Validator::prefab(&prefab).map_err(|fault| fault_error(path, *fault))?;
    let text = crate::files::save::text::prefab_text(&prefab, world.ecs.get_resource::<ComponentTypes>())
        .map_err(|e| FileError::new(path, Kind::Unsavable, e.to_string()))?;
    crate::files::save::disk::write_atomically(path, &text)
}

fn material_names_of(entity: &EntityFile, names: &mut std::collections::BTreeSet<String>) {
    let overridden = entity.overrides.values().filter_map(|o| o.material.as_ref());
    for material in entity.material.iter().chain(overridden) {
        if let MaterialRef::Named(name) = material {
            names.insert(name.clone());
        }
    }
    let added = entity.overrides.values().flat_map(|o| &o.children);
    entity.children.iter().chain(added).for_each(|child| material_names_of(child, names));
}
