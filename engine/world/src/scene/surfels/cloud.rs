//! The surfels of a scene.

use super::bending::Bending;
use super::group::GroupKey;
use super::openness::Exposed;
use super::patches::Patches;
use super::samples::Samples;
use super::surfel::Surfel;
use super::update::Updated;
use glam::{Affine3A, Vec3};
use std::collections::HashMap;
use std::sync::Arc;

/// The surfels of a scene.
#[derive(Debug, Default)]
pub struct SurfelCloud {
    /// All surfels, in the order of the scene's primitives.
    pub surfels: Vec<Surfel>,
    /// World from object space, one for each group of primitives that stand at the same place.
    pub places: Vec<Affine3A>,
    /// The same surfels by patches.
    pub patches: Patches,
    /// Index in [`Self::places`] by that of the primitive in the scene; `u32::MAX` for those without surfels.
    pub place_of_primitive: Vec<u32>,
    /// Changes with every change of `surfels`, `patches` and `place_of_primitive`.
    pub revision: u64,
    /// As `revision`, but not where all that changed is the pose of objects: [`Self::bending`] and
    /// [`Patches::bending`] tell what else is there then.
    pub rebuilt: u64,
    /// Changes where surfels and patches are others than before. The same numbers stand for the same ones of the same
    /// objects until then, wherever they are.
    pub layout: u64,
    /// Sum of area·reflectance over the sum of areas: the mean share of light that a surface returns. Objects that bend
    /// count as they are at rest.
    pub mean_albedo: Vec3,
    /// Flux that all surfaces emit \[W\], likewise.
    pub emitted: Vec3,
    pub(super) area: f64,
    /// Whether any surface emits light.
    pub is_emissive: bool,
    pub(super) built: HashMap<GroupKey, Arc<Samples>>,
    pub(super) state: Option<(u64, u64, u64, u32)>,
    pub(super) exposed: Exposed,
    pub(super) bent: Vec<Bending>,
    pub(super) followed: Updated,
}
