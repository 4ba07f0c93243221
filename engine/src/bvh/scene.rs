//! The hierarchies over all triangles of a scene, in world space: one of static primitives, one of moving primitives.
//!
//! Objects have no level of their own: rays that cross many overlapping objects are twice as fast, and every static
//! triangle is transformed once. Moved objects have the boxes above them fitted again, which leaves the static part as it
//! is. Of hits at the same distance the one with the lower index counts, unless rounding hides its box.

use super::presplit::presplit;
use super::{Bvh, Ray, intersect_triangle};
use crate::assets::AssetId;
use crate::scene::{Aabb, Primitive, Scene, SceneId};
use glam::{Affine3A, Vec3};
use std::ops::Range;
use std::time::{Duration, Instant};

/// Most triangles of a leaf.
const LEAF_SIZE: usize = 2;
/// A refitted tree that costs so many times what it did when it was built is rebuilt.
const WORN_OUT: f32 = 1.5;

/// What a ray is for, which decides what it can meet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RayKind {
    /// What the camera sees: everything but the backs of single-sided surfaces, as when drawn by triangles.
    Camera,
    /// Light on its way: whatever casts shadows, from both sides.
    Light,
}

/// A triangle of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SceneTriangle {
    /// Corners in world space \[m\], counter-clockwise seen from outside (whether its object is mirrored or not).
    pub corners: [Vec3; 3],
    /// Index in [`Scene::primitives`].
    pub primitive: u32,
    /// Index in the primitive's mesh.
    pub triangle: u32,
}

/// Where a ray meets a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SceneHit {
    /// Distance in units of the ray's direction.
    pub t: f32,
    /// Index in [`SceneBvh::triangles`].
    pub triangle: u32,
    /// Barycentric coordinates of the second and third corner.
    pub barycentric: [f32; 2],
}

/// What the last [`SceneBvh::update`] did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Updated {
    /// Nothing had changed.
    #[default]
    Nothing,
    /// Boxes were fitted to moved triangles.
    Refitted,
    /// A tree was built.
    Built,
}

/// The triangles of some primitives, with a hierarchy of their own.
#[derive(Debug, Default)]
pub struct ScenePart {
    /// The hierarchy over indices in [`SceneBvh::triangles`].
    pub bvh: Bvh,
    /// Changes with the hierarchy, and with anything that rays meet in it.
    pub(crate) version: u64,
    /// The version in which it was built last: since then its triangles have the same order.
    pub(crate) built: u64,
    /// Indices in [`Scene::primitives`].
    primitives: Vec<usize>,
    /// Number of triangles in the hierarchy: those with a box.
    placed: usize,
    built_cost: f32,
}

/// All surfaces of a scene, ready for rays.
#[derive(Debug, Default)]
pub struct SceneBvh {
    /// Triangles, in the order of the scene's primitives and of their meshes.
    pub triangles: Vec<SceneTriangle>,
    /// Those of primitives that are not [moving](Primitive::moving).
    pub statics: ScenePart,
    /// Those of primitives that are.
    pub movers: ScenePart,
    /// How long the last update took.
    pub update_time: Duration,
    /// Changes with which primitives there are in which part, and with their materials.
    pub(crate) surfaces_version: u64,
    flags: Vec<Flags>,
    sources: Vec<Source>,
    /// Identity and statics revision of the last scene, if it tells.
    told: Option<[u64; 2]>,
    versions: u64,
}

/// Per primitive: what rays may do with it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Flags {
    casts_shadow: bool,
    double_sided: bool,
}

impl Flags {
    fn of(primitive: &Primitive) -> Self {
        Self { casts_shadow: primitive.casts_shadow, double_sided: primitive.material.double_sided }
    }
}

/// Where the triangles of a primitive come from.
#[derive(Clone, Debug, PartialEq)]
struct Source {
    id: SceneId,
    mesh: AssetId,
    topology: AssetId,
    material: AssetId,
    is_moving: bool,
    world_from_object: Affine3A,
    first: usize,
    count: usize,
    /// The version of its part in which it changed last.
    changed: u64,
}

impl Source {
    /// Whether the primitive can differ in nothing but place, pose and surface.
    fn is_of(&self, primitive: &Primitive) -> bool {
        self.id == primitive.id
            && self.topology == primitive.mesh.topology()
            && self.is_moving == primitive.moving
            && self.count == primitive.mesh.triangle_count()
    }
}

