//! Bounding volume hierarchies over all surfaces of a scene, in world space: one of all static objects and one of each dynamic
//! one, which has its boxes fitted again.

mod movers;
mod part;
mod scene_bvh;
#[cfg(test)]
mod tests;
mod triangle;

pub use movers::Movers;
pub use part::{ScenePart, Updated};
#[doc(hidden)]
pub use scene_bvh::is_nearer;
pub use scene_bvh::{RayKind, SceneBvh, SceneHit};
pub use triangle::SceneTriangle;
#[doc(hidden)]
pub use triangle::{corner_indices, is_mirrored, normal_matrix, turned_normal, vertex_indices, world_normal};
