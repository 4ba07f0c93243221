//! Edits of an array that is sorted by identity.

use crate::scene::{Primitive, SceneCamera, SceneId, SceneLight};
use bevy_ecs::prelude::Entity;
use std::collections::HashMap;

/// A thing with an identity.
pub(super) trait Identified {
    fn id(&self) -> SceneId;
}

impl Identified for Primitive {
    fn id(&self) -> SceneId {
        self.id
    }
}

impl Identified for SceneLight {
    fn id(&self) -> SceneId {
        self.id
    }
}

impl Identified for SceneCamera {
    fn id(&self) -> SceneId {
        self.id
    }
}

/// Which entities have an element in the array, and the edits of a frame that change its length.
pub(super) struct Elements<T> {
    ids: HashMap<Entity, SceneId>,
    added: Vec<T>,
    removed: Vec<SceneId>,
}

impl<T> Default for Elements<T> {
    fn default() -> Self {
        Self { ids: HashMap::new(), added: Vec::new(), removed: Vec::new() }
    }
}

impl<T: Identified> Elements<T> {
    /// The entity's element.
    pub fn get<'a>(&self, array: &'a mut [T], entity: Entity) -> Option<&'a mut T> {
        let id = self.ids.get(&entity)?;
        let index = array.binary_search_by_key(id, T::id).ok()?;
        array.get_mut(index)
    }

    /// Adds an element for an entity that has none, with [`Elements::apply`].
    pub fn add(&mut self, entity: Entity, element: T) {
        self.ids.insert(entity, element.id());
        self.added.push(element);
    }

    /// Removes the entity's element, if it has one, with [`Elements::apply`].
    pub fn remove(&mut self, entity: Entity) {
        self.removed.extend(self.ids.remove(&entity));
    }

    /// The entities that have an element.
    pub fn entities(&self) -> impl Iterator<Item = Entity> + '_ {
        self.ids.keys().copied()
    }

    /// Carries out what was asked for. True if the set of elements changed.
    pub fn apply(&mut self, array: &mut Vec<T>) -> bool {
        let has_changed = !self.added.is_empty() || !self.removed.is_empty();
        if !self.removed.is_empty() {
            self.removed.sort_unstable();
            array.retain(|element| self.removed.binary_search(&element.id()).is_err());
            self.removed.clear();
        }
        if !self.added.is_empty() {
            array.append(&mut self.added);
            array.sort_by_key(T::id);
        }
        has_changed
    }
}
