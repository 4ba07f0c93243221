//! What is arranged into patches.

use super::occluders::Occluders;
use crate::scene::Surfel;
use glam::Mat3A;
use std::sync::Arc;

/// Bit of what stands for a patch: the rest is the index of a node, as `PATCH_NODE` of `lib/patches.wgsl`.
pub(super) const NODE: u32 = 1 << 31;

/// An object whose surfels are to be arranged.
pub(in crate::scene::surfels) struct Subject<'a> {
    /// Its surfels; those of a static one are its own.
    pub surfels: &'a Arc<Vec<Surfel>>,
    /// Factor from lengths in object space to those in the world, see [`shape`](crate::scene::surfels::group::shape).
    pub shape: Mat3A,
    /// Its surroundings; none if it moves: it will be elsewhere.
    pub occluders: Option<Occluders<'a>>,
    /// Whether what stands around it has changed.
    pub is_changed: bool,
}
