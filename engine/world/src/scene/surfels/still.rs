//! Static objects that cast shadows, ready for rays: a hierarchy over objects, above that of each mesh.

use crate::assets::{AlphaMode, AssetId, Material, Mesh, parallel};
use crate::bvh::{Bvh, MeshBvh, Ray};
use crate::scene::{Aabb, Primitive, Scene, SceneId};
use glam::{Affine3A, Vec3};
use std::sync::Arc;

/// Distance, over that from the origin, within which surfaces coincide.
const ROUNDING: f32 = 1e-5;
/// Most surfaces that a ray looks at to tell whether it starts within something.
const MOST_MET: u32 = 8;

/// All objects that stand still, in the order of their identities.
#[derive(Debug, Default)]
pub(super) struct Still {
    objects: Vec<Object>,
    hierarchy: Bvh,
}

/// Where a ray ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Met {
    /// Distance in units of the ray's direction.
    pub t: f32,
    /// It is the back of a surface of which only the front can be seen.
    pub is_back: bool,
    /// It is the front of such a surface; where solids touch it may be both.
    pub is_front: bool,
}

/// The first surface on a segment from one point to another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Obstacle {
    /// Share of the segment before it.
    pub share: f32,
    /// Unit normal of the triangle in the world, of any sign; zero if it has none.
    pub normal: Vec3,
}

#[derive(Debug)]
struct Object {
    state: State,
    bounds: Aabb,
    form: Form,
}

/// All that rays find out about an object.
#[derive(Clone, Copy, Debug, PartialEq)]
struct State {
    id: SceneId,
    mesh: AssetId,
    place: [u32; 12],
    has_back: bool,
}

#[derive(Debug)]
enum Form {
    Mesh {
        mesh: Arc<Mesh>,
        object_from_world: Affine3A,
    },
    /// A place that flattens it has no inverse: its triangles in the world.
    Flat {
        triangles: MeshBvh,
        is_mirrored: bool,
    },
}

impl Still {
    /// Updates everything from the scene. Boxes of what has come, gone or changed, where it was and where it is:
    /// a ray that meets none of them meets what it met before.
    pub fn update(&mut self, scene: &Scene) -> Vec<Aabb> {
        let stands = |p: &&Primitive| p.blocks_light() && !p.moving && p.world_from_object.is_finite();
        let mut before = std::mem::take(&mut self.objects).into_iter().peekable();
        let mut changed = Vec::new();
        for primitive in scene.primitives.iter().filter(stands) {
            while let Some(gone) = before.next_if(|object| object.state.id < primitive.id) {
                changed.push(gone.bounds);
            }
            let known = before.next_if(|object| object.state.id == primitive.id);
            let state = State::of(primitive);
            match known {
                Some(object) if object.state == state => self.objects.push(object),
                known => {
                    changed.extend(known.map(|object| object.bounds));
                    changed.push(primitive.bounds);
                    self.objects.push(Object { state, bounds: primitive.bounds, form: Form::of(primitive) });
                }
            }
        }
        changed.extend(before.map(|gone| gone.bounds));
        if !changed.is_empty() {
            // All that is needed, on all cores.
            parallel::map(&self.objects, |object| object.form.prepare());
            let boxes: Vec<Aabb> = self.objects.iter().map(|object| object.bounds).collect();
            self.hierarchy = Bvh::new(&boxes, 2);
        }
        changed.retain(|bounds| !bounds.is_empty());
        changed
    }

    /// The nearest hit of a ray. Where a back and a front coincide but for rounding it is the back, as below a
    /// block on a floor: nothing depends on the order of objects, how they are turned, or how the hierarchy came about.
    pub fn closest(&self, ray: &Ray) -> Option<Met> {
        let (mut nearest, mut nearest_back, mut nearest_front) = (f32::INFINITY, f32::INFINITY, f32::INFINITY);
        let beyond = |t: f32| t + ROUNDING * (t + ray.origin.abs().max_element());
        self.hierarchy.traverse(ray, f32::INFINITY, |index, bound| {
            let Some(met) = self.objects[index as usize].meets(ray, bound) else { return bound };
            nearest = nearest.min(met.t);
            if met.is_back {
                nearest_back = nearest_back.min(met.t);
            }
            if met.is_front {
                nearest_front = nearest_front.min(met.t);
            }
            beyond(nearest)
        });
        let is_there = |t: f32| t <= beyond(nearest);
        let met = || Met { t: nearest, is_back: is_there(nearest_back), is_front: is_there(nearest_front) };
        (nearest < f32::INFINITY).then(met)
    }

