//! Surfels: the scene's surfaces as pieces of equal area, for methods that scatter or gather light at surfaces.
//!
//! Where they lie follows from the mesh alone: each triangle gets its share by cumulative area, and within it the
//! points of the triangular van der Corput sequence (Basu and Owen 2015), of which any first n are spread evenly.

mod openness;
mod patches;
mod still;
mod update;

pub use patches::{NO_PATCH, Patches, cells_from_world};

use super::{Primitive, Scene};
use crate::assets::{AlphaMode, AssetId, Texture, UvMap, Wrap, parallel};
use crate::bvh::{MeshBvh, Ray};
use bytemuck::{Pod, Zeroable};
use glam::{Affine3A, Mat3A, Vec3, Vec4};
use openness::Exposed;
use std::collections::{HashMap, HashSet};
use std::sync::Arc;
use update::Updated;

/// Most surfels of a scene: 64 MiB.
pub const MAX_SURFELS: usize = 1 << 20;

/// Surfels a face of a cell.
const SURFELS_A_FACE: f32 = 8.0;

/// Thickness \[m\] of what has nothing behind it.
const ENDLESS: f32 = 1e30;

/// Cells that fit into what a closed double-sided mesh encloses from which on it is a room, as `ROOM` of
/// `lib/sweep.wgsl`.
const ROOM: f32 = 2.0;

/// Bit of [`Surfel::place`]: the inner side of what may be a room, as `INNER` of `lib/sweep.wgsl`.
const INNER: u32 = 1 << 31;

/// Where in [`Surfel::place`] the eight bits begin that tell how closed the surroundings are, as `CLOSED` of
/// `lib/sweep.wgsl`.
const CLOSED_SHIFT: u32 = 23;

/// What these bits are for a surfel that lies in a crack or cavity.
const HIDDEN: u8 = 255;

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
    /// Index in [`SurfelCloud::places`], see [`Surfel::group`]; the highest bit is set on the inner side of a closed
    /// surface, and the eight after it tell how closed its surroundings are, see [`Surfel::openness`].
    pub place: u32,
    /// Emitted radiance [W/(m² sr)].
    pub emissive: [f32; 3],
    /// Largest cells \[m\] whose faces the object closes whole: the second largest edge of its box, 0 if it has holes.
    pub wall: f32,
}

impl Surfel {
    /// Index in [`SurfelCloud::places`].
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

/// The surfels of a scene.
#[derive(Debug, Default)]
pub struct SurfelCloud {
    /// All surfels, in the order of the scene's primitives.
    pub surfels: Vec<Surfel>,
    /// World from object space, one for each group of primitives that stand at the same place.
    pub places: Vec<Affine3A>,
    /// The same surfels by patches.
    pub patches: Patches,
    /// Index in [`Self::places`] by that of the primitive in the scene; `u32::MAX` for those without surfels.
    pub place_of_primitive: Vec<u32>,
    /// Changes with every change of `surfels`, `patches` and `place_of_primitive`.
    pub revision: u64,
    /// Sum of area·reflectance over the sum of areas: the mean share of light that a surface returns.
    pub mean_albedo: Vec3,
    area: f64,
    /// Whether any surface emits light.
    pub is_emissive: bool,
    built: HashMap<GroupKey, Arc<Vec<Surfel>>>,
    state: Option<(u64, u64, u64, u32)>,
    exposed: Exposed,
    followed: Updated,
}

/// Primitives that stand at the same place make one object: a solid may be split by its materials.
struct Group<'a> {
    place: Affine3A,
    members: Vec<&'a Primitive>,
}

/// All that the surfels of a group depend on. Turning and moving it changes none of them.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct GroupKey {
    members: Vec<(AssetId, AssetId)>,
    /// Bits of the linear part that the surfels are made with.
    linear: [u32; 9],
    fineness: [u32; 2],
}

/// How fine the surfels are.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Fineness {
    /// Surfels a square metre.
    density: f32,
    /// Width from which on the inside of a closed double-sided mesh has surfels too \[m\].
    room: f32,
}

impl Fineness {
    /// For cells of a size \[m\] in a scene of an area \[m²\].
    fn new(cell: f32, area: f64) -> Self {
        Self { density: limited(SURFELS_A_FACE / cell / cell, area), room: ROOM * cell }
    }

