//! Bounding volume hierarchies: which of many boxes a ray may meet.
//!
//! Built on the CPU with the surface area heuristic, over boxes of any kind or the triangles of a mesh ([`MeshBvh`], in object
//! space). Those of a whole scene are [`SceneBvh`](crate::scene::SceneBvh). Used on the CPU and, with the same boxes, on the device.

mod build;
mod mesh;
mod presplit;
#[cfg(test)]
pub(crate) mod tests;
mod tree;

pub use crate::core::{Ray, intersect_triangle};
pub use mesh::{MeshBvh, MeshHit};
pub(crate) use presplit::presplit;
pub use tree::{Bvh, MAX_DEPTH, Node};
