//! What the reading of meshes takes.

use super::accessor::Buffers;
use super::material::UvSource;
use gltf::mesh::Primitive;

/// How to read primitives.
pub(super) struct Reader<'a> {
    pub buffers: Buffers<'a>,
    /// `KHR_mesh_quantization`: integer positions, normals and tangents.
    pub quantized: bool,
}

/// A primitive with what its material asks for.
pub(super) struct Job<'a> {
    pub primitive: Primitive<'a>,
    pub name: String,
    /// Where messages say it is.
    pub place: String,
    pub uv: UvSource,
}
