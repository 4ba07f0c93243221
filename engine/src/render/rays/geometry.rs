//! Nodes and triangles in the layouts of `lib/ray_scene.wgsl`.

use super::RayError;
use super::boxes::{self, BoxLists, Place};
use super::emitters::Emitters;
use super::materials::GpuMaterials;
use super::words::{ROW, Texel, Words};
use crate::assets::VertexExtra;
use crate::bvh::{Bvh, Node, SceneBvh, vertex_indices, world_normal};
use crate::gpu::Gpu;
use crate::scene::{Aabb, Scene};
use glam::{Affine3A, Vec2, Vec3};
use std::ops::Range;

/// Flags of a triangle, above the index of its material.
const GLASS: u32 = 1 << 28;
const CASTS_SHADOW: u32 = 1 << 29;
const DOUBLE_SIDED: u32 = 1 << 30;
const MASKED: u32 = 1 << 31;

/// Stands for "none".
pub(super) const NONE: u32 = u32::MAX;

/// Geometry on the device: first static objects, then dynamic ones, in rows of its own.
pub(super) struct GpuGeometry {
    nodes: Words,
    triangles: Words,
    attributes: Words,
    extras: Words,
    /// The start of the dynamic objects.
    movers: Place,
    /// The boxes of the dynamic objects, as the device has them.
    moving_boxes: Vec<Texel>,
    has_extras: bool,
    /// Boxes of a list of static objects.
    pub(super) box_count: u32,
    /// Whether the boxes are stored as they are: see [`boxes`].
    pub(super) exact_boxes: bool,
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
            nodes: Words::new(gpu, "ray boxes", 1),
            triangles: Words::new(gpu, "ray triangles", 1),
            attributes: Words::new(gpu, "ray attributes", 1),
            extras: Words::new(gpu, "ray extras", 1),
            movers: Place::default(),
            moving_boxes: Vec::new(),
            has_extras: false,
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

