//! What the parts of an extraction share: revisions and warnings.

use crate::scene::Scene;
use crate::world::Name;
use bevy_ecs::prelude::*;
use std::collections::HashSet;

/// The revision counter of a scene.
#[derive(Debug, Default)]
pub(super) struct Counter(u64);

impl Counter {
    pub(super) fn next(&mut self) -> u64 {
        self.0 += 1;
        self.0
    }
}

/// The subject of warnings: a part of an entity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Part {
    Primitive,
    Particles,
    Light,
    Medium,
    Camera,
    Clpv,
    Vpl,
    Slc,
    /// Of no entity, but of the scene as a whole.
    Sky,
}

/// Warnings: each is logged once an entity, and stands in the scene for as long as it holds.
#[derive(Debug, Default)]
pub(super) struct Log {
    logged: HashSet<(Entity, &'static str)>,
    pub(super) held: Vec<(Entity, Part, String)>,
    has_changed: bool,
}

impl Log {
    pub(super) fn warn(&mut self, entity: Entity, part: Part, name: Option<&Name>, message: &'static str) {
        let text = format!("`{}`: {message}", name_or_id(entity, name));
        if self.logged.insert((entity, message)) {
            log::warn!("{text}");
        }
        self.held.push((entity, part, text));
        self.has_changed = true;
    }

    /// Warns of the scene's sky. It is looked at only where it changed, so that each time is worth a line.
    pub(super) fn warn_of_sky(&mut self, message: String) {
        log::warn!("{message}");
        self.held.push((Entity::PLACEHOLDER, Part::Sky, message));
        self.has_changed = true;
    }

    /// A part of an entity is checked again: its former warnings no longer hold.
    pub(super) fn begin(&mut self, entity: Entity, part: Part) {
        self.keep(|(e, p, _)| (*e, *p) != (entity, part));
    }

    /// Parts of which only the first counts are checked again.
    pub(super) fn begin_all(&mut self, part: Part) {
        self.keep(|(_, p, _)| *p != part);
    }

    /// Forgets a part of an entity, and warns of the entity again.
    pub(super) fn forget(&mut self, entity: Entity, part: Part) {
        self.begin(entity, part);
        if !self.logged.is_empty() {
            self.logged.retain(|(e, _)| *e != entity);
        }
    }

    fn keep(&mut self, keep: impl Fn(&(Entity, Part, String)) -> bool) {
        let before = self.held.len();
        self.held.retain(keep);
        self.has_changed |= self.held.len() != before;
    }

    /// Updates the scene's warnings, in an order that does not depend on that of changes.
    pub(super) fn write(&mut self, scene: &mut Scene) {
        if std::mem::take(&mut self.has_changed) || scene.warnings.len() != self.held.len() {
            scene.warnings = self.held.iter().map(|(.., text)| text.clone()).collect();
            scene.warnings.sort_unstable();
        }
    }
}

pub(super) fn name_or_id(entity: Entity, name: Option<&Name>) -> String {
    name.map_or_else(|| entity.to_string(), |n| n.0.clone())
}

/// Shared state of the parts of an extraction.
pub(super) struct Context<'a> {
    pub(super) log: &'a mut Log,
    pub(super) revisions: &'a mut Counter,
    /// Removal events may have expired: look whether everything is still there.
    pub(super) is_late: bool,
}
