//! Entities below one that animates them: nodes of its model, parts of its prefab, by their names.

use super::animation::{Animation, Track};
use super::rest_pose::RestPose;
use super::{GameWorld, Name};
use bevy_ecs::prelude::*;
use std::collections::{BTreeMap, VecDeque};

/// An entity that tracks of entities above it are for: who they are, and the name by which each calls it. The nearest
/// comes first.
#[derive(Component, Clone, Debug, Default, PartialEq, Eq)]
#[component(clone_behavior = Ignore)]
#[require(RestPose)]
pub(super) struct TrackTarget(pub Vec<(Entity, String)>);

/// Why there is no entity below another by a name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NotBelow {
    /// None is called so.
    #[error("there is no `{name}` below `{above}`")]
    Missing {
        /// The name or path.
        name: String,
        /// Name of the entity above.
        above: String,
        /// Paths of the entities below it.
        known: Vec<String>,
    },
    /// Several are called so.
    #[error("{count} entities below `{above}` are named `{name}`")]
    Ambiguous {
        /// The name.
        name: String,
        /// Name of the entity above.
        above: String,
        /// How many.
        count: usize,
        /// Path of the first.
        first: String,
    },
}

/// Names and children of entities.
type Family = (Option<&'static Name>, Option<&'static Children>);

/// Entities below one with their paths from there, the nearest first.
fn below<'w>(
    top: Entity,
    look: impl Fn(Entity) -> Option<(Option<&'w Name>, Option<&'w Children>)>,
) -> Vec<(Entity, String)> {
    let mut found = Vec::new();
    let mut open = VecDeque::from([(top, String::new())]);
    while let Some((entity, path)) = open.pop_front() {
        let Some((_, Some(children))) = look(entity) else { continue };
        for child in children.iter() {
            let name = look(child).and_then(|(name, _)| name).map_or("", |name| name.0.as_str());
            let path = if path.is_empty() { name.to_owned() } else { format!("{path}/{name}") };
            found.push((child, path.clone()));
            open.push_back((child, path));
        }
    }
    found
}

/// The entity of a path, or the only one of a name.
fn pick(all: &[(Entity, String)], name: &str, above: &str) -> Result<Entity, NotBelow> {
    if let Some((entity, _)) = all.iter().find(|(_, path)| path == name) {
        return Ok(*entity);
    }
    let named = |path: &str| path.rsplit('/').next() == Some(name);
    let same: Vec<&(Entity, String)> = all.iter().filter(|(_, path)| named(path)).collect();
    let (name, above) = (name.to_owned(), above.to_owned());
    match same[..] {
        [(entity, _)] => Ok(*entity),
        [(_, first), ..] => Err(NotBelow::Ambiguous { name, above, count: same.len(), first: first.clone() }),
        [] => Err(NotBelow::Missing { name, above, known: all.iter().map(|(_, path)| path.clone()).collect() }),
    }
}

impl GameWorld {
    /// The entity below another one by its path of names from there, `hip/knee`, or by a name that only one there has.
    ///
    /// # Errors
    /// If there is none, or there are several of that name and no path.
    pub fn below(&self, entity: Entity, name: &str) -> Result<Entity, NotBelow> {
        let look = |entity: Entity| Some((self.ecs.get::<Name>(entity), self.ecs.get::<Children>(entity)));
        pick(&below(entity, look), name, self.name(entity))
    }
}

/// Entities whose change may change the targets of tracks.
type Regrouped = Or<(Changed<Animation>, Changed<Name>, Changed<Children>)>;

/// Finds the entities that tracks are for.
pub(super) fn bind(
    mut commands: Commands,
    players: Query<(Entity, Ref<Animation>)>,
    regrouped: Query<(), Regrouped>,
    mut gone: RemovedComponents<Animation>,
    bound: Query<(Entity, &TrackTarget)>,
    family: Query<Family>,
    parents: Query<&ChildOf>,
) {
    let any_gone = gone.read().count() > 0;
    let is_quiet = regrouped.is_empty() && !any_gone;
    let callers = players.iter().filter(|(_, animation)| animation.tracks.iter().any(|track| !track.node().is_empty()));
    let mut callers: Vec<(Entity, Ref<Animation>)> = callers.collect();
    if is_quiet || (callers.is_empty() && bound.is_empty()) {
        return;
    }
    // The nearest come first, so that those above have the last word.
    callers.sort_by_cached_key(|(entity, _)| std::cmp::Reverse(parents.iter_ancestors(*entity).count()));
    let mut wanted: BTreeMap<Entity, TrackTarget> = BTreeMap::new();
    for (player, animation) in &callers {
        let all = below(*player, |entity| family.get(entity).ok());
        let name = family.get(*player).ok().and_then(|(name, _)| name).map_or("", |name| name.0.as_str());
        for called in animation.tracks.iter().map(Track::node).filter(|called| !called.is_empty()) {
            match pick(&all, called, name) {
                Ok(entity) => {
                    let target = &mut wanted.entry(entity).or_default().0;
                    let call = (*player, called.to_owned());
                    if !target.contains(&call) {
                        target.push(call);
                    }
                }
                Err(error) if animation.is_changed() => log::warn!("a track of keys is not played: {error}"),
                Err(_) => {}
            }
        }
    }
    for (entity, target) in &bound {
        match wanted.remove(&entity) {
            Some(now) if now == *target => {}
            Some(now) => drop(commands.entity(entity).insert(now)),
            None => drop(commands.entity(entity).remove::<TrackTarget>()),
        }
    }
    for (entity, target) in wanted {
        commands.entity(entity).insert(target);
    }
}
