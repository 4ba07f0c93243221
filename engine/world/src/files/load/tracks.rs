//! References of animation tracks: clips of the entity's model, its descendants, morph targets.

use super::track_fields::{FieldTrack, Wrong};
use crate::files::error::{FileError, FileErrorKind as Kind};
use crate::files::ron::document::Document;
use crate::files::ron::steps::Fault;
use crate::files::ron::steps::{extended, fault_error, key};
use crate::files::ron::suggest::{nearest, suggestion};
use crate::files::ron::tree::Step;
use crate::world::animation::{KeyValue, Target, Track};
use crate::world::{Animation, Clips, GameWorld, MorphWeights, NotBelow};
use bevy_ecs::prelude::Entity;

/// Checks the entity's animation, once all below the entity is there. `at`: where the entity's components stand.
pub(in crate::files) fn check(
    world: &GameWorld,
    entity: Entity,
    document: &Document,
    at: &[Step],
) -> Result<(), FileError> {
    let Some(animation) = world.ecs.get::<Animation>(entity) else { return Ok(()) };
    let Some(mut fault) = fault(world, entity, animation) else { return Ok(()) };
    fault.path = extended(at, &fault.path);
    Err(fault_error(document, fault))
}

/// The first thing that is not there; its path begins at the entity's components.
pub(in crate::files) fn fault(world: &GameWorld, entity: Entity, animation: &Animation) -> Option<Fault> {
    let of = |(index, track): (usize, &Track)| {
        let wrong = match track {
            Track::Clip { name, .. } => clip_fault(world, entity, name)?,
            Track::Keys { node, target, keys, .. } => keys_fault(world, entity, node, target, keys)?,
            Track::Spin { .. } | Track::Orbit { .. } => return None,
        };
        let mut path = vec![key("animation"), key("tracks"), Step::Index(index)];
        path.extend(wrong.at);
        let message = format!("track {index}: {}", wrong.message);
        Some(Fault { path, kind: wrong.kind, message, help: wrong.help })
    };
    animation.tracks.iter().enumerate().find_map(of)
}

fn clip_fault(world: &GameWorld, entity: Entity, name: &str) -> Option<Wrong> {
    let clips = world.ecs.get::<Clips>(entity);
    if clips.is_some_and(|clips| clips.find(name).is_some()) {
        return None;
    }
    let names: Vec<&str> = clips.iter().flat_map(|clips| clips.0.iter().map(|clip| clip.name.as_str())).collect();
    let message = match names.is_empty() {
        true => "the model has no clips to play".to_owned(),
        false => format!("the model has no clip `{name}`"),
    };
    Some(Wrong::at("name", Kind::UnknownName, message, suggestion(name, names)))
}

fn keys_fault(
    world: &GameWorld,
    entity: Entity,
    node: &str,
    target: &Target,
    keys: &[(f64, KeyValue)],
) -> Option<Wrong> {
    let meant = match node {
        "" => Ok(entity),
        node => world.below(entity, node),
    };
    let meant = match meant {
        Ok(meant) => meant,
        Err(error) => return Some(Wrong::at("node", Kind::UnknownName, error.to_string(), advice(&error))),
    };
    if let Target::Field(path) = target {
        return FieldTrack { world, entity: meant, node, path, keys }.fault();
    }
    let Target::MorphWeight(index) = *target else { return None };
    let count = world.ecs.get::<MorphWeights>(meant).map_or(0, |weights| weights.0.len());
    if (index as usize) < count {
        return None;
    }
    let name = world.name(meant);
    let (message, help) = match count {
        0 => {
            (format!("`{name}` has no morph targets"), "name the node of the model that has them: `node: \"…\"`".into())
        }
        1 => (format!("`{name}` has one morph target, number 0"), "use MorphWeight(0)".into()),
        _ => (
            format!("`{name}` has no morph target {index}, but {count}, counted from 0"),
            format!("use MorphWeight(0) to MorphWeight({})", count - 1),
        ),
    };
    Some(Wrong::at("target", Kind::UnknownName, message, Some(help)))
}

fn advice(error: &NotBelow) -> Option<String> {
    match error {
        NotBelow::Missing { name, known, .. } => {
            let last = |path: &'_ str| path.rsplit('/').next().unwrap_or_default().to_owned();
            let names: Vec<String> = known.iter().map(|path| last(path)).collect();
            // Of a bare name a bare name is nearer than a long path that ends in it.
            let near = nearest(name, names.iter().map(String::as_str)).map(|near| format!("did you mean `{near}`?"));
            near.filter(|_| !name.contains('/')).or_else(|| suggestion(name, known.iter().map(String::as_str)))
        }
        NotBelow::Ambiguous { first, .. } => Some(format!("write the path of names from here, such as `{first}`")),
    }
}
