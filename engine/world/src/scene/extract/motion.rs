//! Which primitives are moving: those that are animated, and those that have changed lately.
//!
//! Static objects are drawn into maps of their own, which are kept. To call a primitive static that was moving costs a
//! new drawing of those maps; so it is done only when they have to be redrawn anyway, and for what is animated never:
//! it would move again. Anything else that moves again after a rest must rest twice as long the next time.

use crate::scene::{Primitive, SceneId};
use crate::world::{Posed, RestPose};
use bevy_ecs::prelude::*;
use std::collections::HashMap;

/// Extractions without a change after which a primitive may be called static again, the first time.
const REST: u64 = 30;

/// When primitives changed last.
#[derive(Debug, Default)]
pub(super) struct Motion {
    count: u64,
    changed: HashMap<SceneId, Changed>,
}

#[derive(Clone, Copy, Debug, Default)]
struct Changed {
    last: u64,
    /// Times that it was called static.
    settled: u32,
    is_driven: bool,
}

impl Changed {
    fn has_rested(&self, now: u64) -> bool {
        !self.is_driven && now - self.last >= REST << self.settled.min(20)
    }
}

impl Motion {
    /// Another extraction begins.
    pub fn begin(&mut self) {
        self.count += 1;
    }

    /// The primitive has changed. True if it was not moving until now.
    pub fn touch(&mut self, primitive: &mut Primitive) -> bool {
        self.changed.entry(primitive.id).or_default().last = self.count;
        !std::mem::replace(&mut primitive.moving, true)
    }

    /// The primitive is new, and animated.
    pub fn drive(&mut self, primitive: &mut Primitive) {
        let driven = Changed { last: self.count, settled: 0, is_driven: true };
        self.changed.insert(primitive.id, driven);
        primitive.moving = true;
    }

    /// Calls those static that have rested for long enough, and forgets those that are gone.
    pub fn settle(&mut self, primitives: &mut [Primitive]) {
        let now = self.count;
        self.changed.retain(|id, changed| {
            let Ok(index) = primitives.binary_search_by_key(id, |primitive| primitive.id) else { return false };
            let primitive = &mut primitives[index];
            if primitive.moving && changed.has_rested(now) {
                primitive.moving = false;
                changed.settled += 1;
            }
            true
        });
    }
}

/// Whether an entity is animated, and its parent.
pub(super) type Drivers = (Has<RestPose>, Has<Posed>, Option<&'static ChildOf>);

/// Whether an animation moves or poses the entity, or one that it is attached to.
pub(super) fn is_driven(mut entity: Entity, drivers: &Query<Drivers>) -> bool {
    while let Ok((is_animated, is_posed, parent)) = drivers.get(entity) {
        if is_animated || is_posed {
            return true;
        }
        let Some(parent) = parent else { return false };
        entity = parent.parent();
    }
    false
}
