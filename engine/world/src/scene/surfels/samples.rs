//! Where the surfels of an object lie on its triangles, and what they are made of.

use super::group::{Group, Triangle, triangle, triangles, world_area};
use super::surfel::{ENDLESS, Fineness, INNER, Surfel};
use crate::assets::{AlphaMode, Mesh, Texture, UvMap, Wrap};
use crate::bvh::{MeshBvh, Ray};
use crate::scene::Primitive;
use glam::{Mat3A, Vec3, Vec4};
use std::sync::Arc;

/// Surfels of balls of light, however small they are.
const LEAST_OF_BALLS: usize = 512;

/// The surfels of an object as it is modelled, and where on its triangles they lie.
#[derive(Debug)]
pub(super) struct Samples {
    pub surfels: Arc<Vec<Surfel>>,
    /// Origin of each surfel; empty unless the object is deformed by skins or morph targets.
    origins: Vec<Origin>,
}

/// Where a surfel lies on its object.
#[derive(Clone, Copy, Debug)]
struct Origin {
    /// Index among the primitives of the object.
    member: u32,
    /// Index of the triangle in its mesh.
    triangle: u32,
    /// Barycentric coordinates.
    weights: [f32; 3],
    /// Whether it is on the side from which the corners run clockwise.
    is_back: bool,
}

impl Samples {
    pub fn new(group: &Group, fineness: Fineness) -> Self {
        let linear = group.shape();
        let corners = group.members.iter().flat_map(|p| triangles(group.mesh(p)));
        let solid = MeshBvh::from_triangles(corners.map(|t| t.corners.map(|c| linear * c)).collect());
        let (mut surfels, mut origins) = (Vec::new(), Vec::new());
        for (primitive, member) in group.members.iter().zip(0..) {
            let spread = Spread { primitive, mesh: group.mesh(primitive), linear, solid: &solid, fineness };
            spread.each(|triangle, weights, sides| {
                for surfel in sides {
                    let is_back = Vec3::from(surfel.normal).dot(sides[0].normal.into()) < 0.0;
                    surfels.push(*surfel);
                    if group.is_bending {
                        origins.push(Origin { member, triangle, weights, is_back });
                    }
                }
            });
        }
        Self { surfels: Arc::new(surfels), origins }
    }

    /// The surfels of an object that bends, where they are in the pose that it has now.
    pub fn posed(&self, group: &Group) -> Vec<Surfel> {
        let (rest, posed) = (group.shape(), group.place.matrix3);
        let pose = |(surfel, origin): (&Surfel, &Origin)| {
            let member = group.members[origin.member as usize];
            let index = origin.triangle as usize;
            let (at_rest, now) = (triangle(group.mesh(member), index), triangle(&member.mesh, index));
            // Joints that mirror turn the corners of a triangle around, but points stay where they are on it.
            let corners = at_rest.vertices.map(|vertex| member.mesh.vertices[vertex].position.into());
            let area_at_rest = world_area(&rest, &at_rest.corners);
            let grown = if area_at_rest > 0.0 { world_area(&posed, &corners) / area_at_rest } else { 1.0 };
            let normal = front(&now.corners) * if origin.is_back { -1.0 } else { 1.0 };
            let emissive =
                if member.mesh.balls.is_some() { glow(member, &now, origin.weights) } else { surfel.emissive };
            Surfel {
                position: weighted(corners, origin.weights).to_array(),
                area: if grown.is_finite() { surfel.area * grown } else { surfel.area },
                normal: normal.to_array(),
                emissive,
                ..*surfel
            }
        };
        self.surfels.iter().zip(&self.origins).map(pose).collect()
    }
}

/// Surfels that a mesh has at least: many balls shine from many places and to all sides, however small they are.
fn least_count(mesh: &Mesh) -> usize {
    mesh.balls.as_ref().map_or(1, |balls| (8 * balls.len()).clamp(1, LEAST_OF_BALLS))
}

/// Emitted radiance of a point of a triangle of balls, which have colours that change over their lives.
fn glow(member: &Primitive, now: &Triangle, weights: [f32; 3]) -> [f32; 3] {
    surface(member, &member.mesh, now, weights).map_or([0.0; 3], |(_, emissive, _)| emissive.to_array())
}

fn weighted(corners: [Vec3; 3], weights: [f32; 3]) -> Vec3 {
    corners[0] * weights[0] + corners[1] * weights[1] + corners[2] * weights[2]
}

/// Unit normal on the side from which the corners run counter-clockwise.
fn front([a, b, c]: &[Vec3; 3]) -> Vec3 {
    (b - a).cross(c - a).normalize_or_zero()
}

/// The source of the surfels of a primitive.
struct Spread<'a> {
    primitive: &'a Primitive,
    mesh: &'a Mesh,
    linear: Mat3A,
    /// All triangles of the object.
    solid: &'a MeshBvh,
    fineness: Fineness,
}

