//! Parents and children by bevy's own relations: look-up by name, new parents, clones of subtrees.

use super::identity::{Identities, Identity, RootOrder};
use super::{GameWorld, Name, WorldError};
use crate::core::SceneId;
use bevy_ecs::entity::EntityCloner;
use bevy_ecs::prelude::*;

impl GameWorld {
    /// Entities without a parent, by identity.
    pub fn roots(&self) -> Vec<Entity> {
        roots(&self.ecs)
    }

    /// The entity's children, in their order.
    pub fn children(&self, entity: Entity) -> Vec<Entity> {
        children(&self.ecs, entity)
    }

    /// The entity's parent.
    pub fn parent(&self, entity: Entity) -> Option<Entity> {
        self.ecs.get::<ChildOf>(entity).map(ChildOf::parent)
    }

    /// The first child of a name.
    pub fn child(&self, parent: Entity, name: &str) -> Option<Entity> {
        let children = self.ecs.get::<Children>(parent)?;
        children.iter().find(|child| self.name(*child) == name)
    }

    /// The entity's name; empty if it has none.
    pub fn name(&self, entity: Entity) -> &str {
        self.ecs.get::<Name>(entity).map_or("", |n| n.0.as_str())
    }

    /// The entity at a path of names from a root, separated by `/`: `lamp/bulb`.
    pub fn find(&self, path: &str) -> Option<Entity> {
        let mut names = path.split('/');
        let first = names.next()?;
        let root = self.roots().into_iter().find(|root| self.name(*root) == first)?;
        names.try_fold(root, |parent, name| self.child(parent, name))
    }

    /// The entity's path of names, as [`GameWorld::find`] takes it.
    pub fn path(&self, entity: Entity) -> String {
        let mut names: Vec<&str> =
            std::iter::successors(Some(entity), |e| self.parent(*e)).map(|e| self.name(e)).collect();
        names.reverse();
        names.join("/")
    }

    /// The name, or the name with the first number from 2 that makes it new among the parent's children (among the
    /// roots if there is no parent).
    pub fn unique_name(&self, parent: Option<Entity>, name: &str) -> String {
        unique_name(&self.ecs, parent, name, None)
    }

    /// Gives the entity another parent, or none. Its transform stays and is relative to the new parent from then
    /// on. The name becomes a new one if the new siblings have it already.
    ///
    /// # Errors
    /// When one of them does not exist, or the parent stands below the child.
    pub fn set_parent(&mut self, child: Entity, parent: Option<Entity>) -> Result<(), WorldError> {
        for entity in [Some(child), parent].into_iter().flatten() {
            self.ecs.get_entity(entity).map_err(|_| WorldError::Missing(entity))?;
        }
        if self.parent(child) == parent {
            return Ok(());
        }
        if let Some(parent) = parent.filter(|p| stands_below(&self.ecs, *p, child)) {
            return Err(WorldError::Cycle { child: self.path(child), parent: self.path(parent) });
        }
        let name = self.ecs.get::<Name>(child).map(|n| self.unique_name(parent, &n.0));
        let mut child = self.ecs.entity_mut(child);
        if let Some(name) = name.filter(|n| child.get::<Name>().is_some_and(|old| old.0 != *n)) {
            child.insert(Name(name));
        }
        match parent {
            Some(parent) => child.insert(ChildOf(parent)),
            None => child.remove::<ChildOf>(),
        };
        Ok(())
    }

    /// Clones the entity with all below it: every component that is `Clone`, those of the game too. The clone stands
    /// beside the original under the same parent; it has new identities, and its root a new name.
    ///
    /// # Errors
    /// When the entity does not exist.
    pub fn clone_subtree(&mut self, entity: Entity) -> Result<Entity, WorldError> {
        self.ecs.get_entity(entity).map_err(|_| WorldError::Missing(entity))?;
        let clone = self.ecs.spawn_empty().id();
        clone_onto(&mut self.ecs, entity, clone)?;
        Ok(clone)
    }
}