    /// Whether a ray starts within something solid: somewhere on its way it has left more of them than it has entered.
    pub fn is_within(&self, ray: &Ray) -> bool {
        let (mut start, mut left) = (ray.origin, 0);
        for _ in 0..MOST_MET {
            let Some(met) = self.closest(&Ray::new(start, ray.direction)) else { return false };
            left += i32::from(met.is_back) - i32::from(met.is_front);
            if left > 0 {
                return true;
            }
            let rounding = ROUNDING * (met.t + start.abs().max_element());
            start += (met.t + 2.0 * rounding) * ray.direction;
        }
        false
    }

    /// The first hit of a segment; none if each of the two points sees the other.
    pub fn obstacle(&self, from: Vec3, to: Vec3) -> Option<Obstacle> {
        let ray = Ray::new(from, to - from);
        let mut first = None;
        self.hierarchy.traverse(&ray, 1.0, |index, bound| {
            let object = &self.objects[index as usize];
            let Some((share, triangle)) = object.hit(&ray, bound).filter(|(share, _)| *share < bound) else {
                return bound;
            };
            first = Some(Obstacle { share, normal: object.normal(triangle) });
            share
        });
        first
    }
}

impl State {
    fn of(primitive: &Primitive) -> Self {
        Self {
            id: primitive.id,
            mesh: primitive.mesh.id,
            place: primitive.world_from_object.to_cols_array().map(f32::to_bits),
            has_back: has_back(&primitive.material),
        }
    }
}

impl Object {
    /// Distance in units of the ray's direction, and the triangle.
    fn hit(&self, ray: &Ray, t_max: f32) -> Option<(f32, u32)> {
        ray.enters(&self.bounds, t_max)?;
        let hit = match &self.form {
            Form::Mesh { mesh, object_from_world } => {
                mesh.hierarchy().closest_hit(&in_object(ray, object_from_world), t_max, |_| true)?
            }
            Form::Flat { triangles, .. } => triangles.closest_hit(ray, t_max, |_| true)?,
        };
        Some((hit.t, hit.triangle))
    }

    fn meets(&self, ray: &Ray, t_max: f32) -> Option<Met> {
        let (t, triangle) = self.hit(ray, t_max)?;
        let is_back = match &self.form {
            Form::Mesh { mesh, object_from_world } => {
                is_behind(mesh.hierarchy(), triangle, &in_object(ray, object_from_world))
            }
            Form::Flat { triangles, is_mirrored } => is_behind(triangles, triangle, ray) != *is_mirrored,
        };
        let has_back = self.state.has_back;
        Some(Met { t, is_back: is_back && has_back, is_front: !is_back && has_back })
    }

    /// Unit normal of a triangle in the world, of any sign; zero if it has none.
    fn normal(&self, triangle: u32) -> Vec3 {
        let normal = |mesh: &MeshBvh| {
            let [a, b, c] = mesh.corners()[triangle as usize];
            (b - a).cross(c - a).normalize_or_zero()
        };
        match &self.form {
            Form::Mesh { mesh, object_from_world } => {
                (object_from_world.matrix3.transpose() * normal(mesh.hierarchy())).normalize_or_zero()
            }
            Form::Flat { triangles, .. } => normal(triangles),
        }
    }
}

/// A ray in object space. Its direction is not normalised there, so that distances stay those of the world.
fn in_object(ray: &Ray, object_from_world: &Affine3A) -> Ray {
    Ray::new(object_from_world.transform_point3(ray.origin), object_from_world.transform_vector3(ray.direction))
}

impl Form {
    fn of(primitive: &Primitive) -> Self {
        let world_from_object = primitive.world_from_object;
        let object_from_world = world_from_object.inverse();
        let is_invertible = object_from_world.is_finite() && world_from_object.matrix3.determinant() != 0.0;
        if is_invertible {
            return Self::Mesh { mesh: primitive.mesh.clone(), object_from_world };
        }
        let corners = primitive.mesh.hierarchy().corners().iter();
        let in_world = corners.map(|triangle| triangle.map(|corner| world_from_object.transform_point3(corner)));
        let is_mirrored = world_from_object.matrix3.determinant() < 0.0;
        Self::Flat { triangles: MeshBvh::from_triangles(in_world.collect()), is_mirrored }
    }

    /// Builds what rays need.
    fn prepare(&self) {
        if let Self::Mesh { mesh, .. } = self {
            mesh.hierarchy();
        }
    }
}

/// Whether the ray meets the side from which the corners run clockwise.
fn is_behind(mesh: &MeshBvh, triangle: u32, ray: &Ray) -> bool {
    let [a, b, c] = mesh.corners()[triangle as usize];
    (b - a).cross(c - a).dot(ray.direction) >= 0.0
}

/// Whether what lies behind a surface of it is the inside of something.
fn has_back(material: &Material) -> bool {
    !material.double_sided && material.alpha_mode == AlphaMode::Opaque
}
