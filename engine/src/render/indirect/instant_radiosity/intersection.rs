//! How particles find what they hit: through the hierarchy, or object by object in local space as the report does, or
//! by the oriented boxes around objects as it suggests.

use super::surface::is_cut_out;
use crate::bvh::{Bvh, MAX_DEPTH, MeshBvh, Ray, intersect_triangle};
use crate::scene::{Primitive, Scene};
use crate::scene::{SceneBvh, is_nearer, vertex_indices};
use crate::world::ParticleCasts;
use glam::{Affine3A, Vec3};
use std::ops::AddAssign;

/// Intersection tests.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct IntersectionCounts {
    /// Rays cast.
    pub rays: u64,
    /// Boxes of the hierarchy tested.
    pub boxes: u64,
    /// Objects tested in their local space.
    pub objects: u64,
    /// Triangles tested.
    pub triangles: u64,
}

impl AddAssign for IntersectionCounts {
    fn add_assign(&mut self, other: Self) {
        self.rays += other.rays;
        self.boxes += other.boxes;
        self.objects += other.objects;
        self.triangles += other.triangles;
    }
}

impl IntersectionCounts {
    /// All tests together.
    pub fn tests(&self) -> u64 {
        self.boxes + self.objects + self.triangles
    }
}

/// A hit of a ray in the scene: distance, triangle of the hierarchy's list, and barycentric coordinates of the second
/// and third corner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CastHit {
    /// Distance in units of the ray's direction.
    pub t: f32,
    /// Index in [`SceneBvh::triangles`].
    pub triangle: u32,
    /// Barycentric coordinates.
    pub barycentric: [f32; 2],
    /// Unit normal, on the side of the ray, of the box that stands for the object; none where its surface was hit.
    pub box_normal: Option<Vec3>,
}

/// Distance at which a ray meets the unit square in z = 0: t = −o_z/d_z where |x|, |y| ≤ ½.
pub fn intersect_square(ray: &Ray) -> Option<f32> {
    let t = -ray.origin.z / ray.direction.z;
    let at = ray.at(t);
    (t > 0.0 && t.is_finite() && at.x.abs() <= 0.5 && at.y.abs() <= 0.5).then_some(t)
}

/// Distance at which a ray meets the box [−½, ½]³ by its slabs: the entry, and from inside the exit.
pub fn intersect_unit_box(ray: &Ray) -> Option<f32> {
    let inverse = ray.direction.recip();
    let (a, b) = ((Vec3::splat(-0.5) - ray.origin) * inverse, (Vec3::splat(0.5) - ray.origin) * inverse);
    // 0·∞ where the ray runs within a slab's plane: that slab bounds nothing.
    let low = Vec3::select(a.is_nan_mask() | b.is_nan_mask(), Vec3::NEG_INFINITY, a.min(b)).max_element();
    let high = Vec3::select(a.is_nan_mask() | b.is_nan_mask(), Vec3::INFINITY, a.max(b)).min_element();
    if !(low <= high) {
        return None;
    }
    let t = if low > 0.0 { low } else { high };
    (t > 0.0 && t.is_finite()).then_some(t)
}

/// The shape of an object for the brute force.
enum Form {
    /// Two triangles that make a rectangle.
    Square,
    /// Twelve that make a box.
    Box,
    /// Triangles in world space.
    Mesh(MeshBvh),
    /// The box around an object, and its triangles in world space for rays that start within.
    Bounds(MeshBvh),
}

/// An object in its own space.
struct Object {
    /// Local from world space; for squares and boxes the unit square and box.
    local_from_world: Affine3A,
    form: Form,
    /// First triangle in the hierarchy's list.
    first: u32,
    count: u32,
    casts_shadow: bool,
}

/// Where on an object a ray met it.
enum Place {
    /// On that of its triangles.
    Triangle(u32),
    /// On the square or box that it is.
    Form,
    /// On the box around it, with its normal on the side of the ray.
    Box(Vec3),
}

