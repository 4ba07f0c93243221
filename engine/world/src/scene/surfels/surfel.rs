//! A surfel, and how fine surfels are.

use crate::scene::Primitive;
use bytemuck::{Pod, Zeroable};

/// Most surfels of a scene: 64 MiB.
pub const MAX_SURFELS: usize = 1 << 20;

/// Surfels a face of a cell.
const SURFELS_A_FACE: f32 = 8.0;

/// Thickness \[m\] of what has nothing behind it.
pub(super) const ENDLESS: f32 = 1e30;

/// Cells that fit into what a closed double-sided mesh encloses from which on it is a room, as `ROOM` of
/// `lib/sweep.wgsl`.
const ROOM: f32 = 2.0;

/// Bit of [`Surfel::place`]: the inner side of what may be a room, as `INNER` of `lib/sweep.wgsl`.
pub(super) const INNER: u32 = 1 << 31;

/// Where in [`Surfel::place`] the eight bits begin that tell how closed the surroundings are, as `CLOSED` of
/// `lib/sweep.wgsl`.
pub(super) const CLOSED_SHIFT: u32 = 23;

/// The value of these bits for a surfel that lies in a crack or cavity.
pub(super) const HIDDEN: u8 = 255;

/// A piece of surface, as `Surfel` of `lib/sweep.wgsl`. Position and normal are in object space, lengths and areas
/// are as in the world.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Surfel {
    /// Position in object space.
    pub position: [f32; 3],
    /// Area \[m²\], times alpha where the surface is blended.
    pub area: f32,
    /// Unit normal in object space, to the side that reflects.
    pub normal: [f32; 3],
    /// Thickness of the solid behind it \[m\]: the way along −n to the next surface of the same object. 0 for both
    /// sides of a sheet that can be seen from both, very large for the only side of one that cannot. Below 0 for both
    /// sides of a closed surface that can be seen from both: less the width of what it encloses, which is a room
    /// for cells that are small against it, and a solid for others.
    pub thickness: f32,
    /// Diffuse reflectance.
    pub albedo: [f32; 3],
    /// Index in [`SurfelCloud::places`](super::SurfelCloud::places), see [`Surfel::group`]; the highest bit is set on the inner side of a closed
    /// surface, and the eight after it tell how closed its surroundings are, see [`Surfel::openness`].
    pub place: u32,
    /// Emitted radiance [W/(m² sr)].
    pub emissive: [f32; 3],
    /// Largest cells \[m\] whose faces the object closes whole: the second largest edge of its box, 0 if it has holes.
    pub wall: f32,
}

impl Surfel {
    /// Index in [`SurfelCloud::places`](super::SurfelCloud::places).
    pub fn group(&self) -> usize {
        (self.place & ((1 << CLOSED_SHIFT) - 1)) as usize
    }

    /// Whether it lies in a crack or cavity, where light hardly gets.
    pub fn is_hidden(&self) -> bool {
        (self.place >> CLOSED_SHIFT) as u8 == HIDDEN
    }

    /// Share of the light about it that gets past what stands near it.
    pub fn openness(&self) -> f32 {
        1.0 - f32::from((self.place >> CLOSED_SHIFT) as u8) / 255.0
    }
}

/// How fine the surfels are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Fineness {
    /// Surfels a square metre.
    pub(super) density: f32,
    /// Width from which on the inside of a closed double-sided mesh has surfels too \[m\].
    pub(super) room: f32,
}

impl Fineness {
    /// For cells of a size \[m\] in a scene of an area \[m²\].
    pub(super) fn new(cell: f32, area: f64) -> Self {
        Self { density: limited(SURFELS_A_FACE / cell / cell, area), room: ROOM * cell }
    }

    pub(super) fn bits(&self) -> [u32; 2] {
        [self.density, self.room].map(f32::to_bits)
    }
}

/// Whether the primitive has surfels: it is an obstacle for light, at a place that is finite.
pub(super) fn has_surfels(primitive: &Primitive) -> bool {
    primitive.blocks_light() && primitive.world_from_object.is_finite()
}

/// The density with which the scene's area gives no more than [`MAX_SURFELS`], in steps of √2 so that a small change
/// of the scene changes none.
fn limited(density: f32, area: f64) -> f32 {
    let wanted = f64::from(density) * area;
    let most = MAX_SURFELS as f64 * 0.9;
    if wanted <= most {
        return density;
    }
    let steps = (2.0 * (wanted / most).log2()).ceil();
    (f64::from(density) * (-0.5 * steps).exp2()) as f32
}