    fn bits(&self) -> [u32; 2] {
        [self.density, self.room].map(f32::to_bits)
    }
}

impl SurfelCloud {
    /// Brings the surfels up to date with the scene: as many as cells of a size \[m\] need, eight a face, fewer if
    /// there would be more than [`MAX_SURFELS`]. Costs nothing if nothing changed; an object that only moved keeps its
    /// surfels, and where it is known to be moving no other one is looked at. What lies within a solid that does not move
    /// either has none.
    pub fn update(&mut self, scene: &Scene, cell: f32) {
        let revisions = scene.revisions;
        let state = (scene.identity, revisions.geometry, revisions.materials, cell.to_bits());
        if self.state == Some(state) {
            return;
        }
        self.state = Some(state);
        if self.follow(scene, cell) {
            return;
        }
        let (groups, place_of_primitive) = groups(scene);
        let area: f64 = groups.iter().map(Group::area).sum();
        self.followed.remember(scene, cell, &groups, area);
        let fineness = Fineness::new(cell, area);
        let keys: Vec<GroupKey> = groups.iter().map(|group| group.key(fineness)).collect();
        let used: HashSet<&GroupKey> = keys.iter().collect();
        self.built.retain(|key, _| used.contains(key));
        let missing: Vec<usize> = (0..groups.len()).filter(|&i| !self.built.contains_key(&keys[i])).collect();
        for (index, surfels) in missing.iter().zip(parallel::map(&missing, |&index| groups[index].surfels(fineness))) {
            self.built.insert(keys[*index].clone(), Arc::new(surfels));
        }
        self.places = groups.iter().map(|group| group.place).collect();
        let all = keys.iter().map(|key| self.built[key].clone()).collect();
        let exposed = self.exposed.update(scene, cell, &groups, &keys, all);
        let size = patches::patch_size(fineness.density);
        let arranged = self.patches.update(size, &self.exposed.subjects(&groups, &exposed, size));
        let placed = arranged.iter().zip(0..).flat_map(|(object, place)| {
            object.surfels.iter().map(move |surfel| Surfel { place: place | surfel.place, ..*surfel })
        });
        let surfels: Vec<Surfel> = placed.collect();
        if surfels != self.surfels || place_of_primitive != self.place_of_primitive {
            self.summarise(&surfels);
            self.surfels = surfels;
            self.place_of_primitive = place_of_primitive;
            self.revision += 1;
        }
    }

    /// How far before a surfel rays start that look for what is around it \[m\].
    pub fn before(&self) -> f32 {
        self.exposed.before()
    }

    /// Area of all surfels \[m²\].
    pub fn area(&self) -> f64 {
        self.area
    }

    fn summarise(&mut self, surfels: &[Surfel]) {
        let area: f64 = surfels.iter().map(|s| f64::from(s.area)).sum();
        self.area = area;
        let sum = |channel: usize| -> f64 {
            surfels.iter().map(|s| f64::from(s.albedo[channel]) * f64::from(s.area)).sum::<f64>()
        };
        let mean = |channel| if area > 0.0 { (sum(channel) / area) as f32 } else { 0.0 };
        self.mean_albedo = Vec3::new(mean(0), mean(1), mean(2));
        self.is_emissive = surfels.iter().any(|s| s.emissive != [0.0; 3]);
    }
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

/// The groups, and of which one each primitive of the scene is.
fn groups(scene: &Scene) -> (Vec<Group<'_>>, Vec<u32>) {
    let mut groups: Vec<Group> = Vec::new();
    let mut group_of = vec![u32::MAX; scene.primitives.len()];
    let mut places: HashMap<[u32; 12], usize> = HashMap::new();
    let has_surfels = |p: &&Primitive| p.casts_shadow && p.world_from_object.is_finite();
    for (primitive, group) in scene.primitives.iter().zip(&mut group_of).filter(|(p, _)| has_surfels(p)) {
        let place = primitive.world_from_object;
        let bits = place.to_cols_array().map(f32::to_bits);
        let index = *places.entry(bits).or_insert_with(|| {
            groups.push(Group { place, members: Vec::new() });
            groups.len() - 1
        });
        groups[index].members.push(primitive);
        *group = index as u32;
    }
    (groups, group_of)
}

impl Group<'_> {
    /// Area of all sides that may have surfels \[m²\].
    fn area(&self) -> f64 {
        let area = |p: &&Primitive| {
            let sides = if p.material.double_sided { 2.0 } else { 1.0 };
            triangles(p).map(|t| sides * f64::from(world_area(&self.place.matrix3, &t.corners))).sum()
        };
        self.members.iter().map(area).fold(0.0, |sum: f64, area: f64| sum + area)
    }