impl SceneBvh {
    /// The hierarchies of a scene.
    pub fn new(scene: &Scene) -> Self {
        let mut bvh = Self::default();
        bvh.update(scene);
        bvh
    }

    /// Brings everything up to date with the scene. If the same primitives have only moved, the trees are kept and
    /// their boxes are fitted to them, unless that has made them too slow. A part in which nothing moved stays as it is.
    pub fn update(&mut self, scene: &Scene) -> Updated {
        let start = Instant::now();
        let statics = scene.revisions.statics;
        let told = (statics != 0).then_some([scene.identity, statics]);
        let are_statics_kept = told.is_some() && told == self.told;
        let fits = |index: usize| self.sources[index].is_of(&scene.primitives[index]);
        let same = self.sources.len() == scene.primitives.len()
            && if are_statics_kept {
                self.movers.primitives.iter().all(|&index| fits(index))
            } else {
                (0..self.sources.len()).all(fits)
            };
        let updated = if !same || self.sources.is_empty() {
            self.rebuild(scene)
        } else if are_statics_kept {
            self.follow(scene, true)
        } else {
            self.follow(scene, false).max(self.follow(scene, true))
        };
        self.told = told;
        self.update_time = start.elapsed();
        updated
    }

    /// The hierarchies of both parts: static objects, and dynamic ones. Rays go through them in turn.
    pub fn trees(&self) -> [&Bvh; 2] {
        [&self.statics.bvh, &self.movers.bvh]
    }

    /// Number of triangles of moving primitives, with those that have no box and so are in no tree.
    pub(crate) fn moving_triangles(&self) -> usize {
        self.movers.primitives.iter().map(|&index| self.sources[index].count).sum()
    }

    /// Indices of the triangles of a primitive.
    pub(crate) fn triangles_of(&self, primitive: usize) -> Range<usize> {
        let source = &self.sources[primitive];
        source.first..source.first + source.count
    }

    /// Whether a primitive has changed since a version of its part.
    pub(crate) fn has_changed(&self, primitive: u32, since: u64) -> bool {
        self.sources[primitive as usize].changed > since
    }

    fn next_version(&mut self) -> u64 {
        self.versions += 1;
        self.versions
    }

    fn rebuild(&mut self, scene: &Scene) -> Updated {
        let changed = self.next_version();
        self.flags = scene.primitives.iter().map(Flags::of).collect();
        self.sources.clear();
        self.triangles.clear();
        let parts = [&mut self.statics, &mut self.movers];
        for part in parts {
            part.primitives.clear();
        }
        for (primitive, index) in scene.primitives.iter().zip(0..) {
            let count = primitive.mesh.triangle_count();
            self.sources.push(Source {
                id: primitive.id,
                mesh: primitive.mesh.id,
                topology: primitive.mesh.topology(),
                material: primitive.material.id,
                is_moving: primitive.moving,
                world_from_object: primitive.world_from_object,
                first: self.triangles.len(),
                count,
                changed,
            });
            let part = if primitive.moving { &mut self.movers } else { &mut self.statics };
            part.primitives.push(index as usize);
            self.triangles.extend((0..count as u32).map(|triangle| SceneTriangle {
                corners: world_corners(primitive, triangle),
                primitive: index,
                triangle,
            }));
        }
        self.surfaces_version = self.next_version();
        for is_moving in [false, true] {
            let version = self.next_version();
            let (part, triangles) = self.part(is_moving);
            (part.version, part.built) = (version, version);
            part.build(triangles, !is_moving);
        }
        Updated::Built
    }

    /// A part, and what it needs to be built: its triangles.
    fn part(&mut self, is_moving: bool) -> (&mut ScenePart, PartTriangles<'_>) {
        let part = if is_moving { &mut self.movers } else { &mut self.statics };
        (part, PartTriangles { all: &self.triangles, sources: &self.sources })
    }

