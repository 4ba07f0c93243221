//! Errors of edits of the world.

use crate::core::SceneId;
use bevy_ecs::prelude::Entity;

/// An edit that the world refuses. The world is unchanged then.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum WorldError {
    /// There is no such entity, or no longer.
    #[error("there is no entity {0}: it was despawned, or belongs to another world")]
    Missing(Entity),
    /// The new parent stands below the child.
    #[error(
        "`{child}` cannot become a child of `{parent}`, which stands below it: choose a parent outside its subtree"
    )]
    Cycle {
        /// Path of the entity that was to get a new parent.
        child: String,
        /// Path of the parent that was asked for.
        parent: String,
    },
    /// The identity belongs to a living entity.
    #[error("identity {} belongs to `{holder}`: despawn that first, or spawn without a given identity", .id.0)]
    IdentityTaken {
        /// The identity asked for.
        id: SceneId,
        /// Path of the entity that holds it.
        holder: String,
    },
}
