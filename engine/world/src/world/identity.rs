//! Persistent identities of entities.

use crate::core::SceneId;
use bevy_ecs::lifecycle::HookContext;
use bevy_ecs::prelude::*;
use bevy_ecs::world::DeferredWorld;
use std::collections::HashMap;

use super::Transform;

/// The entity's persistent identity. Given by the world when the entity is spawned; never changed, never reused and
/// not cloned. Entities spawned through the ECS alone get theirs in the next update.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[component(immutable, clone_behavior = Ignore, on_insert = register, on_discard = unregister)]
pub struct Identity(SceneId);

impl Identity {
    /// The identity's value.
    pub fn id(&self) -> SceneId {
        self.0
    }
}

/// Stands in for the identity in the order of entities without a parent: those of a scene that was reloaded have the
/// identities of before and the order of the file, before all that have none.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct RootOrder(pub u64);

/// The counter that identities come from, and who holds which.
#[derive(Resource, Debug, Default)]
pub(super) struct Identities {
    pub(super) last: u64,
    holders: HashMap<SceneId, Entity>,
}

impl Identities {
    /// An identity that no entity of this world has or had.
    pub fn fresh(&mut self) -> Identity {
        self.last += 1;
        Identity(SceneId(self.last))
    }

    /// Takes a given identity, unless an entity holds it.
    pub fn claim(&mut self, id: SceneId) -> Result<Identity, Entity> {
        match self.holders.get(&id) {
            Some(holder) => Err(*holder),
            None => {
                self.last = self.last.max(id.0);
                Ok(Identity(id))
            }
        }
    }

    /// Who holds the identity.
    pub fn holder(&self, id: SceneId) -> Option<Entity> {
        self.holders.get(&id).copied()
    }
}

fn register(mut world: DeferredWorld, context: HookContext) {
    let Some(id) = world.get::<Identity>(context.entity).map(Identity::id) else { return };
    if let Some(mut identities) = world.get_resource_mut::<Identities>() {
        identities.holders.insert(id, context.entity);
    }
}

fn unregister(mut world: DeferredWorld, context: HookContext) {
    let Some(id) = world.get::<Identity>(context.entity).map(Identity::id) else { return };
    if let Some(mut identities) = world.get_resource_mut::<Identities>() {
        identities.holders.remove(&id);
    }
}

type Unidentified = (With<Transform>, Without<Identity>);

/// Gives identities to entities that were spawned through the ECS alone, by their index.
pub(super) fn identify(
    mut commands: Commands,
    mut identities: ResMut<Identities>,
    unidentified: Query<Entity, Unidentified>,
) {
    if unidentified.is_empty() {
        return;
    }
    let mut entities: Vec<Entity> = unidentified.iter().collect();
    entities.sort_unstable_by_key(|e| e.index());
    for entity in entities {
        commands.entity(entity).insert(identities.fresh());
    }
}
