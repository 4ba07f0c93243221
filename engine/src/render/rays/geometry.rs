//! Nodes and triangles in the layouts of `lib/ray_scene.wgsl`.

use super::RayError;
use super::emitters::Emitters;
use super::materials::GpuMaterials;
use super::moving_boxes::runs;
use super::nodes::Nodes;
use super::words::{ROW, Texel, Words};
use crate::assets::{VertexExtra, parallel};
use crate::bvh::Bvh;
use crate::gpu::Gpu;
use crate::scene::{Primitive, Scene};
use crate::scene::{SceneBvh, corner_indices, is_mirrored, normal_matrix, turned_normal};
use glam::{Mat3, Vec2, Vec3};

/// Flags of a triangle, above the index of its material.
const GLASS: u32 = 1 << 28;
const CASTS_SHADOW: u32 = 1 << 29;
const DOUBLE_SIDED: u32 = 1 << 30;
const MASKED: u32 = 1 << 31;

/// Stands for "none".
pub(super) const NONE: u32 = u32::MAX;

/// Triangles of a hierarchy that are not there, because they have no box.
const GONE: u32 = u32::MAX;
/// Triangles between two objects that are rather written again than left out.
const GAP: usize = 256;
/// Triangles that a thread of its own is worth.
const WORTH_A_THREAD: usize = 2048;

/// Geometry on the device: first static objects, then dynamic ones.
pub(super) struct GpuGeometry {
    pub(super) nodes: Nodes,
    triangles: Words,
    attributes: Words,
    extras: Words,
    has_extras: bool,
}

/// The key of the geometry.
#[derive(Clone, Copy)]
pub(super) struct Surfaces<'a> {
    pub(super) scene: &'a Scene,
    pub(super) bvh: &'a SceneBvh,
    pub(super) materials: &'a GpuMaterials,
    pub(super) emitters: &'a Emitters,
}

impl GpuGeometry {
    pub(super) fn new(gpu: &Gpu) -> Self {
        Self {
            nodes: Nodes::new(gpu),
            triangles: Words::new(gpu, "ray triangles", 1),
            attributes: Words::new(gpu, "ray attributes", 1),
            extras: Words::new(gpu, "ray extras", 1),
            has_extras: false,
        }
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

    /// The hierarchies, each with the index of its first triangle.
    pub(super) fn trees<'a>(&'a self, bvh: &'a SceneBvh) -> impl Iterator<Item = (&'a Bvh, u32)> {
        let objects = bvh.movers.objects.iter().enumerate();
        let movers = objects.map(|(index, object)| (&object.bvh, self.nodes.first_triangle(index)));
        std::iter::once((&bvh.statics.bvh, 0)).chain(movers)
    }

    /// Uploads all static objects, and makes room for dynamic ones, which are to be uploaded next.
    pub(super) fn update_statics(&mut self, gpu: &Gpu, surfaces: Surfaces) -> Result<(), RayError> {
        let statics = &surfaces.bvh.statics.bvh;
        let moving = surfaces.bvh.moving_triangles();
        self.nodes.update_statics(gpu, surfaces.bvh)?;
        let triangle_rows = 3 * (statics.order.len() + moving).div_ceil(ROW as usize);
        self.has_extras = !surfaces.materials.is_plain();
        self.triangles.reserve(gpu, "ray triangles", "triangles", triangle_rows)?;
        self.attributes.reserve(gpu, "ray attributes", "triangles", triangle_rows)?;
        self.extras.reserve(gpu, "ray extras", "triangles", if self.has_extras { triangle_rows } else { 0 })?;
        self.write_triangles(gpu, surfaces, 0, &statics.order, true);
        Ok(())
    }

    /// Uploads the boxes and triangles of dynamic objects that have changed since a version which the device holds; none:
    /// of all.
    pub(super) fn update_movers(&mut self, gpu: &Gpu, surfaces: Surfaces, since: Option<u64>) {
        let movers = &surfaces.bvh.movers;
        if surfaces.bvh.moving_triangles() == 0 || since.is_some_and(|since| movers.version <= since) {
            return;
        }
        self.nodes.update_movers(gpu, surfaces.bvh, since);
        let is_new = |index: &usize| since.is_none_or(|since| movers.objects[*index].version > since);
        let new: Vec<usize> = (0..movers.objects.len()).filter(is_new).collect();
        let place = |object: usize| self.nodes.first_triangle(object) as usize;
        for run in runs(&new, |before, object| place(object) - place(before + 1) <= GAP) {
            let mut order = Vec::with_capacity(place(run.end - 1) - place(run.start));
            // Extras stay with the vertices, wherever these are.
            let has_extras = since.is_none_or(|since| movers.objects[run.clone()].iter().any(|o| o.built > since));
            for object in run.clone() {
                order.resize(place(object) - place(run.start), GONE);
                order.extend_from_slice(&movers.objects[object].bvh.order);
            }
            self.write_triangles(gpu, surfaces, place(run.start), &order, has_extras);
        }
    }