    /// The hierarchies, each with the index of its first triangle.
    pub(super) fn trees<'a>(&self, bvh: &'a SceneBvh) -> [(&'a Bvh, u32); 2] {
        [(&bvh.statics.bvh, 0), (&bvh.movers.bvh, self.movers.triangle)]
    }

    /// Uploads all static objects, and makes room for dynamic ones, which are to be uploaded next.
    pub(super) fn update_statics(&mut self, gpu: &Gpu, surfaces: Surfaces) -> Result<(), RayError> {
        let (statics, movers) = (&surfaces.bvh.statics.bvh, &surfaces.bvh.movers.bvh);
        let moving = surfaces.bvh.moving_triangles();
        let exact = boxes::are_exact(if statics.nodes.is_empty() { movers } else { statics });
        let row = ROW as usize;
        let is_passage = statics.nodes.is_empty() && moving > 0;
        let box_rows = boxes::texel_count(if is_passage { 1 } else { statics.nodes.len() }, exact).div_ceil(row);
        let moving_box_rows = match moving {
            0 => 0,
            _ => boxes::texel_count(boxes::most_boxes(moving), exact).div_ceil(row),
        };
        self.nodes.reserve(gpu, "ray boxes", "hierarchies", box_rows + moving_box_rows)?;
        let first_box = (box_rows * row / boxes::texels_of_box(exact)) as u32;
        let groups = statics.order.len().div_ceil(row);
        let triangle_rows = 3 * (groups + moving.div_ceil(row));
        self.has_extras = !surfaces.materials.is_plain();
        self.triangles.reserve(gpu, "ray triangles", "triangles", triangle_rows)?;
        self.attributes.reserve(gpu, "ray attributes", "triangles", triangle_rows)?;
        self.extras.reserve(gpu, "ray extras", "triangles", if self.has_extras { triangle_rows } else { 0 })?;
        self.moving_boxes.clear();
        self.movers = Place { box_index: first_box, triangle: (groups * row) as u32, next: 0, scene_size: 0.0 };
        let next = if moving > 0 { first_box } else { 0 };
        let lists = match is_passage {
            true => BoxLists::passage(exact, next),
            false => BoxLists::new(statics, exact, Place { next, ..Place::default() }),
        };
        self.nodes.write(gpu, 0, 1, &lists.texels);
        (self.box_count, self.exact_boxes) = (lists.box_count, exact);
        self.write_triangles(gpu, surfaces, statics, 0, |_| true);
        Ok(())
    }

    /// Uploads the rows that changed of the boxes of dynamic objects, and of their triangles those in which any has
    /// changed since a version of it that the device holds; none: all.
    pub(super) fn update_movers(&mut self, gpu: &Gpu, surfaces: Surfaces, since: Option<u64>) {
        if surfaces.bvh.moving_triangles() == 0 {
            return;
        }
        let roots = surfaces.bvh.trees().map(|tree| tree.nodes.first().map_or(Aabb::EMPTY, Node::bounds));
        let scene_size = roots[0].union(&roots[1]).size().max_element();
        let place = Place { scene_size: scene_size.max(f32::MIN_POSITIVE), ..self.movers };
        let movers = &surfaces.bvh.movers.bvh;
        let lists = BoxLists::new(movers, self.exact_boxes, place);
        let row = place.box_index as usize * boxes::texels_of_box(self.exact_boxes) / ROW as usize;
        self.write_boxes(gpu, row, lists.texels);
        let since = since.filter(|since| surfaces.bvh.movers.built <= *since);
        let is_new = |index: u32| {
            let primitive = surfaces.bvh.triangles[index as usize].primitive;
            since.is_none_or(|since| surfaces.bvh.has_changed(primitive, since))
        };
        self.write_triangles(gpu, surfaces, movers, place.triangle as usize / ROW as usize * 3, is_new);
    }

    /// Uploads triangles in the order of the leaves of their hierarchy, from a row on: those rows in which any is new.
    fn write_triangles(&self, gpu: &Gpu, surfaces: Surfaces, bvh: &Bvh, row: usize, is_new: impl Fn(u32) -> bool) {
        let rows: Vec<&[u32]> = bvh.order.chunks(ROW as usize).collect();
        let is_new: Vec<bool> = rows.iter().map(|row| row.iter().any(|&index| is_new(index))).collect();
        for run in runs(&is_new) {
            let texels = texels_of(&run, bvh.order.len());
            self.write_run(gpu, surfaces, &bvh.order[texels], row + 3 * run.start);
        }
    }

    fn write_boxes(&mut self, gpu: &Gpu, row: usize, boxes: Vec<Texel>) {
        let known = if self.moving_boxes.len() == boxes.len() { &self.moving_boxes[..] } else { &[] };
        let mut before = known.chunks(ROW as usize);
        let is_new: Vec<bool> = boxes.chunks(ROW as usize).map(|now| before.next() != Some(now)).collect();
        for run in runs(&is_new) {
            self.nodes.write(gpu, row + run.start, 1, &boxes[texels_of(&run, boxes.len())]);
        }
        self.moving_boxes = boxes;
    }

    fn write_run(&self, gpu: &Gpu, surfaces: Surfaces, order: &[u32], row: usize) {
        let Surfaces { scene, bvh: SceneBvh { triangles: all, .. }, materials, emitters } = surfaces;
        let count = order.len();
        let mut triangles = vec![Texel::default(); 3 * count];
        let mut attributes = triangles.clone();
        let mut extras = vec![Texel::default(); if self.has_extras { 3 * count } else { 0 }];
        for (place, &index) in order.iter().enumerate() {
            let triangle = &all[index as usize];
            let primitive = &scene.primitives[triangle.primitive as usize];
            let material = materials.index(primitive.material.id);
            let flag = |set: bool, flag: u32| if set { flag } else { 0 };
            let head = material
                | flag(primitive.material.is_glass(), GLASS)
                | flag(primitive.casts_shadow, CASTS_SHADOW)
                | flag(primitive.material.double_sided, DOUBLE_SIDED)
                | flag(materials.is_masked(material), MASKED);
            let words = [head, emitters.of(index), triangle.primitive];
            let indices = vertex_indices(primitive, triangle.triangle);
            let vertices = indices.map(|vertex| &primitive.mesh.vertices[vertex]);
            let transform = &primitive.world_from_object;
            for corner in 0..3 {
                let [x, y, z] = triangle.corners[corner].to_array().map(f32::to_bits);
                let vertex = vertices[corner];
                let normal = encode_direction(world_normal(transform, vertex.normal.into()));
                let [u, v] = vertex.uv.map(f32::to_bits);
                let texel = triangle_texel(place, corner, count);
                triangles[texel] = [x, y, z, words[corner]];
                attributes[texel] = [normal, u, v, encode_tangent(transform, vertex.tangent)];
                if !extras.is_empty() {
                    extras[texel] = encode_extra(&primitive.mesh.extra(indices[corner]));
                }
            }
        }
        self.triangles.write(gpu, row, 3, &triangles);
        self.attributes.write(gpu, row, 3, &attributes);
        self.extras.write(gpu, row, 3, &extras);
    }
}

/// The longest ranges in which all are set.
fn runs(are_set: &[bool]) -> Vec<Range<usize>> {
    let mut next = 0;
    let ranges = are_set.chunk_by(|a, b| a == b).map(|run| {
        let first = next;
        next += run.len();
        (run[0], first..next)
    });
    ranges.filter(|(is_set, _)| *is_set).map(|(_, range)| range).collect()
}

/// The texels of some rows, of so many in total.
fn texels_of(rows: &Range<usize>, count: usize) -> Range<usize> {
    rows.start * ROW as usize..count.min(rows.end * ROW as usize)
}

/// Second texture coordinates, then colour and alpha of 16 bits each.
fn encode_extra(extra: &VertexExtra) -> Texel {
    let ([u, v], [r, g, b, a]) = (extra.uv.map(f32::to_bits), extra.color.map(u32::from));
    [u, v, r | g << 16, b | a << 16]
}

/// Where a corner of one of so many triangles lies: three rows hold the corners of 4096 triangles, and the rows of the
/// last ones are as long as these are many.
fn triangle_texel(triangle: usize, corner: usize, count: usize) -> usize {
    let row = ROW as usize;
    let (before, width) = (triangle / row * row, row.min(count - triangle / row * row));
    3 * before + corner * width + triangle - before
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