    fn key(&self, fineness: Fineness) -> GroupKey {
        let members = self.members.iter().map(|p| (p.mesh.id, p.material.id)).collect();
        let linear = shape(&self.place).to_cols_array().map(f32::to_bits);
        GroupKey { members, linear, fineness: fineness.bits() }
    }

    fn surfels(&self, fineness: Fineness) -> Vec<Surfel> {
        let linear = shape(&self.place);
        let corners: Vec<_> =
            self.members.iter().flat_map(|p| triangles(p)).map(|t| t.corners.map(|c| linear * c)).collect();
        let object = MeshBvh::from_triangles(corners);
        let mut surfels = Vec::new();
        for primitive in &self.members {
            spread(primitive, &linear, &object, fineness, &mut surfels);
        }
        surfels
    }
}

/// The linear part of a place, where it scales evenly without its turn, and rounded: the same for all turned copies of
/// an object, to the last bit.
fn shape(place: &Affine3A) -> Mat3A {
    let m = place.matrix3;
    let square = m.transpose() * m;
    let scale = (square.x_axis.x + square.y_axis.y + square.z_axis.z) / 3.0;
    let uneven = (square - Mat3A::from_diagonal(Vec3::splat(scale))).to_cols_array();
    if uneven.iter().any(|d| !(d.abs() <= 1e-5 * scale)) {
        return m;
    }
    let rounded = ((f64::from(scale).sqrt().log2() * 65536.0).round() / 65536.0).exp2() as f32;
    Mat3A::from_diagonal(Vec3::splat(rounded.copysign(m.determinant())))
}

/// A triangle in object space.
struct Triangle {
    corners: [Vec3; 3],
    uvs: [[f32; 2]; 3],
    /// Indices of the vertices.
    vertices: [usize; 3],
}

fn triangles(primitive: &Primitive) -> impl Iterator<Item = Triangle> {
    let vertices = &primitive.mesh.vertices;
    primitive.mesh.indices.chunks_exact(3).map(move |t| {
        let indices = [t[0], t[1], t[2]].map(|i| i as usize);
        let [a, b, c] = indices.map(|i| &vertices[i]);
        Triangle { corners: [a, b, c].map(|v| v.position.into()), uvs: [a.uv, b.uv, c.uv], vertices: indices }
    })
}

/// Corners of the triangles before the mesh was posed.
fn rest_triangles(primitive: &Primitive) -> impl Iterator<Item = [Vec3; 3]> {
    let mesh = primitive.mesh.rest.as_ref().unwrap_or(&primitive.mesh);
    mesh.indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]].map(|i| Vec3::from(mesh.vertices[i as usize].position)))
}

fn world_area(linear: &Mat3A, corners: &[Vec3; 3]) -> f32 {
    let edge = |i: usize| *linear * (corners[i] - corners[0]);
    let area = 0.5 * edge(1).cross(edge(2)).length();
    if area.is_finite() { area } else { 0.0 }
}