impl Object {
    /// Distance and place of the hit before `bound`, if there is one.
    fn meet(&self, ray: &Ray, bound: f32, counts: &mut IntersectionCounts) -> Option<(f32, Place)> {
        let local = Ray::new(
            self.local_from_world.transform_point3(ray.origin),
            self.local_from_world.transform_vector3(ray.direction),
        );
        match &self.form {
            Form::Square => intersect_square(&local).map(|t| (t, Place::Form)),
            Form::Box => intersect_unit_box(&local).map(|t| (t, Place::Form)),
            Form::Mesh(mesh) => meet_mesh(mesh, ray, bound, counts),
            Form::Bounds(mesh) if local.origin.abs().max_element() <= 0.5 => meet_mesh(mesh, ray, bound, counts),
            Form::Bounds(_) => intersect_unit_box(&local).map(|t| (t, Place::Box(self.box_normal(ray, local.at(t))))),
        }
    }

    /// World-space normal of the unit box at a place on it, on the side of the ray.
    fn box_normal(&self, ray: &Ray, local: Vec3) -> Vec3 {
        let axis = if local.abs().x == local.abs().max_element() {
            Vec3::X
        } else if local.abs().y == local.abs().max_element() {
            Vec3::Y
        } else {
            Vec3::Z
        };
        // Normals go by the inverse transpose of what points go by.
        let normal = (self.local_from_world.matrix3.transpose() * axis).normalize_or_zero();
        if normal.dot(ray.direction) > 0.0 { -normal } else { normal }
    }
}

/// Tests all triangles of a mesh.
fn meet_mesh(mesh: &MeshBvh, ray: &Ray, bound: f32, counts: &mut IntersectionCounts) -> Option<(f32, Place)> {
    counts.triangles += mesh.corners().len() as u64;
    mesh.closest_hit_by_brute_force(ray, bound).map(|hit| (hit.t, Place::Triangle(hit.triangle)))
}

/// Casts rays of particles into a scene.
pub struct Caster<'a> {
    scene: &'a Scene,
    bvh: &'a SceneBvh,
    objects: Option<Vec<Object>>,
}

impl<'a> Caster<'a> {
    /// A caster by the hierarchy, or object by object.
    pub fn new(scene: &'a Scene, bvh: &'a SceneBvh, casts: ParticleCasts) -> Self {
        let objects = match casts {
            ParticleCasts::Hierarchy => None,
            ParticleCasts::BruteForce => Some(objects(scene, false)),
            ParticleCasts::Bounds => Some(objects(scene, true)),
        };
        Self { scene, bvh, objects }
    }

    /// The nearest surface that casts shadows; what alpha cuts out does not count.
    pub fn cast(&self, ray: &Ray, counts: &mut IntersectionCounts) -> Option<CastHit> {
        counts.rays += 1;
        match &self.objects {
            None => self.through_hierarchy(ray, counts),
            Some(objects) => self.object_by_object(ray, objects, counts),
        }
    }

    fn through_hierarchy(&self, ray: &Ray, counts: &mut IntersectionCounts) -> Option<CastHit> {
        let mut closest = None;
        self.bvh.traverse_trees(ray, f32::INFINITY, |tree, bound| {
            self.through_tree(tree, ray, &mut closest, counts);
            closest.map_or(bound, |hit: CastHit| hit.t)
        });
        closest
    }

    fn through_tree(&self, tree: &Bvh, ray: &Ray, closest: &mut Option<CastHit>, counts: &mut IntersectionCounts) {
        let (nodes, order) = (&tree.nodes, &tree.order);
        let mut bound = closest.map_or(f32::INFINITY, |hit| hit.t);
        let mut stack = [0_u32; 2 * (MAX_DEPTH as usize + 32)];
        let mut top = usize::from(!nodes.is_empty());
        while top > 0 {
            top -= 1;
            let node = &nodes[stack[top] as usize];
            counts.boxes += 1;
            if node.entry(ray, bound).is_none() {
                continue;
            }
            if node.count == 0 {
                let [left, right] = [node.first, node.first + 1];
                let entry = |child: u32| nodes[child as usize].entry(ray, bound).unwrap_or(f32::INFINITY);
                let near_first = entry(left) <= entry(right);
                let pair = if near_first { [right, left] } else { [left, right] };
                stack[top..top + 2].copy_from_slice(&pair);
                top += 2;
                continue;
            }
            for &index in &order[node.first as usize..][..node.count as usize] {
                counts.triangles += 1;
                if let Some(hit) = self.meet(ray, index, bound, *closest) {
                    bound = hit.t;
                    *closest = Some(hit);
                }
            }
        }
    }

