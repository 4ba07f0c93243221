//! Nodes, triangles, vertices and instances in the layouts of `lib/rays.wgsl`.

use super::materials::GpuMaterials;
use super::{RayError, check_size};
use crate::assets::AssetId;
use crate::bvh::{Instance, Node, SceneBvh, TracedMesh};
use crate::gpu::Gpu;
use crate::scene::Scene;
use bytemuck::{Pod, Zeroable};
use glam::Affine3A;
use std::sync::Arc;

/// Flags of an instance.
const CASTS_SHADOW: u32 = 1;
const DOUBLE_SIDED: u32 = 2;
const MASKED: u32 = 4;

/// Stands for "no emitters".
pub(super) const NONE: u32 = u32::MAX;

/// `Triangle` of `lib/rays.wgsl`: three corners in object space with the indices of their vertices.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub(crate) struct RayTriangle {
    /// Bits of the position, and the index of the vertex.
    corners: [[u32; 4]; 3],
}

/// `Vertex` of `lib/rays.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub(crate) struct RayVertex {
    normal: [f32; 3],
    u: f32,
    tangent: [f32; 4],
    v: f32,
    padding: [f32; 3],
}

/// `Instance` of `lib/rays.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub(crate) struct RayInstance {
    object_from_world: [[f32; 4]; 3],
    world_from_object: [[f32; 4]; 3],
    root: u32,
    material: u32,
    flags: u32,
    first_emitter: u32,
    first_triangle: u32,
    padding: [u32; 3],
}

/// Where a mesh lies in the shared buffers.
#[derive(Clone, Copy)]
struct Place {
    root: u32,
    first_triangle: u32,
}

/// Geometry on the device.
pub(super) struct GpuGeometry {
    pub(super) nodes: wgpu::Buffer,
    pub(super) triangles: wgpu::Buffer,
    pub(super) vertices: wgpu::Buffer,
    pub(super) instances: wgpu::Buffer,
    /// Where the top level begins.
    pub(super) root: u32,
    /// Meshes that are in the buffers, and where.
    meshes: Vec<AssetId>,
    places: Vec<Place>,
    /// Nodes that there is room for after those of the meshes.
    room: usize,
}

impl GpuGeometry {
    pub(super) fn new(gpu: &Gpu) -> Self {
        let empty = |label| gpu.storage(label, &[0.0_f32; 32], wgpu::BufferUsages::empty());
        Self {
            nodes: empty("ray nodes"),
            triangles: empty("ray triangles"),
            vertices: empty("ray vertices"),
            instances: empty("ray instances"),
            root: 0,
            meshes: Vec::new(),
            places: Vec::new(),
            room: 0,
        }
    }

    /// Uploads what changed: the meshes only if they are others than before.
    pub(super) fn update(
        &mut self,
        gpu: &Gpu,
        scene: &Scene,
        bvh: &SceneBvh,
        materials: &GpuMaterials,
        first_emitters: &[u32],
    ) -> Result<(), RayError> {
        let meshes: Vec<AssetId> = bvh.meshes.iter().map(|mesh| mesh.mesh.id).collect();
        if meshes != self.meshes || bvh.top.nodes.len() > self.room {
            self.meshes.clear();
            self.upload_meshes(gpu, bvh)?;
            self.meshes = meshes;
        }
        let place = |(instance, &first_emitter): (&Instance, &u32)| {
            let Place { root, first_triangle } = self.places[instance.mesh as usize];
            let primitive = &scene.primitives[instance.primitive as usize];
            let material = materials.index(primitive.material.id);
            let flag = |set: bool, flag: u32| if set { flag } else { 0 };
            RayInstance {
                object_from_world: rows(&instance.object_from_world),
                world_from_object: rows(&instance.world_from_object),
                root,
                material,
                flags: flag(instance.casts_shadow, CASTS_SHADOW)
                    | flag(instance.double_sided, DOUBLE_SIDED)
                    | flag(materials.is_masked(material), MASKED),
                first_emitter,
                first_triangle,
                padding: [0; 3],
            }
        };
        let mut instances: Vec<RayInstance> = bvh.instances.iter().zip(first_emitters).map(place).collect();
        // A binding holds one element at least.
        instances.resize(instances.len().max(1), RayInstance::zeroed());
        check_size(gpu, "instances", size_of_val(instances.as_slice()) as u64)?;
        self.instances = gpu.storage("ray instances", &instances, wgpu::BufferUsages::empty());
        let top: Vec<Node> = bvh.top.nodes.iter().map(|node| self.top_node(node, &bvh.top.order)).collect();
        gpu.queue.write_buffer(
            &self.nodes,
            u64::from(self.root) * size_of::<Node>() as u64,
            bytemuck::cast_slice(&top),
        );
        Ok(())
    }

