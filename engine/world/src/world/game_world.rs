//! The world that a game plays in.

use super::identity::{Identities, Identity};
use super::{Clock, Name, SceneSettings, Transform, WorldError};
use crate::core::SceneId;
use bevy_ecs::prelude::*;

/// Entities to despawn at the end of the frame. Systems push to it; [`GameWorld::despawn_later`] does the same.
#[derive(Resource, Debug, Default)]
pub struct DespawnQueue(pub(super) Vec<Entity>);

impl DespawnQueue {
    /// Despawns the entity and all below it at the end of the frame. Twice is once.
    pub fn push(&mut self, entity: Entity) {
        self.0.push(entity);
    }
}

/// Number of updates so far, so that whoever reads removals can tell that some have expired.
#[derive(Resource, Clone, Copy, Debug, Default)]
pub(crate) struct UpdateCount(pub u64);

/// Entities, their components, the clock and the systems that advance them from one frame to the next.
pub struct GameWorld {
    /// Entities, components and resources. Removal events expire with every second [`GameWorld::update`]; do not call
    /// `clear_trackers`, update does.
    pub ecs: World,
    pub(super) behaviours: Schedule,
    pub(super) frame: Schedule,
}

impl GameWorld {
    /// Spawns an entity with a name, an identity and a default [`Transform`]; components go in through
    /// [`GameWorld::ecs`]. The name should be new among the siblings: [`GameWorld::unique_name`] makes one. A parent
    /// that does not exist is taken for none.
    pub fn spawn(&mut self, name: &str, parent: Option<Entity>) -> Entity {
        let identity = self.ecs.resource_mut::<Identities>().fresh();
        self.spawn_as(identity, name, parent)
    }

    /// Gives an entity that is there a name, an identity and a place, as far as it has none.
    pub(crate) fn spawn_onto(&mut self, entity: Entity, name: &str) -> Entity {
        let identity = self.ecs.resource_mut::<Identities>().fresh();
        if let Ok(mut entity) = self.ecs.get_entity_mut(entity) {
            entity.insert((Name(name.to_owned()), identity)).insert_if_new(Transform::default());
        }
        entity
    }

    /// Spawns with a given identity, for undo and for whoever must keep the order.
    ///
    /// # Errors
    /// When a living entity holds that identity.
    pub fn spawn_with_id(&mut self, name: &str, parent: Option<Entity>, id: SceneId) -> Result<Entity, WorldError> {
        let claimed = self.ecs.resource_mut::<Identities>().claim(id);
        let identity = claimed.map_err(|holder| WorldError::IdentityTaken { id, holder: self.path(holder) })?;
        Ok(self.spawn_as(identity, name, parent))
    }

    fn spawn_as(&mut self, identity: Identity, name: &str, parent: Option<Entity>) -> Entity {
        let parent = parent.filter(|p| self.ecs.get_entity(*p).is_ok());
        let mut entity = self.ecs.spawn((Name(name.to_owned()), Transform::default(), identity));
        if let Some(parent) = parent {
            entity.insert(ChildOf(parent));
        }
        entity.id()
    }

    /// The living entity with an identity.
    pub fn entity(&self, id: SceneId) -> Option<Entity> {
        self.ecs.resource::<Identities>().holder(id)
    }

    /// The entity's identity.
    pub fn id(&self, entity: Entity) -> Option<SceneId> {
        self.ecs.get::<Identity>(entity).map(Identity::id)
    }

    /// Despawns the entity and all below it at the end of the frame, that is, of the next update.
    pub fn despawn_later(&mut self, entity: Entity) {
        self.ecs.resource_mut::<DespawnQueue>().push(entity);
    }

    /// The clock.
    pub fn clock(&self) -> Clock {
        *self.ecs.resource::<Clock>()
    }

    /// Sets the clock to a tick of [`SceneSettings::frame_rate`]. What follows from it comes with the next update.
    pub fn set_tick(&mut self, tick: u64) {
        let rate = self.ecs.resource::<SceneSettings>().frame_rate;
        self.ecs.insert_resource(Clock::at_tick(tick, rate));
    }

    /// Sets the clock to a time \[s\], which may lie between two ticks.
    pub fn set_seconds(&mut self, seconds: f64) {
        let rate = self.ecs.resource::<SceneSettings>().frame_rate;
        self.ecs.insert_resource(Clock::at_seconds(seconds, rate));
    }

    /// Advances the clock by some ticks.
    pub fn advance(&mut self, ticks: u64) {
        let rate = self.ecs.resource::<SceneSettings>().frame_rate;
        let clock = self.clock().with_rate(rate).advanced(ticks);
        self.ecs.insert_resource(clock);
    }

    /// Length of the scene's loop in ticks, rounded, at least one; none if it has none.
    pub fn loop_ticks(&self) -> Option<u64> {
        let settings = self.ecs.resource::<SceneSettings>();
        let duration = settings.duration.filter(|d| d.is_finite() && *d > 0.0)?;
        Some(((f64::from(duration) * f64::from(settings.frame_rate)).round() as u64).max(1))
    }
}