    /// Brings one part up to date where the same primitives have moved or have other surfaces.
    fn follow(&mut self, scene: &Scene, is_moving: bool) -> Updated {
        let version = self.next_version();
        let (mut moved, mut has_other_surfaces, mut has_other_flags) = (false, false, false);
        let part = if is_moving { &self.movers } else { &self.statics };
        for &index in &part.primitives {
            let (source, primitive) = (&mut self.sources[index], &scene.primitives[index]);
            let flags = Flags::of(primitive);
            let (has_flags, has_surface) = (flags == self.flags[index], source.material == primitive.material.id);
            (has_other_flags, has_other_surfaces) = (has_other_flags || !has_flags, has_other_surfaces || !has_surface);
            if !has_flags || !has_surface {
                source.changed = version;
            }
            self.flags[index] = flags;
            source.material = primitive.material.id;
            if source.world_from_object == primitive.world_from_object && source.mesh == primitive.mesh.id {
                continue;
            }
            moved = true;
            source.changed = version;
            source.mesh = primitive.mesh.id;
            source.world_from_object = primitive.world_from_object;
            for triangle in &mut self.triangles[source.first..source.first + source.count] {
                triangle.corners = world_corners(primitive, triangle.triangle);
            }
        }
        if has_other_surfaces {
            self.surfaces_version = self.next_version();
        }
        if moved || has_other_surfaces || has_other_flags {
            let (part, triangles) = self.part(is_moving);
            part.version = version;
            let updated = if moved { part.refit(triangles, !is_moving) } else { Updated::Nothing };
            if updated == Updated::Built {
                part.built = version;
            }
            return updated;
        }
        Updated::Nothing
    }

    /// The nearest surface that the ray meets before `t_max`. Alpha is not looked at.
    pub fn closest_hit(&self, ray: &Ray, t_max: f32, kind: RayKind) -> Option<SceneHit> {
        let mut closest: Option<SceneHit> = None;
        for bvh in self.trees() {
            let bound = closest.map_or(t_max, |hit| hit.t);
            bvh.traverse(ray, bound, |index, bound| match self.meets(ray, index, kind) {
                Some(hit) if is_nearer(hit.t, index, bound, closest.map(|best| (best.t, best.triangle))) => {
                    closest = Some(hit);
                    hit.t
                }
                _ => bound,
            });
        }
        closest
    }

    /// The same by trying every triangle: what the hierarchies are tested against.
    pub fn closest_hit_by_brute_force(&self, ray: &Ray, t_max: f32, kind: RayKind) -> Option<SceneHit> {
        let mut closest: Option<SceneHit> = None;
        for index in 0..self.triangles.len() as u32 {
            let bound = closest.map_or(t_max, |hit| hit.t);
            closest = self.meets(ray, index, kind).filter(|hit| hit.t < bound).or(closest);
        }
        closest
    }

    /// Whether anything that casts shadows lies on the ray before `t_max`.
    pub fn is_blocked(&self, ray: &Ray, t_max: f32) -> bool {
        let mut blocked = false;
        for bvh in self.trees() {
            bvh.traverse(ray, t_max, |index, bound| {
                blocked |= self.meets(ray, index, RayKind::Light).is_some_and(|hit| hit.t < bound);
                // Nothing lies before the ray's start: a bound below it ends the search.
                if blocked { -1.0 } else { bound }
            });
            if blocked {
                return true;
            }
        }
        false
    }

    fn meets(&self, ray: &Ray, index: u32, kind: RayKind) -> Option<SceneHit> {
        let triangle = &self.triangles[index as usize];
        let (t, u, v) = intersect_triangle(ray, triangle.corners, f32::INFINITY)?;
        let flags = self.flags[triangle.primitive as usize];
        let counts = match kind {
            RayKind::Light => flags.casts_shadow,
            RayKind::Camera => flags.double_sided || triangle.is_front(ray),
        };
        counts.then_some(SceneHit { t, triangle: index, barycentric: [u, v] })
    }
}

/// Whether a hit at `t` counts rather than the closest one so far (its distance and triangle): where two triangles are
/// met at the same distance the lower index wins, whatever the order of the trees.
pub(crate) fn is_nearer(t: f32, triangle: u32, bound: f32, closest: Option<(f32, u32)>) -> bool {
    t < bound || closest.is_some_and(|best| t == best.0 && triangle < best.1)
}

/// All triangles of a scene, and where those of each primitive lie.
#[derive(Clone, Copy)]
struct PartTriangles<'a> {
    all: &'a [SceneTriangle],
    sources: &'a [Source],
}

impl PartTriangles<'_> {
    fn bounds(&self, index: usize) -> Aabb {
        let corners = self.all[index].corners;
        if corners.iter().all(|corner| corner.is_finite()) { Aabb::from_points(corners) } else { Aabb::EMPTY }
    }
}

impl ScenePart {
    /// Indices of its triangles.
    fn indices<'a>(&'a self, triangles: PartTriangles<'a>) -> impl Iterator<Item = usize> + 'a {
        let sources = self.primitives.iter().map(move |&index| &triangles.sources[index]);
        sources.flat_map(|source| source.first..source.first + source.count)
    }

