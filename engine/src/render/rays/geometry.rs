//! Nodes and triangles in the layouts of `lib/rays.wgsl`.

use super::RayError;
use super::boxes::BoxLists;
use super::materials::GpuMaterials;
use super::words::{ROW, Texel, Words};
use crate::assets::VertexExtra;
use crate::bvh::{SceneBvh, vertex_indices, world_normal};
use crate::gpu::Gpu;
use crate::scene::Scene;
use glam::{Affine3A, Vec2, Vec3};

/// Flags of a triangle, above the index of its material.
const CASTS_SHADOW: u32 = 1 << 29;
const DOUBLE_SIDED: u32 = 1 << 30;
const MASKED: u32 = 1 << 31;

/// Stands for "none".
pub(super) const NONE: u32 = u32::MAX;

/// Geometry on the device.
pub(super) struct GpuGeometry {
    nodes: Words,
    triangles: Words,
    attributes: Words,
    extras: Words,
    /// Boxes of a list.
    pub(super) box_count: u32,
    /// Whether the boxes are stored as they are: see [`boxes`].
    pub(super) exact_boxes: bool,
}

impl GpuGeometry {
    pub(super) fn new(gpu: &Gpu) -> Self {
        Self {
            nodes: Words::new(gpu, "ray boxes", 1),
            triangles: Words::new(gpu, "ray triangles", 1),
            attributes: Words::new(gpu, "ray attributes", 1),
            extras: Words::new(gpu, "ray extras", 1),
            box_count: 0,
            exact_boxes: false,
        }
    }

    pub(super) fn nodes(&self) -> &wgpu::TextureView {
        self.nodes.view()
    }

    pub(super) fn triangles(&self) -> &wgpu::TextureView {
        self.triangles.view()
    }

    pub(super) fn attributes(&self) -> &wgpu::TextureView {
        self.attributes.view()
    }

    pub(super) fn extras(&self) -> &wgpu::TextureView {
        self.extras.view()
    }

    /// Uploads all triangles in the order of the leaves. `emitters` gives each its emitter, or [`NONE`].
    pub(super) fn update(
        &mut self,
        gpu: &Gpu,
        scene: &Scene,
        bvh: &SceneBvh,
        materials: &GpuMaterials,
        emitters: &[u32],
    ) -> Result<(), RayError> {
        let mut lists = BoxLists::new(&bvh.bvh);
        self.nodes.upload(gpu, "ray boxes", "hierarchies", &mut lists.texels)?;
        (self.box_count, self.exact_boxes) = (lists.box_count, lists.exact);
        let mut triangles = triangle_rows(bvh.bvh.order.len());
        let mut attributes = triangles.clone();
        let mut extras = triangle_rows(if materials.is_plain() { 0 } else { bvh.bvh.order.len() });
        for (place, (&index, &emitter)) in bvh.bvh.order.iter().zip(emitters).enumerate() {
            let triangle = &bvh.triangles[index as usize];
            let primitive = &scene.primitives[triangle.primitive as usize];
            let material = materials.index(primitive.material.id);
            let flag = |set: bool, flag: u32| if set { flag } else { 0 };
            let head = material
                | flag(primitive.casts_shadow, CASTS_SHADOW)
                | flag(primitive.material.double_sided, DOUBLE_SIDED)
                | flag(materials.is_masked(material), MASKED);
            let words = [head, emitter, triangle.primitive];
            let indices = vertex_indices(primitive, triangle.triangle);
            let vertices = indices.map(|vertex| &primitive.mesh.vertices[vertex]);
            let transform = &primitive.world_from_object;
            for corner in 0..3 {
                let [x, y, z] = triangle.corners[corner].to_array().map(f32::to_bits);
                let vertex = vertices[corner];
                let normal = encode_direction(world_normal(transform, vertex.normal.into()));
                let [u, v] = vertex.uv.map(f32::to_bits);
                let texel = triangle_texel(place, corner);
                triangles[texel] = [x, y, z, words[corner]];
                attributes[texel] = [normal, u, v, encode_tangent(transform, vertex.tangent)];
                if !extras.is_empty() {
                    extras[texel] = encode_extra(&primitive.mesh.extra(indices[corner]));
                }
            }
        }
        self.triangles.upload(gpu, "ray triangles", "triangles", &mut triangles)?;
        self.extras.upload(gpu, "ray extras", "triangles", &mut extras)?;
        self.attributes.upload(gpu, "ray attributes", "triangles", &mut attributes)
    }
}

/// Second texture coordinates, then colour and alpha of 16 bits each.
fn encode_extra(extra: &VertexExtra) -> Texel {
    let ([u, v], [r, g, b, a]) = (extra.uv.map(f32::to_bits), extra.color.map(u32::from));
    [u, v, r | g << 16, b | a << 16]
}

/// Room for so many triangles, in whole rows.
fn triangle_rows(triangles: usize) -> Vec<Texel> {
    vec![Texel::default(); triangles.div_ceil(ROW as usize) * 3 * ROW as usize]
}

/// Where a corner of a triangle lies: three rows hold the corners of 4096 triangles.
fn triangle_texel(triangle: usize, corner: usize) -> usize {
    let row = ROW as usize;
    (triangle / row * 3 + corner) * row + triangle % row
}

/// Octahedral coordinates of a unit vector (Cigolle et al. 2014) in −1..1.
fn octahedral(n: Vec3) -> Vec2 {
    let p = Vec2::new(n.x, n.y) / (n.x.abs() + n.y.abs() + n.z.abs());
    let sign = |v: f32| if v < 0.0 { -1.0 } else { 1.0 };
    if n.z >= 0.0 { p } else { Vec2::new((1.0 - p.y.abs()) * sign(p.x), (1.0 - p.x.abs()) * sign(p.y)) }
}

/// Two 16-bit octahedral coordinates, 0x7fff being zero as in the G-buffer; all zero for no direction.
fn encode_direction(n: Vec3) -> u32 {
    if n == Vec3::ZERO || !n.is_finite() {
        return 0;
    }
    let [x, y] = octahedral(n).to_array().map(|v| (v * 32767.0).round() as i32 + 32768);
    x as u32 | (y as u32) << 16
}

/// As a direction, but the lowest bit says that the bitangent is turned around.
fn encode_tangent(transform: &Affine3A, [x, y, z, handedness]: [f32; 4]) -> u32 {
    let tangent = transform.transform_vector3(Vec3::new(x, y, z)).normalize_or_zero();
    if tangent == Vec3::ZERO {
        return 0;
    }
    encode_direction(tangent) & !1 | u32::from(handedness < 0.0)
}