fn spread(primitive: &Primitive, linear: &Mat3A, object: &MeshBvh, fineness: Fineness, surfels: &mut Vec<Surfel>) {
    // A posed mesh has the surfels of its rest, moved along: else they would jump from frame to frame.
    let shares: Vec<f64> = rest_triangles(primitive).map(|corners| f64::from(world_area(linear, &corners))).collect();
    let whole: f64 = shares.iter().sum();
    if !(whole > 0.0) {
        return;
    }
    let count = (whole * f64::from(fineness.density)).ceil().max(1.0);
    let rest_area = whole / count;
    let wall = wall_extent(primitive, linear);
    let turned = if linear.determinant() < 0.0 { -1.0 } else { 1.0 };
    let mut gone = 0.0;
    for (triangle, &share) in triangles(primitive).zip(&shares) {
        let first = (gone / whole * count + 0.5).floor();
        gone += share;
        let stretch = if primitive.mesh.rest.is_some() && share > 0.0 {
            f64::from(world_area(linear, &triangle.corners)) / share
        } else {
            1.0
        };
        let area = (rest_area * stretch) as f32;
        let last = (gone / whole * count + 0.5).floor();
        let [a, b, c] = triangle.corners;
        let normal = (b - a).cross(c - a).normalize_or_zero();
        let facing = turned * (*linear * (b - a)).cross(*linear * (c - a)).normalize_or_zero();
        for index in 0..(last - first) as u32 {
            let weights = point_of_triangle(index);
            let mix = |values: [Vec3; 3]| values[0] * weights[0] + values[1] * weights[1] + values[2] * weights[2];
            let position = mix(triangle.corners);
            let Some((albedo, emissive, coverage)) = surface(primitive, &triangle, weights) else { continue };
            let surfel = Surfel {
                position: position.to_array(),
                area: area * coverage,
                normal: normal.to_array(),
                albedo: albedo.to_array(),
                emissive: emissive.to_array(),
                wall,
                ..Surfel::default()
            };
            let back = Back::of(object, *linear * position, facing, turned);
            if !primitive.material.double_sided {
                surfels.push(Surfel { thickness: back.distance, ..surfel });
                continue;
            }
            let width = if back.is_solid { back.width() } else { 0.0 };
            let other = Surfel { normal: (-normal).to_array(), ..surfel };
            if !back.is_solid {
                surfels.extend([surfel, other]);
            } else if width < fineness.room {
                surfels.push(Surfel { thickness: back.distance, ..surfel });
            } else {
                surfels.extend([surfel, Surfel { place: INNER, ..other }].map(|s| Surfel { thickness: -width, ..s }));
            }
        }
    }
}

/// Largest cells \[m\] in which the primitive is a wall: the second largest edge of its box in the world. An object
/// smaller than a cell in two directions is none, nor is a surface with holes: they stop a part of the light.
pub(crate) fn wall_extent(primitive: &Primitive, linear: &Mat3A) -> f32 {
    if primitive.material.alpha_mode != AlphaMode::Opaque {
        return 0.0;
    }
    let size = primitive.mesh.bounds.size();
    let mut edges =
        [(linear.x_axis * size.x).length(), (linear.y_axis * size.y).length(), (linear.z_axis * size.z).length()];
    edges.sort_by(f32::total_cmp);
    edges[1]
}

/// What lies behind a point of a surface.
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
fn surface(primitive: &Primitive, triangle: &Triangle, weights: [f32; 3]) -> Option<(Vec3, Vec3, f32)> {
    let material = &primitive.material;
    let mix = |values: [[f32; 2]; 3]| -> [f32; 2] {
        std::array::from_fn(|i| (0..3).map(|corner| weights[corner] * values[corner][i]).sum())
    };
    let (mut second, mut color) = ([0.0; 2], Vec4::ONE);
    if primitive.mesh.extras.is_some() {
        let extras = triangle.vertices.map(|vertex| primitive.mesh.extra(vertex));
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
    let albedo = base.truncate().clamp(Vec3::ZERO, Vec3::ONE) * (1.0 - metallic);
    let emissive =
        (material.emissive * texel(&material.emissive_texture, &material.uv.emissive).truncate()).max(Vec3::ZERO);
    let emissive = if material.unlit { emissive * color.truncate() } else { emissive };
    let finite = |v: Vec3| if v.is_finite() { v } else { Vec3::ZERO };
    (coverage > 0.0).then(|| (finite(albedo), finite(emissive), coverage))
}

/// The nearest texel, linear.
pub(crate) fn texel(texture: &Texture, uv: [f32; 2]) -> Vec4 {
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
    let linear = |c: f32| if texture.srgb { crate::measure::srgb_decode(c) } else { c };
    Vec4::new(linear(rgba[0]), linear(rgba[1]), linear(rgba[2]), rgba[3])
}