    /// Builds the hierarchy. Static triangles may be in several leaves, see [`presplit`]; the boxes of dynamic ones are
    /// fitted again to whole triangles in most frames, and so they are in one.
    fn build(&mut self, triangles: PartTriangles, is_static: bool) -> Updated {
        let indices: Vec<usize> = self.indices(triangles).collect();
        let boxes: Vec<Aabb> = indices.iter().map(|&index| triangles.bounds(index)).collect();
        self.placed = boxes.iter().filter(|bounds| !bounds.is_empty()).count();
        if is_static {
            let corners: Vec<[Vec3; 3]> = indices.iter().map(|&index| triangles.all[index].corners).collect();
            let (pieces, triangle_of) = presplit(&corners, &boxes);
            self.bvh = Bvh::new(&pieces, LEAF_SIZE);
            self.bvh.order.iter_mut().for_each(|entry| *entry = triangle_of[*entry as usize]);
        } else {
            self.bvh = Bvh::new(&boxes, LEAF_SIZE);
        }
        self.bvh.order.iter_mut().for_each(|entry| *entry = indices[*entry as usize] as u32);
        self.built_cost = self.bvh.cost();
        Updated::Built
    }

    fn refit(&mut self, triangles: PartTriangles, is_static: bool) -> Updated {
        // Boxes that were empty at the building are in no leaf.
        let placed = self.indices(triangles).filter(|&index| !triangles.bounds(index).is_empty()).count();
        if placed != self.placed {
            return self.build(triangles, is_static);
        }
        self.bvh.refit_by(|index| triangles.bounds(index as usize));
        if self.bvh.cost() > WORN_OUT * self.built_cost { self.build(triangles, is_static) } else { Updated::Refitted }
    }
}

impl SceneTriangle {
    /// Normal, as long as twice the area \[m²\].
    pub fn area_normal(&self) -> Vec3 {
        let [a, b, c] = self.corners;
        (b - a).cross(c - a)
    }

    /// Whether the ray meets the side from which the corners run counter-clockwise.
    pub fn is_front(&self, ray: &Ray) -> bool {
        self.area_normal().dot(ray.direction) < 0.0
    }
}

/// Corners of a triangle of the primitive's mesh in world space. A mirroring transform turns the order around, so that
/// outside stays outside.
fn world_corners(primitive: &Primitive, triangle: u32) -> [Vec3; 3] {
    let mut corners = std::array::from_fn(|corner| {
        let vertex = &primitive.mesh.vertices[corner_index(primitive, triangle, corner)];
        primitive.world_from_object.transform_point3(vertex.position.into())
    });
    if is_mirrored(&primitive.world_from_object) {
        corners.swap(1, 2);
    }
    corners
}

/// Whether a transform turns the inside out.
fn is_mirrored(transform: &Affine3A) -> bool {
    transform.matrix3.determinant() < 0.0
}

fn corner_index(primitive: &Primitive, triangle: u32, corner: usize) -> usize {
    primitive.mesh.indices[3 * triangle as usize + corner] as usize
}

/// Indices of a triangle's vertices in its mesh, in the order of [`SceneTriangle::corners`].
pub(crate) fn vertex_indices(primitive: &Primitive, triangle: u32) -> [usize; 3] {
    let mut indices = std::array::from_fn(|corner| corner_index(primitive, triangle, corner));
    if is_mirrored(&primitive.world_from_object) {
        indices.swap(1, 2);
    }
    indices
}

/// World normal of an object's normal, by the cofactor matrix, which singular transforms have too; the sign of the
/// determinant is taken out, so that mirrored objects keep their outside. Zero stays zero.
pub(crate) fn world_normal(transform: &Affine3A, normal: Vec3) -> Vec3 {
    let m = transform.matrix3;
    let (x, y, z) = (Vec3::from(m.x_axis), Vec3::from(m.y_axis), Vec3::from(m.z_axis));
    let cofactor = y.cross(z) * normal.x + z.cross(x) * normal.y + x.cross(y) * normal.z;
    let largest = cofactor.abs().max_element();
    if !(largest > 0.0 && largest.is_finite()) {
        return Vec3::ZERO;
    }
    let unit = (cofactor / largest).normalize_or_zero();
    if is_mirrored(transform) { -unit } else { unit }
}
