//! Hidden copies of entities, from which an editor restores them: components of every type that
//! is `Clone`, those of the game too, under the same identities.

use super::identity::{Identities, Identity, RootOrder};
use super::{GameWorld, WorldError};
use crate::core::SceneId;
use bevy_ecs::component::ComponentId;
use bevy_ecs::entity::EntityCloner;
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::prelude::*;
use std::collections::HashSet;

/// The identity of the entity that was copied.
#[derive(Component, Clone, Copy, Debug)]
struct SnapshotId(SceneId);

/// A copy of an entity that no query sees and nothing draws. It lasts until [`GameWorld::drop_snapshot`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EntitySnapshot(Entity);

impl GameWorld {
    /// Copies an entity out of sight; with all below it if `deep`.
    ///
    /// # Errors
    /// When the entity does not exist.
    pub fn snapshot(&mut self, entity: Entity, deep: bool) -> Result<EntitySnapshot, WorldError> {
        self.ecs.get_entity(entity).map_err(|_| WorldError::Missing(entity))?;
        let copy = if deep {
            let mut cloner = EntityCloner::build_opt_out(&mut self.ecs);
            cloner.linked_cloning(true);
            let mut cloner = cloner.finish();
            cloner.spawn_clone(&mut self.ecs, entity)
        } else {
            let mut cloner = EntityCloner::build_opt_out(&mut self.ecs);
            cloner.deny::<(ChildOf, Children)>();
            let mut cloner = cloner.finish();
            cloner.spawn_clone(&mut self.ecs, entity)
        };
        self.ecs.entity_mut(copy).remove::<ChildOf>();
        for (original, copy) in self.pairs(entity, copy) {
            let id = self.id(original).unwrap_or_default();
            self.ecs.entity_mut(copy).insert((SnapshotId(id), Disabled));
        }
        Ok(EntitySnapshot(copy))
    }

    /// Spawns what was snapshotted, with all below it, under a parent as the child of that number, and with the
    /// identities that it had.
    ///
    /// # Errors
    /// When a living entity holds one of the identities; nothing is spawned then.
    pub fn put_back(
        &mut self,
        snapshot: EntitySnapshot,
        parent: Option<Entity>,
        index: usize,
    ) -> Result<Entity, WorldError> {
        for entity in self.subtree(snapshot.0) {
            let id = self.ecs.get::<SnapshotId>(entity).map(|s| s.0).unwrap_or_default();
            if let Some(holder) = self.entity(id) {
                return Err(WorldError::IdentityTaken { id, holder: self.path(holder) });
            }
        }
        let mut cloner = EntityCloner::build_opt_out(&mut self.ecs);
        cloner.linked_cloning(true);
        let mut cloner = cloner.finish();
        let entity = cloner.spawn_clone(&mut self.ecs, snapshot.0);
        for entity in self.subtree(entity) {
            let Some(SnapshotId(id)) = self.ecs.entity_mut(entity).take::<SnapshotId>() else { continue };
            let identity = self.ecs.resource_mut::<Identities>().claim(id);
            let Ok(identity) = identity else { continue };
            self.ecs.entity_mut(entity).remove::<Disabled>().insert(identity);
        }
        if let Some(parent) = parent.filter(|p| self.ecs.get_entity(*p).is_ok()) {
            let index = index.min(self.children(parent).len());
            self.ecs.entity_mut(parent).insert_children(index, &[entity]);
        }
        Ok(entity)
    }

    /// Makes the components of a living entity those of a snapshotted one. Parent, children and identity stay.
    ///
    /// # Errors
    /// When the entity does not exist.
    pub fn copy_from_snapshot(&mut self, snapshot: EntitySnapshot, entity: Entity) -> Result<(), WorldError> {
        self.ecs.get_entity(entity).map_err(|_| WorldError::Missing(entity))?;
        let kept = self.kept_components();
        let wanted: HashSet<ComponentId> = self.component_ids(snapshot.0).collect();
        let surplus: Vec<ComponentId> =
            self.component_ids(entity).filter(|id| !wanted.contains(id) && !kept.contains(id)).collect();
        self.ecs.entity_mut(entity).remove_by_ids(&surplus);
        let mut cloner = EntityCloner::build_opt_out(&mut self.ecs);
        cloner.deny::<(ChildOf, Children, RootOrder, SnapshotId, Disabled)>();
        let mut cloner = cloner.finish();
        cloner.clone_entity(&mut self.ecs, snapshot.0, entity);
        Ok(())
    }

