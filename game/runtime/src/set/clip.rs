//! `--set clip=NAME`: which clip the scene's model plays.

use anyhow::{Result, bail};
use bevy_ecs::prelude::Entity;
use lightwell::world::animation::{Track, Wrap};
use lightwell::world::{Animation, Clips, GameWorld, SceneSettings};

/// Lets the first model that has clips play one of them. If the scene's loop is as long as the clip played so far, it
/// becomes as long as this one.
///
/// # Errors
/// If no model has clips, or the model has no such clip, with those that there are.
pub fn apply(world: &mut GameWorld, name: &str) -> Result<()> {
    let mut query = world.ecs.query::<(Entity, &Clips)>();
    let Some((entity, clips)) = query.iter(&world.ecs).min_by_key(|(entity, _)| *entity) else {
        bail!("no model of the scene has clips");
    };
    let clips = clips.clone();
    let name = name.trim_matches('"');
    let Some(clip) = clips.find(name) else {
        let known: Vec<&str> = clips.0.iter().map(|clip| clip.name.as_str()).collect();
        bail!("the model has no clip `{name}`; it has {}", known.join(", "));
    };
    let mut animation = world.ecs.get::<Animation>(entity).cloned().unwrap_or_default();
    let played = animation.tracks.iter_mut().find_map(|track| match track {
        Track::Clip { name, .. } => Some(name),
        _ => None,
    });
    let before = played.as_ref().and_then(|name| clips.find(name)).map(|clip| clip.duration as f32);
    match played {
        Some(played) => *played = clip.name.clone(),
        None => {
            animation.tracks.push(Track::Clip { name: clip.name.clone(), speed: 1.0, offset: 0.0, wrap: Wrap::Loop });
        }
    }
    world.ecs.entity_mut(entity).insert(animation);
    let mut settings = world.ecs.resource_mut::<SceneSettings>();
    if settings.duration == before && clip.duration > 0.0 {
        settings.duration = Some(clip.duration as f32);
    }
    Ok(())
}