    /// Uploads triangles in the order of the leaves of their hierarchy, from a place on, with their extras or without.
    fn write_triangles(&self, gpu: &Gpu, surfaces: Surfaces, first: usize, order: &[u32], has_extras: bool) {
        let has_extras = has_extras && self.has_extras;
        let row = ROW as usize;
        let (begun, rest) = order.split_at((first.next_multiple_of(row) - first).min(order.len()));
        let mut place = first;
        let pieces: Vec<(usize, &[u32])> = std::iter::once(begun)
            .chain(rest.chunks(row))
            .map(|piece| {
                place += piece.len();
                (place - piece.len(), piece)
            })
            .collect();
        let encode = |(place, piece): (usize, &[u32])| (place, encode_triangles(surfaces, piece, has_extras));
        for (place, [triangles, attributes, extras]) in parallel::consume(pieces, order.len() / WORTH_A_THREAD, encode)
        {
            // Three rows hold the corners of 4096 triangles.
            let texel = place / row * 3 * row + place % row;
            self.triangles.write_rows(gpu, texel, 3, &triangles);
            self.attributes.write_rows(gpu, texel, 3, &attributes);
            self.extras.write_rows(gpu, texel, 3, &extras);
        }
    }
}

/// What the triangles of a primitive have in common.
struct Shared<'a> {
    primitive: &'a Primitive,
    /// Material and flags.
    head: u32,
    is_mirrored: bool,
    normal_matrix: Mat3,
}

impl<'a> Shared<'a> {
    fn new(primitive: &'a Primitive, materials: &GpuMaterials) -> Self {
        let material = materials.index(primitive.material.id);
        let flag = |set: bool, flag: u32| if set { flag } else { 0 };
        let head = material
            | flag(primitive.material.is_glass(), GLASS)
            | flag(primitive.casts_shadow, CASTS_SHADOW)
            | flag(primitive.material.double_sided, DOUBLE_SIDED)
            | flag(materials.is_masked(material), MASKED);
        let transform = &primitive.world_from_object;
        Self { primitive, head, is_mirrored: is_mirrored(transform), normal_matrix: normal_matrix(transform) }
    }
}

/// Triangles with their attributes and extras: a row for each of the three corners.
fn encode_triangles(surfaces: Surfaces, order: &[u32], has_extras: bool) -> [Vec<Texel>; 3] {
    let Surfaces { scene, bvh: SceneBvh { triangles: all, .. }, materials, emitters } = surfaces;
    let count = order.len();
    let mut triangles = vec![Texel::default(); 3 * count];
    let mut attributes = triangles.clone();
    let mut extras = vec![Texel::default(); if has_extras { 3 * count } else { 0 }];
    let mut last: Option<(u32, Shared)> = None;
    for (place, &index) in order.iter().enumerate().filter(|(_, index)| **index != GONE) {
        let triangle = &all[index as usize];
        let known = last.take().filter(|(primitive, _)| *primitive == triangle.primitive);
        let make = || (triangle.primitive, Shared::new(&scene.primitives[triangle.primitive as usize], materials));
        let (_, shared) = &*last.insert(known.unwrap_or_else(make));
        let mesh = &shared.primitive.mesh;
        let words = [shared.head, emitters.of(index), triangle.primitive];
        let indices = corner_indices(shared.primitive, triangle.triangle, shared.is_mirrored);
        for corner in 0..3 {
            let [x, y, z] = triangle.corners[corner].to_array().map(f32::to_bits);
            let vertex = &mesh.vertices[indices[corner]];
            let normal = encode_direction(turned_normal(&shared.normal_matrix, vertex.normal.into()));
            let [u, v] = vertex.uv.map(f32::to_bits);
            let texel = corner * count + place;
            triangles[texel] = [x, y, z, words[corner]];
            attributes[texel] = [normal, u, v, encode_tangent(shared, vertex.tangent)];
            if has_extras {
                extras[texel] = encode_extra(&mesh.extra(indices[corner]));
            }
        }
    }
    [triangles, attributes, extras]
}

/// Second texture coordinates, then colour and alpha of 16 bits each.
fn encode_extra(extra: &VertexExtra) -> Texel {
    let ([u, v], [r, g, b, a]) = (extra.uv.map(f32::to_bits), extra.color.map(u32::from));
    [u, v, r | g << 16, b | a << 16]
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
    let round = |v: f32| (v + 0.5_f32.copysign(v)) as i32;
    let [x, y] = octahedral(n).to_array().map(|v| round(v * 32767.0) + 32768);
    x as u32 | (y as u32) << 16
}

/// As a direction, but the lowest bit says that the bitangent is turned around, as a transform that mirrors does.
fn encode_tangent(shared: &Shared, [x, y, z, handedness]: [f32; 4]) -> u32 {
    let tangent = shared.primitive.world_from_object.transform_vector3(Vec3::new(x, y, z)).normalize_or_zero();
    if tangent == Vec3::ZERO {
        return 0;
    }
    encode_direction(tangent) & !1 | u32::from((handedness < 0.0) != shared.is_mirrored)
}
