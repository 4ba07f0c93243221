//! Instances of prefabs that are added to a world.

use super::context::{EditContext, canonical, fault_error, with_loader};
use crate::files::error::FileError;
use crate::files::format::scene_file::{EntityFile, TransformFile};
use crate::files::format::validate::Validator;
use crate::world::{GameWorld, Transform};
use bevy_ecs::prelude::Entity;
use std::path::Path;

/// Makes an entity that is there an instance of a prefab. Its name becomes that of the file, with a number if need be.
///
/// # Errors
/// As [`spawn_entity`](super::entity::spawn_entity). The entity may then have some of the prefab's entities below it.
pub fn spawn_prefab_onto(
    world: &mut GameWorld,
    context: &mut EditContext,
    entity: Entity,
    prefab: &str,
    place: Transform,
) -> Result<(), FileError> {
    let stem = Path::new(prefab).file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    let parent = world.parent(entity);
    let name = world.unique_name(parent, stem.split('.').next().filter(|n| !n.is_empty()).unwrap_or("prefab"));
    let transform = Some(TransformFile::from(place));
    let mut file = EntityFile { name, transform, prefab: Some(prefab.to_owned()), ..Default::default() };
    Validator::lone_entity(&file, Vec::new()).map_err(|fault| fault_error(context.path, *fault))?;
    canonical(context, |canonical| canonical.entity(&mut file, &[]))?;
    with_loader(world, context, |loader, context| {
        loader.target = Some(entity);
        loader.entity(&file, context, parent, &[])
    })
}