impl Spread<'_> {
    /// Each place of a surfel: its triangle, barycentric coordinates, and the surfels of its sides.
    fn each(&self, mut add: impl FnMut(u32, [f32; 3], &[Surfel])) {
        let areas = triangles(self.mesh).map(|t| f64::from(world_area(&self.linear, &t.corners)));
        let whole: f64 = areas.sum();
        if !(whole > 0.0) {
            return;
        }
        let count = (whole * f64::from(self.fineness.density)).ceil().max(least_count(self.mesh) as f64);
        let area = (whole / count) as f32;
        let wall = wall_extent(self.primitive, self.mesh, &self.linear);
        let mut gone = 0.0;
        for (triangle, number) in triangles(self.mesh).zip(0..) {
            let first = (gone / whole * count + 0.5).floor();
            gone += f64::from(world_area(&self.linear, &triangle.corners));
            let last = (gone / whole * count + 0.5).floor();
            for index in 0..(last - first) as u32 {
                let weights = point_of_triangle(index);
                let Some((albedo, emissive, coverage)) = surface(self.primitive, self.mesh, &triangle, weights) else {
                    continue;
                };
                let surfel = Surfel {
                    position: weighted(triangle.corners, weights).to_array(),
                    area: area * coverage,
                    normal: front(&triangle.corners).to_array(),
                    albedo: albedo.to_array(),
                    emissive: emissive.to_array(),
                    wall,
                    ..Surfel::default()
                };
                self.add_sides(&triangle, surfel, |sides| add(number, weights, sides));
            }
        }
    }

    /// Adds a surfel, and the one on its other side if that can be seen.
    fn add_sides(&self, triangle: &Triangle, surfel: Surfel, add: impl FnOnce(&[Surfel])) {
        let turned = if self.linear.determinant() < 0.0 { -1.0 } else { 1.0 };
        let [a, b, c] = triangle.corners;
        let facing = turned * (self.linear * (b - a)).cross(self.linear * (c - a)).normalize_or_zero();
        let back = Back::of(self.solid, self.linear * Vec3::from(surfel.position), facing, turned);
        if !self.primitive.material.double_sided {
            return add(&[Surfel { thickness: back.distance, ..surfel }]);
        }
        let width = if back.is_solid { back.width() } else { 0.0 };
        let other = Surfel { normal: surfel.normal.map(|n| -n), ..surfel };
        if !back.is_solid {
            add(&[surfel, other]);
        } else if width < self.fineness.room {
            add(&[Surfel { thickness: back.distance, ..surfel }]);
        } else {
            add(&[surfel, Surfel { place: INNER, ..other }].map(|s| Surfel { thickness: -width, ..s }));
        }
    }
}

/// Largest cells \[m\] in which the primitive is a wall: the second largest edge of its box in the world. An object
/// smaller than a cell in two directions is none, nor is a surface with holes: they stop a part of the light.
#[doc(hidden)]
pub fn wall_extent(primitive: &Primitive, mesh: &Mesh, linear: &Mat3A) -> f32 {
    if primitive.material.alpha_mode != AlphaMode::Opaque || mesh.balls.is_some() {
        return 0.0;
    }
    let size = mesh.bounds.size();
    let mut edges =
        [(linear.x_axis * size.x).length(), (linear.y_axis * size.y).length(), (linear.z_axis * size.z).length()];
    edges.sort_by(f32::total_cmp);
    edges[1]
}

/// The material behind a point of a surface.
struct Back<'a> {
    object: &'a MeshBvh,
    point: Vec3,
    /// Unit, to the front.
    normal: Vec3,
    distance: f32,
    /// The next surface is the other side of a solid.
    is_solid: bool,
}

impl<'a> Back<'a> {
    fn of(object: &'a MeshBvh, point: Vec3, normal: Vec3, turned: f32) -> Self {
        let mut back = Self { object, point, normal, distance: ENDLESS, is_solid: false };
        if let Some((distance, triangle)) = back.next(-normal) {
            let [a, b, c] = object.corners()[triangle as usize];
            back.distance = distance;
            back.is_solid = turned * (b - a).cross(c - a).dot(-normal) > 0.0;
        }
        back
    }

    /// Distance and triangle of the next surface in a unit direction.
    fn next(&self, direction: Vec3) -> Option<(f32, u32)> {
        // The surface itself lies at distance zero, give or take a rounding.
        let least = 1e-5 * self.point.abs().max_element().max(1e-30);
        let ray = Ray::new(self.point, direction);
        self.object.closest_hit(&ray, f32::INFINITY, |hit| hit.t > least).map(|hit| (hit.t, hit.triangle))
    }

