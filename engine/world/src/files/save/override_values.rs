//! Changes of a world that no save writes.

use super::describe::{describe_entity, is_from_model};
use super::overridden::{Change, Overridden};
use crate::core::SceneId;
use crate::files::format::scene_file::OverrideFile;
use crate::world::GameWorld;
use std::collections::HashMap;
use std::path::Path;

/// Makes changes that no save writes: values that differ by them, and entities that they add. Each save writes the file's
/// own value as long as the changed one stays.
///
/// # Errors
/// The result of the work.
pub fn override_values<E>(
    world: &mut GameWorld,
    path: &Path,
    sets: Vec<String>,
    work: impl FnOnce(&mut GameWorld) -> Result<(), E>,
) -> Result<(), E> {
    world.ecs.remove_resource::<Overridden>();
    let (before, settings) = (described(world, path), world.rest_settings());
    work(world)?;
    let mut overridden = Overridden { sets, ..Default::default() };
    for (id, set) in described(world, path) {
        match before.get(&id) {
            Some(file) if *file == set => {}
            Some(file) => drop(overridden.entities.insert(id, Change { file: file.clone(), set })),
            None => drop(overridden.added.insert(id, set)),
        }
    }
    let set = world.rest_settings();
    overridden.settings = (set != settings).then_some(Change { file: settings, set });
    world.ecs.insert_resource(overridden);
    Ok(())
}

fn described(world: &GameWorld, path: &Path) -> HashMap<SceneId, OverrideFile> {
    let all = world.roots().into_iter().flat_map(|root| world.subtree(root));
    let of_files = all.filter(|entity| !is_from_model(world, *entity));
    of_files.filter_map(|entity| Some((world.id(entity)?, describe_entity(world, entity, path).ok()?))).collect()
}
