//! Triangle meshes on the CPU side.

use super::AssetId;
use crate::scene::Aabb;
use glam::Vec3;

/// One vertex as the GPU sees it: 48 bytes, object space, metres.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Vertex {
    /// Position in object space \[m\].
    pub position: [f32; 3],
    /// Unit normal in object space; zero only where the triangle itself has no area.
    pub normal: [f32; 3],
    /// Unit tangent along +u, and the handedness (±1) of the bitangent, as in glTF.
    pub tangent: [f32; 4],
    /// Texture coordinate set 0, origin at the upper left as in glTF.
    pub uv: [f32; 2],
}

/// An indexed triangle list. Immutable once made; share it by `Arc`.
#[derive(Debug)]
pub struct Mesh {
    /// Identity for caches: no two meshes of a process share it.
    pub id: AssetId,
    /// Name for messages and the inspector.
    pub name: String,
    /// Vertices.
    pub vertices: Vec<Vertex>,
    /// Three indices a triangle, counter-clockwise seen from outside.
    pub indices: Vec<u32>,
    /// Bounds of all vertices in object space.
    pub bounds: Aabb,
}

impl Mesh {
    /// Takes the arrays and computes the bounds.
    pub fn new(name: impl Into<String>, vertices: Vec<Vertex>, indices: Vec<u32>) -> Self {
        let bounds = Aabb::from_points(vertices.iter().map(|v| Vec3::from(v.position)));
        Self { id: AssetId::fresh(), name: name.into(), vertices, indices, bounds }
    }

    /// Number of triangles.
    pub fn triangle_count(&self) -> usize {
        self.indices.len() / 3
    }
}