    /// About the least width of what the surface encloses \[m\], as narrow behind the edge of a plank as behind its
    /// side: that along the normal, or between what rays at 45° meet on both sides. They go along two crosses of
    /// axes, of which the wider one counts, so that a room is as wide in its corners.
    fn width(&self) -> f32 {
        let [u, v] = self.normal.any_orthonormal_pair().into();
        let reach = |axis: Vec3| self.next((axis - self.normal).normalize()).map_or(ENDLESS, |(distance, _)| distance);
        let across = |axis: Vec3| (reach(axis) + reach(-axis)) * std::f32::consts::FRAC_1_SQRT_2;
        let crosses = [[u, v], [(u + v).normalize(), (u - v).normalize()]];
        let widths = crosses.map(|[a, b]| across(a).min(across(b)));
        self.distance.min(widths[0].max(widths[1]))
    }
}

/// Barycentric coordinates of a point of the sequence: the digits of the index in base 4 choose the middle or a corner
/// of the four triangles into which each is split.
fn point_of_triangle(mut index: u32) -> [f32; 3] {
    let mut corners = [Vec3::X, Vec3::Y, Vec3::Z];
    while index > 0 {
        let middle =
            [0.5 * (corners[1] + corners[2]), 0.5 * (corners[2] + corners[0]), 0.5 * (corners[0] + corners[1])];
        corners = match index & 3 {
            0 => middle,
            1 => [corners[0], middle[2], middle[1]],
            2 => [middle[2], corners[1], middle[0]],
            _ => [middle[1], middle[0], corners[2]],
        };
        index >>= 2;
    }
    ((corners[0] + corners[1] + corners[2]) / 3.0).to_array()
}

/// Diffuse reflectance, emitted radiance, and the share of light that meets it, alpha if it is blended; none if that is none.
fn surface(primitive: &Primitive, mesh: &Mesh, triangle: &Triangle, weights: [f32; 3]) -> Option<(Vec3, Vec3, f32)> {
    let material = &primitive.material;
    let mix = |values: [[f32; 2]; 3]| -> [f32; 2] {
        std::array::from_fn(|i| (0..3).map(|corner| weights[corner] * values[corner][i]).sum())
    };
    let (mut second, mut color) = ([0.0; 2], Vec4::ONE);
    if mesh.extras.is_some() {
        let extras = triangle.vertices.map(|vertex| mesh.extra(vertex));
        second = mix(extras.map(|extra| extra.uv));
        color = (0..3).map(|corner| weights[corner] * Vec4::from(extras[corner].rgba())).sum();
    }
    let sets = [mix(triangle.uvs), second];
    let texel = |texture: &Option<Arc<Texture>>, map: &UvMap| {
        texture.as_ref().map_or(Vec4::ONE, |texture| texel(texture, map.apply(sets)))
    };
    let base = material.base_color * color * texel(&material.base_color_texture, &material.uv.base_color);
    let coverage = match material.alpha_mode {
        AlphaMode::Opaque => 1.0,
        AlphaMode::Mask(cutoff) => f32::from(base.w >= cutoff),
        AlphaMode::Blend => base.w.min(1.0),
    };
    let metallic = (material.metallic * texel(&material.metallic_roughness_texture, &material.uv.metallic_roughness).z)
        .clamp(0.0, 1.0);
    let coat = texel(&material.clearcoat_texture, &material.uv.clearcoat).x;
    let sheen = texel(&material.sheen_color_texture, &material.uv.sheen_color).truncate();
    let (left, added) = material.even_layers(coat, sheen);
    let albedo = base.truncate().clamp(Vec3::ZERO, Vec3::ONE) * ((1.0 - metallic) * left) + added;
    let emissive =
        (material.emissive * texel(&material.emissive_texture, &material.uv.emissive).truncate()).max(Vec3::ZERO);
    let emissive = if material.unlit { emissive * color.truncate() } else { emissive };
    let finite = |v: Vec3| if v.is_finite() { v } else { Vec3::ZERO };
    (coverage > 0.0).then(|| (finite(albedo), finite(emissive), coverage))
}

/// The nearest texel, linear.
#[doc(hidden)]
pub fn texel(texture: &Texture, uv: [f32; 2]) -> Vec4 {
    let at = |coordinate: f32, wrap: Wrap, size: u32| {
        let c = if coordinate.is_finite() { coordinate } else { 0.0 };
        let c = match wrap {
            Wrap::Repeat => c - c.floor(),
            Wrap::Mirror => 1.0 - ((c * 0.5).fract().abs() * 2.0 - 1.0).abs(),
            Wrap::Clamp => c.clamp(0.0, 1.0),
        };
        ((c * size as f32) as u32).min(size - 1) as usize
    };
    let x = at(uv[0], texture.sampling.wrap_u, texture.width);
    let y = at(uv[1], texture.sampling.wrap_v, texture.height);
    let first = 4 * (y * texture.width as usize + x);
    let rgba: [f32; 4] = std::array::from_fn(|i| f32::from(texture.rgba[first + i]) / 255.0);
    let linear = |c: f32| if texture.srgb { crate::core::srgb_decode(c) } else { c };
    Vec4::new(linear(rgba[0]), linear(rgba[1]), linear(rgba[2]), rgba[3])
}
