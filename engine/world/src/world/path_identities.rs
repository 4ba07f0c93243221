//! The identities of entities by their paths, which a reload keeps.

use super::GameWorld;
use super::identity::{Identities, RootOrder};
use crate::core::SceneId;
use bevy_ecs::prelude::*;
use std::collections::{HashMap, VecDeque};

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
