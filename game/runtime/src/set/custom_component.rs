//! `--set ENTITY.Component.FIELD=VALUE`: components of a game.

use super::{changed_text, misfit};
use anyhow::{Result, bail};
use bevy_ecs::prelude::Entity;
use lightwell::files::{ComponentTypes, Source};
use lightwell::world::GameWorld;

/// Changes a component of the game; false if the entity has none of that name.
///
/// # Errors
/// If there is no such field, or the value does not fit it; or if this program does not know the component.
pub fn edit(world: &mut GameWorld, entity: Entity, name: &str, field: &str, value: &str) -> Result<bool> {
    let types = world.ecs.get_resource::<ComponentTypes>().cloned().unwrap_or_default();
    let Some(known) = types.get(name) else {
        let source = world.ecs.get::<Source>(entity);
        if source.is_some_and(|source| source.components.components.contains_key(name)) {
            bail!("`{name}` is a component of a game, which only the game's own program knows");
        }
        return Ok(false);
    };
    let Some(text) = known.text_of(&world.ecs, entity) else { return Ok(false) };
    let text = changed_text(&text?, field, value)?;
    known.insert(&text, &mut world.ecs, entity).map_err(|error| misfit(field, value, &error.code))?;
    Ok(true)
}

/// The components of the game that the entity has.
pub fn names(world: &GameWorld, entity: Entity) -> impl Iterator<Item = &'static str> {
    let types = world.ecs.get_resource::<ComponentTypes>();
    let known = types.into_iter().flat_map(|types| types.iter());
    let has = known.filter(|known| known.text_of(&world.ecs, entity).is_some());
    has.map(|known| known.name).collect::<Vec<_>>().into_iter()
}
