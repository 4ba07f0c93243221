//! From the world to the scene, by change detection.
//!
//! An entity that did not change costs nothing beyond the query that finds out. Arrays stay sorted by [`SceneId`]; a
//! value that was written but is the same takes no new revision.

mod cameras;
mod clpv;
mod lights;
mod motion;
mod origin;
mod primitives;
mod slc;
mod sorted;
#[cfg(test)]
mod tests;
mod vpl;

use super::Scene;
use crate::assets::SkyMap;
use crate::world::{Environment, EnvironmentImage, GameWorld, Name, SceneSettings, UpdateCount};
use bevy_ecs::prelude::*;
use bevy_ecs::world::WorldId;
use glam::Vec3;
use std::collections::HashSet;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Keeps a [`Scene`] current. One extractor serves one world and one scene; for another world or scene it starts anew.
///
/// Runs once after every [`GameWorld::update`], paused or not.
pub struct Extractor {
    log: Log,
    revisions: Counter,
    identity: u64,
    source: Option<Source>,
}

/// The world that is read, and what is remembered of it.
struct Source {
    world: WorldId,
    updates: u64,
    anchor: origin::Anchor,
    primitives: primitives::Primitives,
    lights: lights::Lights,
    cameras: cameras::Cameras,
    clpv: clpv::Clpvs,
    vpl: vpl::Vpls,
    slc: slc::LightCullings,
    environment: Known,
}

/// The environment that the scene's map was made of, and the loaded image that it was made with.
#[derive(Default)]
struct Known {
    environment: Option<Environment>,
    image: Option<Arc<SkyMap>>,
}

impl Source {
    fn new(world: &mut World) -> Self {
        Self {
            world: world.id(),
            updates: updates(world),
            anchor: origin::Anchor::new(world),
            primitives: primitives::Primitives::new(world),
            lights: lights::Lights::new(world),
            cameras: cameras::Cameras::new(world),
            clpv: clpv::Clpvs::new(world),
            vpl: vpl::Vpls::new(world),
            slc: slc::LightCullings::new(world),
            environment: Known::default(),
        }
    }
}

fn updates(world: &World) -> u64 {
    world.get_resource::<UpdateCount>().map_or(0, |count| count.0)
}

/// The revision counter of a scene.
#[derive(Debug, Default)]
struct Counter(u64);

impl Counter {
    fn next(&mut self) -> u64 {
        self.0 += 1;
        self.0
    }
}

/// Warnings, each given once an entity.
#[derive(Debug, Default)]
struct Log(HashSet<(Entity, &'static str)>);

impl Log {
    fn warn(&mut self, entity: Entity, name: Option<&Name>, message: &'static str) {
        if self.0.insert((entity, message)) {
            log::warn!("`{}`: {message}", name_or_id(entity, name));
        }
    }

    /// Forgets an entity, so that it is warned of again.
    fn forget(&mut self, entity: Entity) {
        if !self.0.is_empty() {
            self.0.retain(|(e, _)| *e != entity);
        }
    }
}

fn name_or_id(entity: Entity, name: Option<&Name>) -> String {
    name.map_or_else(|| entity.to_string(), |n| n.0.clone())
}

/// What the parts of an extraction share.
struct Context<'a> {
    log: &'a mut Log,
    revisions: &'a mut Counter,
    /// Removal events may have expired: look whether everything is still there.
    is_late: bool,
}

impl Default for Extractor {
    fn default() -> Self {
        Self::new()
    }
}

impl Extractor {
    /// An extractor with a scene identity of its own.
    pub fn new() -> Self {
        Self { log: Log::default(), revisions: Counter::default(), identity: fresh_identity(), source: None }
    }

    /// Brings the scene up to date with the world.
    pub fn extract(&mut self, game_world: &mut GameWorld, scene: &mut Scene) {
        let world = &mut game_world.ecs;
        let source = match self.source.take() {
            Some(source) if source.world == world.id() && scene.identity == self.identity => source,
            other => {
                if other.is_some() {
                    self.identity = fresh_identity();
                }
                *scene = Scene { identity: self.identity, ..Scene::default() };
                Source::new(world)
            }
        };
        let mut source = source;
        let origin = source.anchor.origin(world);
        if origin != scene.origin {
            // All places change.
            if !scene.primitives.is_empty() {
                self.identity = fresh_identity();
                source = Source::new(world);
            }
            *scene = Scene { identity: self.identity, origin, ..Scene::default() };
        }
        let source = self.source.insert(source);
        let now = updates(world);
        let is_late = now > source.updates + 1;
        source.updates = now;
        let context = &mut Context { log: &mut self.log, revisions: &mut self.revisions, is_late };
        source.primitives.extract(world, scene, context);
        source.lights.extract(world, scene, context);
        source.cameras.extract(world, scene, context);
        source.clpv.extract(world, scene, context);
        source.vpl.extract(world, scene, context);
        source.slc.extract(world, scene, context);
        extract_sky(world, scene, &mut source.environment, context.revisions);
    }
}

fn fresh_identity() -> u64 {
    static NEXT: AtomicU64 = AtomicU64::new(1);
    NEXT.fetch_add(1, Ordering::Relaxed)
}

/// Keeps the sky current; a map is made anew only if the environment changed.
fn extract_sky(world: &World, scene: &mut Scene, known: &mut Known, revisions: &mut Counter) {
    let settings = world.get_resource::<SceneSettings>();
    scene.sky_light = settings.is_none_or(|s| s.sky_light);
    let environment = settings.and_then(|s| s.environment.clone());
    let loaded = world.get_resource::<EnvironmentImage>();
    let map = environment.as_ref().and_then(|environment| loaded.and_then(|image| image.map_for(environment)));
    let is_stale = map.is_some_and(|map| known.image.as_ref().is_none_or(|known| !Arc::ptr_eq(map, known)));
    if known.environment != environment || is_stale {
        scene.sky_map = match &environment {
            Some(Environment::Gradient { zenith, horizon, ground }) => {
                Some(Arc::new(SkyMap::gradient(*zenith, *horizon, *ground)))
            }
            Some(Environment::Image { file, .. }) => {
                if map.is_none() {
                    log::warn!("the sky's image {file} is not loaded: load the scene again from its file");
                }
                environment.as_ref().and_then(|environment| loaded?.made_for(environment))
            }
            None => None,
        };
        *known = Known { image: map.cloned(), environment };
        scene.sky = scene.sky_map.as_ref().map_or(Vec3::ZERO, |map| map.mean());
        scene.revisions.settings = revisions.next();
    }
    if scene.sky_map.is_some() {
        return;
    }
    let wanted = settings.map_or(Vec3::ZERO, |s| s.sky);
    let sky = if wanted.is_finite() && wanted.cmpge(Vec3::ZERO).all() { wanted } else { Vec3::ZERO };
    if sky != scene.sky || scene.revisions.settings == 0 {
        if sky != wanted {
            log::warn!("the sky's radiance {wanted} is negative or not finite; it is black now");
        }
        scene.sky = sky;
        scene.revisions.settings = revisions.next();
    }
}
