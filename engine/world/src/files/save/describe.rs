//! Descriptions of entities and scenes of a loaded world in terms of scene files.

use super::scene::check;
use super::writer::{Writer, scene_without_entities};
use crate::files::error::FileError;
use crate::files::format::scene_file::{EntityFile, OverrideFile, SceneFile};
use crate::files::load::source::{Origin, SceneInfo, Source};
use crate::world::GameWorld;
use bevy_ecs::prelude::Entity;
use std::path::Path;

/// The description of the entity without its animation, as a scene file would have it.
///
/// # Errors
/// If it has something that has no form in a file, as a mesh of a glTF model.
pub fn describe_entity(world: &GameWorld, entity: Entity, path: &Path) -> Result<OverrideFile, FileError> {
    with_writer(world, path, |writer| writer.components(entity))
}

/// The description of the entity with its descendants, as a scene file would have it.
///
/// # Errors
/// As [`describe_entity`].
pub fn describe_subtree(world: &GameWorld, entity: Entity, path: &Path) -> Result<EntityFile, FileError> {
    with_writer(world, path, |writer| writer.entity(entity))
}

/// The scene without its entities: description, method, settings, presets, materials.
pub fn describe_scene(world: &GameWorld) -> SceneFile {
    scene_without_entities(world)
}

/// Whether the entity was made from a node of a glTF model: changes of it are not written.
pub fn is_from_model(world: &GameWorld, entity: Entity) -> bool {
    world.ecs.get::<Source>(entity).is_some_and(|source| matches!(source.origin, Origin::Model))
}

/// The prefab that the entity is an instance of, as the file names it.
pub fn prefab_of(world: &GameWorld, entity: Entity) -> Option<&str> {
    world.ecs.get::<Source>(entity)?.prefab.as_deref()
}

/// Whether the entity is an instance that makes several copies of its prefab.
pub fn is_repeated(world: &GameWorld, entity: Entity) -> bool {
    world.ecs.get::<Source>(entity).is_some_and(|source| source.repeat.is_some())
}

/// Whether the entity belongs to an instance of a prefab further up.
pub fn is_in_prefab(world: &GameWorld, entity: Entity) -> bool {
    world.ecs.get::<Source>(entity).is_some_and(|source| matches!(source.origin, Origin::Prefab { .. }))
}

/// Lends the world to a writer.
fn with_writer<T>(world: &GameWorld, path: &Path, read: impl FnOnce(&Writer) -> T) -> T {
    let default_info = SceneInfo::default();
    let info = world.ecs.get_resource::<SceneInfo>().unwrap_or(&default_info);
    read(&Writer { world, info, path, overridden: None })
}

/// The whole scene, entities included, as its file would say it.
///
/// # Errors
/// When the world holds something that has no form in a file.
pub fn describe_all(world: &GameWorld, path: &Path) -> Result<SceneFile, FileError> {
    let default_info = SceneInfo::default();
    let info = world.ecs.get_resource::<SceneInfo>().unwrap_or(&default_info);
    let entities = Writer { world, info, path, overridden: None }.entities(&world.roots())?;
    let file = SceneFile { entities, ..scene_without_entities(world) };
    check(&file, path)?;
    Ok(file)
}
