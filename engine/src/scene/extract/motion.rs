//! Which primitives are moving: those that are animated, and those that have changed lately.
//!
//! What does not move is drawn into maps of its own, which are kept. To call a primitive static that was moving costs a
//! new drawing of those maps; so it is done only when they have to be drawn anew anyway.

use crate::scene::{Primitive, SceneId};
use crate::world::{Posed, RestPose};
use bevy_ecs::prelude::*;
use std::collections::HashMap;

/// Extractions without a change after which a primitive may be called static again.
const REST: u64 = 30;

/// When the moving primitives changed last.
#[derive(Debug, Default)]
pub(super) struct Motion {
    count: u64,
    changed: HashMap<SceneId, u64>,
}

impl Motion {
    /// Another extraction begins.
    pub fn begin(&mut self) {
        self.count += 1;
    }

    /// The primitive has changed, or is animated and new. True if it was not moving until now.
    pub fn touch(&mut self, primitive: &mut Primitive) -> bool {
        self.changed.insert(primitive.id, self.count);
        !std::mem::replace(&mut primitive.moving, true)
    }

    /// Calls those static that have rested for long enough.
    pub fn settle(&mut self, primitives: &mut [Primitive]) {
        let now = self.count;
        let rested: Vec<SceneId> =
            self.changed.iter().filter(|(_, last)| now - **last >= REST).map(|(id, _)| *id).collect();
        for id in rested {
            self.changed.remove(&id);
            if let Ok(index) = primitives.binary_search_by_key(&id, |primitive| primitive.id) {
                primitives[index].moving = false;
            }
        }
    }
}

/// What tells that an entity is animated, and who its parent is.
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
