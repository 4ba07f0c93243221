//! From the world to the scene, by change detection.
//!
//! An entity that did not change costs nothing beyond the query that finds out. Arrays stay sorted by [`SceneId`]; a
//! value that was written but is the same takes no new revision.

mod cameras;
mod clpv;
mod context;
mod lights;
mod media;
mod method_settings;
mod motion;
mod origin;
mod particles;
mod primitives;
mod sky;
mod slc;
mod sorted;
#[cfg(test)]
mod tests;
mod vpl;

use super::{Revisions, Scene};
use crate::world::{GameWorld, UpdateCount};
use bevy_ecs::prelude::*;
use bevy_ecs::world::WorldId;
use context::{Context, Counter, Log};
use std::sync::atomic::{AtomicU64, Ordering};

/// Keeps a [`Scene`] current. One extractor serves one world and one scene; for another world or scene it restarts.
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
    particles: particles::Sources,
    lights: lights::Lights,
    media: media::Media,
    cameras: cameras::Cameras,
    clpv: clpv::Clpvs,
    vpl: vpl::Vpls,
    slc: slc::LightCullings,
    method_settings: method_settings::MethodSettingsReaders,
    sky: sky::Sky,
}

impl Source {
    fn new(world: &mut World) -> Self {
        Self {
            world: world.id(),
            updates: updates(world),
            anchor: origin::Anchor::new(world),
            primitives: primitives::Primitives::new(world),
            particles: particles::Sources::new(world),
            lights: lights::Lights::new(world),
            media: media::Media::new(world),
            cameras: cameras::Cameras::new(world),
            clpv: clpv::Clpvs::new(world),
            vpl: vpl::Vpls::new(world),
            slc: slc::LightCullings::new(world),
            method_settings: method_settings::MethodSettingsReaders::default(),
            sky: sky::Sky::new(world),
        }
    }
}

fn updates(world: &World) -> u64 {
    world.get_resource::<UpdateCount>().map_or(0, |count| count.0)
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

    /// Updates the scene from the world.
    pub fn extract(&mut self, game_world: &mut GameWorld, scene: &mut Scene) {
        let world = &mut game_world.ecs;
        let source = match self.source.take() {
            Some(source) if source.world == world.id() && scene.identity == self.identity => source,
            other => {
                if other.is_some() {
                    self.identity = fresh_identity();
                }
                *scene = Scene { identity: self.identity, ..Scene::default() };
                self.log.held.clear();
                Source::new(world)
            }
        };
        let mut source = source;
        let origin = source.anchor.origin(world);
        if origin != scene.origin {
            // All places change. In the first extraction nothing has been read yet.
            if scene.revisions != Revisions::default() {
                self.identity = fresh_identity();
                self.log.held.clear();
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
        source.particles.extract(world, scene, context);
        source.sky.find_sun(world);
        source.lights.extract(world, scene, context, source.sky.air());
        source.media.extract(world, scene, context);
        source.cameras.extract(world, scene, context);
        source.clpv.extract(world, scene, context);
        source.vpl.extract(world, scene, context);
        source.slc.extract(world, scene, context);
        source.method_settings.extract(world, scene, context);
        source.sky.extract(world, scene, context);
        self.log.write(scene);
    }
}

fn fresh_identity() -> u64 {
    static NEXT: AtomicU64 = AtomicU64::new(1);
    NEXT.fetch_add(1, Ordering::Relaxed)
}