    /// Lets go of a copy.
    pub fn drop_snapshot(&mut self, snapshot: EntitySnapshot) {
        // Gone already if it was dropped before.
        let _ = self.ecs.try_despawn(snapshot.0);
    }

    /// The entity and all below it, parents first.
    pub fn subtree(&self, root: Entity) -> Vec<Entity> {
        let mut found = vec![root];
        let mut next = 0;
        while next < found.len() {
            found.extend(self.children(found[next]));
            next += 1;
        }
        found
    }

    fn pairs(&self, a: Entity, b: Entity) -> Vec<(Entity, Entity)> {
        let mut found = vec![(a, b)];
        let mut next = 0;
        while next < found.len() {
            let (a, b) = found[next];
            found.extend(self.children(a).into_iter().zip(self.children(b)));
            next += 1;
        }
        found
    }

    fn component_ids(&self, entity: Entity) -> impl Iterator<Item = ComponentId> + use<> {
        let ids = self.ecs.get_entity(entity).map(|e| e.archetype().components().to_vec()).unwrap_or_default();
        ids.into_iter()
    }

    fn kept_components(&mut self) -> [ComponentId; 4] {
        [
            self.ecs.register_component::<ChildOf>(),
            self.ecs.register_component::<Children>(),
            self.ecs.register_component::<Identity>(),
            self.ecs.register_component::<RootOrder>(),
        ]
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::world::{Light, Transform};
    use glam::Vec3;

    fn family() -> (GameWorld, [Entity; 4]) {
        let mut world = GameWorld::new();
        let root = world.spawn("root", None);
        let [a, b] = ["a", "b"].map(|name| world.spawn(name, Some(root)));
        let below = world.spawn("below", Some(a));
        world.ecs.entity_mut(below).insert(Light::default());
        world.update();
        (world, [root, a, b, below])
    }

    #[test]
    fn what_was_despawned_comes_back_in_its_place() {
        let (mut world, [root, a, b, below]) = family();
        let ids = [a, below].map(|e| world.id(e).unwrap());
        let snapshot = world.snapshot(a, true).unwrap();
        assert_eq!(world.children(root), [a, b]);
        assert_eq!(world.roots(), [root], "a snapshot is no root");
        world.despawn_later(a);
        world.update();
        assert_eq!((world.children(root), world.entity(ids[0])), (vec![b], None));
        let again = world.put_back(snapshot, Some(root), 0).unwrap();
        world.update();
        assert_eq!(world.children(root), [again, b]);
        assert_eq!(ids.map(|id| world.path(world.entity(id).unwrap())), ["root/a", "root/a/below"]);
        let light = world.entity(ids[1]).unwrap();
        assert_eq!(world.ecs.get::<Light>(light), Some(&Light::default()));
        assert!(world.put_back(snapshot, Some(root), 0).is_err(), "its identity is taken");
    }

    #[test]
    fn components_are_copied_and_those_that_came_later_go() {
        let (mut world, [root, a, ..]) = family();
        let snapshot = world.snapshot(a, false).unwrap();
        let id = world.id(a);
        let moved = Transform { translation: Vec3::ONE, ..Transform::default() };
        world.ecs.entity_mut(a).insert((moved, Light::default()));
        world.copy_from_snapshot(snapshot, a).unwrap();
        world.update();
        assert_eq!(world.ecs.get::<Transform>(a), Some(&Transform::default()));
        assert!(world.ecs.get::<Light>(a).is_none());
        assert_eq!((world.id(a), world.parent(a), world.children(a).len()), (id, Some(root), 1));
    }

    #[test]
    fn snapshots_are_seen_by_no_query() {
        let (mut world, [root, ..]) = family();
        let count = |world: &mut GameWorld| world.ecs.query::<&Light>().iter(&world.ecs).count();
        let before = count(&mut world);
        let snapshot = world.snapshot(root, true).unwrap();
        world.update();
        assert_eq!(count(&mut world), before);
        world.drop_snapshot(snapshot);
        world.drop_snapshot(snapshot);
        assert_eq!(count(&mut world), before);
    }
}
