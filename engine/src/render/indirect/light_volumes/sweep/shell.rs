//! The border between two cascades: radiance that goes from the coarser one into the finer one.

use super::Level;
use super::directions::Directions;
use super::march::light_bytes;
use crate::graph::{Buffer, BufferDesc, Graph, Handle};
use crate::render::indirect::light_volumes::volume::Volume;
use crate::world::Precision;
use glam::{IVec3, UVec3};
use wgpu::BufferUsages;

/// The cells of a cascade around the next finer one, whose light enters that one.
#[derive(Clone, Copy)]
pub(super) struct Shell {
    /// First cell that the finer cascade covers.
    pub(super) low: IVec3,
    /// How many it covers.
    pub(super) size: IVec3,
    /// Light of the cells, for the directions of each axis.
    pub(super) light: [Handle<Buffer>; 3],
}

impl Shell {
    /// Declares the buffers of the shell that a level of this name has around a finer volume.
    pub(super) fn new(
        graph: &mut Graph<'_>,
        name: &str,
        level: &Level,
        inner: &Volume,
        directions: &Directions,
    ) -> Self {
        let volume = &level.volume;
        let low = ((inner.origin - volume.origin) / volume.cell).round().as_ivec3();
        let size = inner.cells.as_ivec3() / 2;
        let bytes = shell_places(size.as_uvec3(), directions) * light_bytes(level.precision);
        let desc = BufferDesc::new(bytes, BufferUsages::STORAGE);
        let light = [0, 1, 2].map(|axis| graph.buffer(format!("{name}, shell along axis {axis}"), desc.clone()));
        Self { low, size, light }
    }
}

/// The most bytes of the light of a shell around so many cells, for the directions of one axis.
pub(super) fn shell_bytes(inner: UVec3, directions: &Directions) -> u64 {
    shell_places(inner, directions) * light_bytes(Precision::Single)
}

/// Places of such a shell.
fn shell_places(inner: UVec3, directions: &Directions) -> u64 {
    let n = inner.as_u64vec3() + 2;
    2 * (n.x * n.y + n.y * n.z + n.z * n.x) * 2 * u64::from(directions.group())
}