    fn meet(&self, ray: &Ray, index: u32, bound: f32, closest: Option<CastHit>) -> Option<CastHit> {
        let triangle = &self.bvh.triangles[index as usize];
        let (t, u, v) = intersect_triangle(ray, triangle.corners, f32::INFINITY)?;
        let counts = is_nearer(t, index, bound, closest.map(|best| (best.t, best.triangle)))
            && self.scene.primitives[triangle.primitive as usize].blocks_light()
            && !is_cut_out(self.scene, self.bvh, index, [u, v]);
        counts.then_some(CastHit { t, triangle: index, barycentric: [u, v], box_normal: None })
    }

    fn object_by_object(&self, ray: &Ray, objects: &[Object], counts: &mut IntersectionCounts) -> Option<CastHit> {
        let mut closest = None;
        let mut bound = f32::INFINITY;
        for object in objects.iter().filter(|object| object.casts_shadow) {
            counts.objects += 1;
            if let Some((t, place)) = object.meet(ray, bound, counts).filter(|(t, _)| *t < bound) {
                bound = t;
                closest = Some((object, place));
            }
        }
        let (object, place) = closest?;
        self.finish(object, ray, bound, place)
    }

    /// The hit on the object that was met first.
    fn finish(&self, object: &Object, ray: &Ray, t: f32, place: Place) -> Option<CastHit> {
        let (triangle, barycentric, box_normal) = match place {
            Place::Triangle(triangle) => {
                let triangle = object.first + triangle;
                (triangle, self.barycentric(triangle, ray.at(t)), None)
            }
            Place::Form => {
                let (triangle, barycentric) = self.triangle_at(object, ray, t)?;
                (triangle, barycentric, None)
            }
            Place::Box(normal) => {
                let (triangle, barycentric) = self.material_at(object, ray, t)?;
                (triangle, barycentric, Some(normal))
            }
        };
        Some(CastHit { t, triangle, barycentric, box_normal })
    }

    /// The triangle whose material stands for a place on an object's box: the nearest one where texture or vertex
    /// colours tell triangles apart, else any, since looking for it costs what the box saves.
    fn material_at(&self, object: &Object, ray: &Ray, t: f32) -> Option<(u32, [f32; 2])> {
        let primitive = &self.scene.primitives[self.bvh.triangles.get(object.first as usize)?.primitive as usize];
        let material = &primitive.material;
        let differs = primitive.mesh.extras.is_some()
            || material.base_color_texture.is_some()
            || material.metallic_roughness_texture.is_some()
            || material.specular_texture.is_some()
            || material.specular_color_texture.is_some();
        if differs { self.triangle_at(object, ray, t) } else { Some((object.first, [1.0 / 3.0; 2])) }
    }

    /// The triangle of an object that lies nearest to a point on its square or box, facing the ray alike.
    fn triangle_at(&self, object: &Object, ray: &Ray, t: f32) -> Option<(u32, [f32; 2])> {
        let at = ray.at(t);
        let error = |index: u32| {
            let [u, v] = self.barycentric(index, at);
            let [a, b, c] = self.bvh.triangles[index as usize].corners;
            let (u, v) = (u.clamp(0.0, 1.0), v.clamp(0.0, 1.0));
            let (u, v) = if u + v > 1.0 { (u / (u + v), v / (u + v)) } else { (u, v) };
            ((1.0 - u - v) * a + u * b + v * c).distance_squared(at)
        };
        let all = object.first..object.first + object.count;
        let nearest = all.min_by(|&a, &b| error(a).total_cmp(&error(b)))?;
        let [u, v] = self.barycentric(nearest, at).map(|c| c.clamp(0.0, 1.0));
        Some((nearest, [u, v.min(1.0 - u)]))
    }

    fn barycentric(&self, index: u32, at: Vec3) -> [f32; 2] {
        let [a, b, c] = self.bvh.triangles[index as usize].corners;
        let (e, f, p) = (b - a, c - a, at - a);
        let (ee, ef, ff, pe, pf) = (e.dot(e), e.dot(f), f.dot(f), p.dot(e), p.dot(f));
        let scale = 1.0 / (ee * ff - ef * ef).max(f32::MIN_POSITIVE);
        [(ff * pe - ef * pf) * scale, (ee * pf - ef * pe) * scale]
    }
}