/// Makes an entity a copy of another one with all below it, as [`GameWorld::clone_subtree`] does.
pub(crate) fn clone_onto(ecs: &mut World, entity: Entity, clone: Entity) -> Result<(), WorldError> {
    for entity in [entity, clone] {
        ecs.get_entity(entity).map_err(|_| WorldError::Missing(entity))?;
    }
    let name = ecs.get::<Name>(entity).map(|n| n.0.clone());
    let parent = ecs.get::<ChildOf>(entity).map(ChildOf::parent);
    let mut cloner = EntityCloner::build_opt_out(ecs);
    cloner.linked_cloning(true);
    let mut cloner = cloner.finish();
    cloner.clone_entity(ecs, entity, clone);
    if let Some(name) = name {
        let name = unique_name(ecs, parent, &name, Some(clone));
        ecs.entity_mut(clone).insert(Name(name));
    }
    let mut pending = vec![clone];
    while let Some(entity) = pending.pop() {
        let identity = ecs.resource_mut::<Identities>().fresh();
        ecs.entity_mut(entity).insert(identity);
        pending.extend(children(ecs, entity).into_iter().rev());
    }
    Ok(())
}

/// Despawns an entity with all below it, whatever the depth: bevy goes down by recursion, so that deep hierarchies are taken away
/// in pieces, the lowest first. What is gone already is left alone.
pub(crate) fn despawn(ecs: &mut World, entity: Entity) {
    const DEPTH: usize = 64;
    let (mut level, mut tops, mut depth) = (vec![entity], Vec::new(), 0);
    while !level.is_empty() {
        if depth % DEPTH == 0 {
            tops.extend(&level);
        }
        level = level.into_iter().flat_map(|entity| children(ecs, entity)).collect();
        depth += 1;
    }
    for top in tops.into_iter().rev() {
        let _ = ecs.try_despawn(top);
    }
}

fn children(ecs: &World, entity: Entity) -> Vec<Entity> {
    ecs.get::<Children>(entity).map(|c| c.to_vec()).unwrap_or_default()
}

fn roots(ecs: &World) -> Vec<Entity> {
    type Roots = (&'static Identity, Option<&'static RootOrder>, Entity);
    let Some(mut query) = ecs.try_query_filtered::<Roots, Without<ChildOf>>() else {
        return Vec::new();
    };
    let seat = |id: SceneId, order: Option<&RootOrder>| (order.is_none(), order.map_or(id.0, |order| order.0), id);
    let mut roots: Vec<_> = query.iter(ecs).map(|(i, order, e)| (seat(i.id(), order), e)).collect();
    roots.sort_unstable();
    roots.into_iter().map(|(_, entity)| entity).collect()
}

/// The name, or the name with the first number from 2 that makes it new among the siblings, `own` not counted.
fn unique_name(ecs: &World, parent: Option<Entity>, name: &str, own: Option<Entity>) -> String {
    let siblings = parent.map_or_else(|| roots(ecs), |p| children(ecs, p));
    let name_of = |entity: Entity| ecs.get::<Name>(entity).map_or("", |n| n.0.as_str());
    let taken: std::collections::HashSet<&str> =
        siblings.into_iter().filter(|s| Some(*s) != own).map(name_of).collect();
    let numbered = (2..).map(|n| format!("{name} {n}"));
    std::iter::once(name.to_owned()).chain(numbered).find(|n| !taken.contains(n.as_str())).unwrap_or_default()
}

/// Whether `entity` is `above`, or stands somewhere below it.
fn stands_below(world: &World, entity: Entity, above: Entity) -> bool {
    std::iter::successors(Some(entity), |e| world.get::<ChildOf>(*e).map(ChildOf::parent)).any(|e| e == above)
}

/// Takes back a parent that was set through the ECS alone and would close a cycle, before anything runs in circles.
pub(super) fn refuse_cycles(
    inserted: On<Insert<ChildOf>>,
    parents: Query<&ChildOf>,
    children: Query<(), With<Children>>,
    names: Query<&Name>,
    mut commands: Commands,
) {
    let child = inserted.entity;
    let parent = |e: Entity| parents.get(e).ok().map(ChildOf::parent);
    // What has no children closes none, so that long chains are spawned in linear time.
    if parent(child) != Some(child) && !children.contains(child) {
        return;
    }
    if std::iter::successors(parent(child), |e| parent(*e)).any(|e| e == child) {
        let name = names.get(child).map_or_else(|_| child.to_string(), |n| format!("`{}`", n.0));
        log::error!("{name} was given a parent that stands below it; it has no parent now. Use GameWorld::set_parent");
        commands.entity(child).remove::<ChildOf>();
    }
}
