//! The hierarchy over all triangles of a scene, in world space.
//!
//! One level, not two: rays that cross many overlapping objects are twice as fast, and every static triangle is
//! transformed once. Moved objects have the boxes above them fitted anew.

use super::{Bvh, Ray, intersect_triangle};
use crate::assets::AssetId;
use crate::scene::{Aabb, Primitive, Scene, SceneId};
use glam::{Affine3A, Vec3};
use std::time::{Duration, Instant};

/// Most triangles of a leaf.
const LEAF_SIZE: usize = 2;
/// A refitted tree that costs so many times what it did when it was built is built anew.
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
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Updated {
    /// Nothing had changed.
    #[default]
    Nothing,
    /// Boxes were fitted to moved triangles.
    Refitted,
    /// The tree was built.
    Built,
}

/// All surfaces of a scene, ready for rays.
#[derive(Debug, Default)]
pub struct SceneBvh {
    /// Triangles, in the order of the scene's primitives and of their meshes.
    pub triangles: Vec<SceneTriangle>,
    /// The hierarchy over them.
    pub bvh: Bvh,
    /// How long the last update took.
    pub update_time: Duration,
    flags: Vec<Flags>,
    sources: Vec<Source>,
    built_cost: f32,
}

/// Per primitive: what rays may do with it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Flags {
    casts_shadow: bool,
    double_sided: bool,
}

/// Where the triangles of a primitive come from.
#[derive(Clone, Debug, PartialEq)]
struct Source {
    id: SceneId,
    mesh: AssetId,
    topology: AssetId,
    world_from_object: Affine3A,
    first: usize,
}

impl SceneBvh {
    /// The hierarchy of a scene.
    pub fn new(scene: &Scene) -> Self {
        let mut bvh = Self::default();
        bvh.update(scene);
        bvh
    }

    /// Brings everything up to date with the scene. If the same primitives have only moved, the tree is kept and its
    /// boxes are fitted to them, unless that has made it too slow.
    pub fn update(&mut self, scene: &Scene) -> Updated {
        let start = Instant::now();
        let flags = |p: &Primitive| Flags { casts_shadow: p.casts_shadow, double_sided: p.material.double_sided };
        self.flags = scene.primitives.iter().map(flags).collect();
        let same = self.sources.len() == scene.primitives.len()
            && self.sources.iter().zip(&scene.primitives).all(|(s, p)| s.id == p.id && s.topology == p.mesh.topology());
        let updated = if same && !self.sources.is_empty() { self.refit(scene) } else { self.rebuild(scene) };
        self.update_time = start.elapsed();
        updated
    }

    fn rebuild(&mut self, scene: &Scene) -> Updated {
        self.triangles.clear();
        self.sources.clear();
        for (primitive, index) in scene.primitives.iter().zip(0..) {
            self.sources.push(Source {
                id: primitive.id,
                mesh: primitive.mesh.id,
                topology: primitive.mesh.topology(),
                world_from_object: primitive.world_from_object,
                first: self.triangles.len(),
            });
            let count = primitive.mesh.triangle_count() as u32;
            self.triangles.extend((0..count).map(|triangle| SceneTriangle {
                corners: world_corners(primitive, triangle),
                primitive: index,
                triangle,
            }));
        }
        self.build()
    }

    fn build(&mut self) -> Updated {
        self.bvh = Bvh::new(&self.boxes(), LEAF_SIZE);
        self.built_cost = self.bvh.cost();
        Updated::Built
    }

    fn refit(&mut self, scene: &Scene) -> Updated {
        let mut moved = false;
        for (source, primitive) in self.sources.iter_mut().zip(&scene.primitives) {
            if source.world_from_object == primitive.world_from_object && source.mesh == primitive.mesh.id {
                continue;
            }
            moved = true;
            source.mesh = primitive.mesh.id;
            source.world_from_object = primitive.world_from_object;
            let count = primitive.mesh.triangle_count();
            for triangle in &mut self.triangles[source.first..source.first + count] {
                triangle.corners = world_corners(primitive, triangle.triangle);
            }
        }
        if !moved {
            return Updated::Nothing;
        }
        let boxes = self.boxes();
        // Boxes that were empty at the building are in no leaf.
        let placed = boxes.iter().filter(|bounds| !bounds.is_empty()).count();
        if placed != self.bvh.order.len() {
            return self.build();
        }
        self.bvh.refit(&boxes);
        if self.bvh.cost() > WORN_OUT * self.built_cost { self.build() } else { Updated::Refitted }
    }

    fn boxes(&self) -> Vec<Aabb> {
        let bounds = |triangle: &SceneTriangle| {
            if triangle.corners.iter().all(|corner| corner.is_finite()) {
                Aabb::from_points(triangle.corners)
            } else {
                Aabb::EMPTY
            }
        };
        self.triangles.iter().map(bounds).collect()
    }

    /// The nearest surface that the ray meets before `t_max`. Alpha is not looked at.
    pub fn closest_hit(&self, ray: &Ray, t_max: f32, kind: RayKind) -> Option<SceneHit> {
        let mut closest: Option<SceneHit> = None;
        self.bvh.traverse(ray, t_max, |index, bound| match self.meets(ray, index, bound, kind) {
            Some(hit) => {
                closest = Some(hit);
                hit.t
            }
            None => bound,
        });
        closest
    }

    /// Whether anything that casts shadows lies on the ray before `t_max`.
    pub fn is_blocked(&self, ray: &Ray, t_max: f32) -> bool {
        let mut blocked = false;
        self.bvh.traverse(ray, t_max, |index, bound| {
            blocked |= self.meets(ray, index, bound, RayKind::Light).is_some();
            // Nothing lies before the ray's start: a bound below it ends the search.
            if blocked { -1.0 } else { bound }
        });
        blocked
    }

    fn meets(&self, ray: &Ray, index: u32, bound: f32, kind: RayKind) -> Option<SceneHit> {
        let triangle = &self.triangles[index as usize];
        let (t, u, v) = intersect_triangle(ray, triangle.corners, bound)?;
        let flags = self.flags[triangle.primitive as usize];
        let counts = match kind {
            RayKind::Light => flags.casts_shadow,
            RayKind::Camera => flags.double_sided || triangle.is_front(ray),
        };
        counts.then_some(SceneHit { t, triangle: index, barycentric: [u, v] })
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