fn objects(scene: &Scene, by_bounds: bool) -> Vec<Object> {
    let mut first = 0;
    let mut objects = Vec::with_capacity(scene.primitives.len());
    for primitive in &scene.primitives {
        let count = primitive.mesh.triangle_count() as u32;
        objects.push(object(primitive, first, count, by_bounds));
        first += count;
    }
    objects
}

fn object(primitive: &Primitive, first: u32, count: u32, by_bounds: bool) -> Object {
    let bounds = primitive.mesh.bounds;
    let size = bounds.size();
    let singular = !(primitive.world_from_object.matrix3.determinant().abs() > 0.0);
    let flat = (0..3).find(|&axis| size[axis] == 0.0);
    let form = match flat {
        _ if singular || bounds.is_empty() => None,
        // A flat box needs no normal of its own: the object's triangles have it.
        Some(axis) if by_bounds || is_rectangle(primitive, axis) => Some((Form::Square, square(size, axis))),
        None if is_box(primitive) => Some((Form::Box, Affine3A::from_scale(size))),
        None if by_bounds => Some((Form::Bounds(world_mesh(primitive, count)), Affine3A::from_scale(size))),
        _ => None,
    };
    let (form, world_from_local) = match form {
        Some((form, shape)) => {
            (form, primitive.world_from_object * Affine3A::from_translation(bounds.center()) * shape)
        }
        None => (Form::Mesh(world_mesh(primitive, count)), Affine3A::IDENTITY),
    };
    Object { local_from_world: world_from_local.inverse(), form, first, count, casts_shadow: primitive.blocks_light() }
}

/// World-space triangles, so that singular objects do as they do in the hierarchy.
fn world_mesh(primitive: &Primitive, count: u32) -> MeshBvh {
    let corner = |triangle: u32| {
        vertex_indices(primitive, triangle)
            .map(|vertex| primitive.world_from_object.transform_point3(primitive.mesh.vertices[vertex].position.into()))
    };
    MeshBvh::from_triangles((0..count).map(corner).collect())
}

/// The unit square in z = 0 stretched to a box that is flat along an axis.
fn square(size: Vec3, axis: usize) -> Affine3A {
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    let along = |axis: usize, length: f32| {
        let mut vector = Vec3::ZERO;
        vector[axis] = length;
        vector
    };
    let m = glam::Mat3::from_cols(along(u, size[u]), along(v, size[v]), along(axis, 1.0));
    Affine3A::from_mat3(m)
}

fn is_plain(primitive: &Primitive) -> bool {
    let m = &primitive.material;
    m.alpha_mode == crate::assets::AlphaMode::Opaque
}

/// All vertices lie at corners of the bounds, and the area is that of one side.
fn is_rectangle(primitive: &Primitive, axis: usize) -> bool {
    let size = primitive.mesh.bounds.size();
    let area = size[(axis + 1) % 3] * size[(axis + 2) % 3];
    is_plain(primitive) && primitive.mesh.triangle_count() == 2 && at_corners(primitive) && has_area(primitive, area)
}

fn is_box(primitive: &Primitive) -> bool {
    let s = primitive.mesh.bounds.size();
    let area = 2.0 * (s.x * s.y + s.y * s.z + s.z * s.x);
    is_plain(primitive) && primitive.mesh.triangle_count() == 12 && at_corners(primitive) && has_area(primitive, area)
}

fn at_corners(primitive: &Primitive) -> bool {
    let bounds = primitive.mesh.bounds;
    primitive.mesh.vertices.iter().all(|vertex| {
        (0..3).all(|axis| vertex.position[axis] == bounds.min[axis] || vertex.position[axis] == bounds.max[axis])
    })
}

fn has_area(primitive: &Primitive, area: f32) -> bool {
    let corner = |&index: &u32| Vec3::from(primitive.mesh.vertices[index as usize].position);
    let triangles = primitive.mesh.indices.chunks_exact(3);
    let own: f32 =
        triangles.map(|t| 0.5 * (corner(&t[1]) - corner(&t[0])).cross(corner(&t[2]) - corner(&t[0])).length()).sum();
    (own - area).abs() < 1e-4 * area
}