    /// Leaves of the top level name their one instance.
    fn top_node(&self, node: &Node, order: &[u32]) -> Node {
        let first = if node.count > 0 { order[node.first as usize] } else { self.root + node.first };
        Node { first, ..*node }
    }

    fn upload_meshes(&mut self, gpu: &Gpu, bvh: &SceneBvh) -> Result<(), RayError> {
        let (mut nodes, mut triangles, mut vertices) = (Vec::new(), Vec::new(), Vec::new());
        self.places.clear();
        for mesh in &bvh.meshes {
            self.places.push(append(mesh, &mut nodes, &mut triangles, &mut vertices));
        }
        self.root = nodes.len() as u32;
        self.room = (2 * bvh.instances.len()).max(1);
        nodes.resize(nodes.len() + self.room, Node::default());
        triangles.resize(triangles.len().max(1), RayTriangle::zeroed());
        vertices.resize(vertices.len().max(1), RayVertex::zeroed());
        check_size(gpu, "hierarchies", size_of_val(nodes.as_slice()) as u64)?;
        check_size(gpu, "triangles", size_of_val(triangles.as_slice()) as u64)?;
        check_size(gpu, "vertices", size_of_val(vertices.as_slice()) as u64)?;
        self.nodes = gpu.storage("ray nodes", &nodes, wgpu::BufferUsages::COPY_DST);
        self.triangles = gpu.storage("ray triangles", &triangles, wgpu::BufferUsages::empty());
        self.vertices = gpu.storage("ray vertices", &vertices, wgpu::BufferUsages::empty());
        Ok(())
    }
}

/// Appends a mesh to the shared arrays: triangles in the order of the leaves.
fn append(
    mesh: &Arc<TracedMesh>,
    nodes: &mut Vec<Node>,
    triangles: &mut Vec<RayTriangle>,
    vertices: &mut Vec<RayVertex>,
) -> Place {
    let place = Place { root: nodes.len() as u32, first_triangle: triangles.len() as u32 };
    let first_vertex = vertices.len() as u32;
    let bvh = &mesh.bvh.bvh;
    nodes.extend(bvh.nodes.iter().map(|node| {
        let base = if node.count > 0 { place.first_triangle } else { place.root };
        Node { first: base + node.first, ..*node }
    }));
    triangles.extend(bvh.order.iter().map(|&triangle| {
        let corners = mesh.bvh.corners()[triangle as usize];
        let indices = &mesh.mesh.indices[3 * triangle as usize..];
        let corner = |i: usize| {
            let [x, y, z] = corners[i].to_array().map(f32::to_bits);
            [x, y, z, first_vertex + indices[i]]
        };
        RayTriangle { corners: [corner(0), corner(1), corner(2)] }
    }));
    vertices.extend(mesh.mesh.vertices.iter().map(|vertex| RayVertex {
        normal: vertex.normal,
        u: vertex.uv[0],
        tangent: vertex.tangent,
        v: vertex.uv[1],
        padding: [0.0; 3],
    }));
    place
}

fn rows(transform: &Affine3A) -> [[f32; 4]; 3] {
    let m = transform;
    std::array::from_fn(|i| [m.x_axis[i], m.y_axis[i], m.z_axis[i], m.translation[i]])
}
