//! Triangle meshes on the CPU side.

use super::{AssetId, Ball, Deform, Vertex, VertexExtra};
use crate::bvh::MeshBvh;
use crate::core::Aabb;
use glam::Vec3;
use std::sync::{Arc, OnceLock};

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
    /// Second texture coordinates and colours, one for each vertex; none: neutral.
    pub extras: Option<Arc<Vec<VertexExtra>>>,
    /// How it is posed; none: it is rigid.
    pub deform: Option<Arc<Deform>>,
    /// The mesh that this one is a pose of: the same triangles and the same vertices, elsewhere.
    pub rest: Option<Arc<Mesh>>,
    /// Key of the triangles that wind the other way than in [`Self::rest`], since joints mirror them; 0: none.
    pub winding: u64,
    /// The balls of light that it stands for, in the order of its triangles. Rays and light meet its triangles; cameras see soft
    /// discs in their place.
    pub balls: Option<Arc<Vec<Ball>>>,
    pub(in crate::assets) hierarchy: OnceLock<MeshBvh>,
}

impl Mesh {
    /// Takes the arrays and computes the bounds.
    pub fn new(name: impl Into<String>, vertices: Vec<Vertex>, indices: Vec<u32>) -> Self {
        let bounds = Aabb::from_points(vertices.iter().map(|v| Vec3::from(v.position)));
        Self {
            id: AssetId::fresh(),
            name: name.into(),
            vertices,
            indices,
            bounds,
            extras: None,
            deform: None,
            rest: None,
            winding: 0,
            balls: None,
            hierarchy: OnceLock::new(),
        }
    }

    /// The mesh for rays; built when it is first asked for.
    pub fn hierarchy(&self) -> &MeshBvh {
        self.hierarchy.get_or_init(|| MeshBvh::from_triangles(self.corners()))
    }

    /// Corners of all triangles in object space \[m\], in their order.
    pub fn corners(&self) -> Vec<[Vec3; 3]> {
        let position = |&index: &u32| Vec3::from(self.vertices[index as usize].position);
        let corner = |triangle: &[u32]| [position(&triangle[0]), position(&triangle[1]), position(&triangle[2])];
        self.indices.chunks_exact(3).map(corner).collect()
    }

    /// Identity of the triangles, whichever way they wind: all poses of a mesh share it.
    pub fn topology(&self) -> AssetId {
        self.rest.as_ref().map_or(self.id, |rest| rest.id)
    }

    /// Takes over what another mesh has beside its vertices, where this one's vertices are copies of that one's:
    /// `origins` says of which.
    pub(in crate::assets) fn carry(&mut self, from: &Mesh, origins: &[u32]) {
        let pick = |extras: &Arc<Vec<VertexExtra>>| Arc::new(origins.iter().map(|i| extras[*i as usize]).collect());
        self.extras = from.extras.as_ref().map(pick);
        self.deform = from.deform.as_ref().map(|deform| Arc::new(deform.reordered(origins)));
    }

    /// The extra of a vertex, neutral where the mesh has none.
    pub fn extra(&self, vertex: usize) -> VertexExtra {
        self.extras.as_ref().and_then(|extras| extras.get(vertex)).copied().unwrap_or(VertexExtra::NEUTRAL)
    }

    /// Number of triangles.
    pub fn triangle_count(&self) -> usize {
        self.indices.len() / 3
    }
}
