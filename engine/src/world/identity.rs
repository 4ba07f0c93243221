//! Persistent identities of entities.

use crate::core::SceneId;
use bevy_ecs::lifecycle::HookContext;
use bevy_ecs::prelude::*;
use bevy_ecs::world::DeferredWorld;
use std::collections::{HashMap, VecDeque};

use super::{GameWorld, Transform};

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

impl GameWorld {
    /// The identities of all entities by their paths.
    pub fn identities(&self) -> PathIdentities {
        let mut known = PathIdentities::default();
        self.walk(|path, name, entity| {
            let next = known.paths.len();
            let (number, id) = known.paths.entry((path, name.to_owned())).or_insert((next, None));
            *id = self.id(entity).or(*id);
            Some(*number)
        });
        known
    }

    /// Visits all entities, parents first, with the number of their parent's path and their name. `visit` returns the number of
    /// the entity's own path, or `None` if its descendants are of no interest.
    fn walk(&self, mut visit: impl FnMut(Option<usize>, &str, Entity) -> Option<usize>) {
        let mut open: VecDeque<(Option<usize>, Entity)> = self.roots().into_iter().map(|root| (None, root)).collect();
        while let Some((path, entity)) = open.pop_front() {
            if let Some(number) = visit(path, self.name(entity), entity) {
                open.extend(self.children(entity).into_iter().map(|child| (Some(number), child)));
            }
        }
    }

    /// Gives none of these identities to new entities, so that [`GameWorld::take_over`] can.
    pub fn reserve(&mut self, identities: impl IntoIterator<Item = SceneId>) {
        let last = identities.into_iter().map(|id| id.0).max().unwrap_or(0);
        let mut known = self.ecs.resource_mut::<Identities>();
        known.last = known.last.max(last);
    }

    /// Gives entities the identities that others had at the same paths, which must be gone. Entities without a parent
    /// keep their order.
    pub fn take_over(&mut self, identities: &PathIdentities) {
        for (order, root) in self.roots().into_iter().enumerate() {
            self.ecs.entity_mut(root).insert(RootOrder(order as u64));
        }
        let mut found = Vec::new();
        self.walk(|path, name, entity| {
            let (number, id) = identities.paths.get(&(path, name.to_owned()))?;
            found.extend(id.map(|id| (entity, id)));
            Some(*number)
        });
        for (entity, id) in found {
            if let Ok(identity) = self.ecs.resource_mut::<Identities>().claim(id) {
                self.ecs.entity_mut(entity).insert(identity);
            }
        }
    }
}

/// The identities of a world's entities by their paths. Each path is kept as the number of its parent's and a name, so that deep
/// hierarchies take no more memory than flat ones.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PathIdentities {
    paths: HashMap<(Option<usize>, String), (usize, Option<SceneId>)>,
}

impl PathIdentities {
    /// All identities, in no order.
    pub fn ids(&self) -> impl Iterator<Item = SceneId> + '_ {
        self.paths.values().filter_map(|(_, id)| *id)
    }
}

/// The counter that identities come from, and who holds which.
#[derive(Resource, Debug, Default)]
pub(super) struct Identities {
    last: u64,
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
