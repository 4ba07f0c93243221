//! Spatial queries: ray casts, and how far a ball or a box can move.
//!
//! Every drawn mesh counts, by its triangles and from both sides, unless its entity is a [`NonSolid`]. Two levels: a
//! hierarchy over the objects' boxes, fitted again when one moves, and one over the triangles of each mesh, built when
//! it is first needed. A step sees the space as the step before left it.

mod sweep;
mod update;

pub use update::NonSolid;
pub(super) use update::update;

use crate::assets::Mesh;
use crate::bvh::{Bvh, MeshBvh, Ray};
use crate::scene::Aabb;
use bevy_ecs::prelude::{Entity, Resource};
use glam::{Affine3A, Mat3A, Quat, Vec3};
use std::sync::Arc;
use sweep::{Touch, cast_box, cast_sphere, closest_point};

/// A hit of a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// The entity that is hit.
    pub entity: Entity,
    /// Where \[m\].
    pub point: Vec3,
    /// Unit normal of the surface, towards where the ray comes from.
    pub normal: Vec3,
    /// Distance from the ray's origin \[m\].
    pub distance: f32,
}

/// Where a ball or a box touches something.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// The entity that is touched.
    pub entity: Entity,
    /// Share of the motion up to the touch, 0..1.
    pub fraction: f32,
    /// The point of the surface that is touched (of a box: the one nearest to its centre) \[m\].
    pub point: Vec3,
    /// Unit normal, away from the surface.
    pub normal: Vec3,
    /// How deep a ball is in the surface \[m\]; zero for one that moved there.
    pub depth: f32,
}

/// An object.
#[derive(Clone, Debug)]
struct Instance {
    entity: Entity,
    mesh: Arc<Mesh>,
    world_from_object: Affine3A,
    object_from_world: Affine3A,
    is_ghost: bool,
    casts_shadow: bool,
}

/// All that can be hit and touched.
#[derive(Resource, Clone, Debug, Default)]
pub struct SpatialQuery {
    instances: Vec<Instance>,
    boxes: Vec<Aabb>,
    top: Bvh,
}

/// How far two surfaces are kept apart by [`SpatialQuery::slide_sphere`] \[m\], against rounding.
const SKIN: f32 = 1e-3;

impl SpatialQuery {
    /// The nearest hit of a ray within a distance \[m\], of what counts.
    pub fn cast_ray(&self, origin: Vec3, direction: Vec3, reach: f32, counts: impl Fn(Entity) -> bool) -> Option<Hit> {
        self.cast(origin, direction, reach, |instance| !instance.is_ghost && counts(instance.entity))
    }

    /// Whether nothing that casts shadows stands between two points, of what counts.
    pub fn is_clear(&self, from: Vec3, to: Vec3, counts: impl Fn(Entity) -> bool) -> bool {
        let way = to - from;
        self.cast(from, way, way.length(), |instance| instance.casts_shadow && counts(instance.entity)).is_none()
    }

    fn cast(&self, origin: Vec3, direction: Vec3, reach: f32, counts: impl Fn(&Instance) -> bool) -> Option<Hit> {
        let direction = direction.try_normalize().filter(|_| origin.is_finite())?;
        let mut nearest: Option<Hit> = None;
        self.top.traverse(&Ray::new(origin, direction), reach, |index, bound| {
            let instance = &self.instances[index as usize];
            if !counts(instance) {
                return bound;
            }
            // The direction is not normalised in object space, so that distances stay those of the world.
            let to_object = &instance.object_from_world;
            let ray = Ray::new(to_object.transform_point3(origin), to_object.transform_vector3(direction));
            let bvh = instance.mesh.hierarchy();
            let Some(hit) = bvh.closest_hit(&ray, bound, |_| true) else { return bound };
            let corners = instance.corners(bvh, hit.triangle);
            let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize_or(-direction);
            let normal = if normal.dot(direction) > 0.0 { -normal } else { normal };
            nearest = Some(Hit { entity: instance.entity, point: origin + hit.t * direction, normal, distance: hit.t });
            hit.t
        });
        nearest
    }

    /// The first contact of a moving ball with what counts. Objects that it overlaps at the start do not stop it from leaving.
    pub fn cast_sphere(
        &self,
        center: Vec3,
        radius: f32,
        motion: Vec3,
        counts: impl Fn(Entity) -> bool,
    ) -> Option<Contact> {
        let half = Vec3::splat(radius);
        self.sweep(center, half, motion, counts, |corners| cast_sphere(center, radius, motion, corners))
    }

    /// The first contact of a moving box of these half edges, turned about its centre, with what counts.
    pub fn cast_box(
        &self,
        center: Vec3,
        half: Vec3,
        rotation: Quat,
        motion: Vec3,
        counts: impl Fn(Entity) -> bool,
    ) -> Option<Contact> {
        let axes = Mat3A::from_quat(rotation);
        let reach = Vec3::from(axes.x_axis.abs() * half.x + axes.y_axis.abs() * half.y + axes.z_axis.abs() * half.z);
        let inverse = rotation.inverse();
        self.sweep(center, reach, motion, counts, |corners| {
            let local = corners.map(|corner| inverse * (corner - center));
            let touch = cast_box(half, inverse * motion, local)?;
            Some(Touch { point: center + rotation * touch.point, normal: rotation * touch.normal, ..touch })
        })
    }

    fn sweep(
        &self,
        center: Vec3,
        reach: Vec3,
        motion: Vec3,
        counts: impl Fn(Entity) -> bool,
        touches: impl Fn([Vec3; 3]) -> Option<Touch>,
    ) -> Option<Contact> {
        let ends = [center - reach, center + reach, center + motion - reach, center + motion + reach];
        let mut first: Option<Contact> = None;
        self.for_each_near(&Aabb::from_points(ends), counts, |entity, corners| {
            let Some(touch) = touches(corners) else { return };
            if first.is_none_or(|first| touch.fraction < first.fraction) {
                let Touch { fraction, point, normal } = touch;
                first = Some(Contact { entity, fraction, point, normal, depth: 0.0 });
            }
        });
        first
    }

    /// All that a ball is in, of what counts: one contact for each object, the deepest, the deepest object first.
    pub fn overlap_sphere(&self, center: Vec3, radius: f32, counts: impl Fn(Entity) -> bool) -> Vec<Contact> {
        let mut found: Vec<Contact> = Vec::new();
        let bounds = Aabb { min: center - radius, max: center + radius };
        self.for_each_near(&bounds, counts, |entity, corners| {
            let point = closest_point(center, corners);
            let depth = radius - center.distance(point);
            if !(depth > 0.0) {
                return;
            }
            let flat = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize_or(Vec3::Y);
            let contact = Contact { entity, fraction: 0.0, point, normal: (center - point).normalize_or(flat), depth };
            match found.iter_mut().find(|known| known.entity == entity) {
                Some(known) if known.depth < depth => *known = contact,
                Some(_) => {}
                None => found.push(contact),
            }
        });
        found.sort_by(|a, b| b.depth.total_cmp(&a.depth));
        found
    }

    /// Moves a ball as far as it can go, along what it touches; gives where it ends, and the contacts on the way.
    pub fn slide_sphere(
        &self,
        center: Vec3,
        radius: f32,
        motion: Vec3,
        counts: impl Fn(Entity) -> bool,
    ) -> (Vec3, Vec<Contact>) {
        let (mut at, mut left, mut contacts) = (center, motion, Vec::<Contact>::new());
        // Out of what it is in, as after something moved into it.
        if let Some(deepest) = self.overlap_sphere(at, radius, &counts).first() {
            at += deepest.normal * deepest.depth;
            contacts.push(*deepest);
        }
        for _ in 0..4 {
            let Some(length) = Some(left.length()).filter(|length| *length > 1e-7) else { break };
            let Some(contact) = self.cast_sphere(at, radius, left, &counts) else {
                at += left;
                break;
            };
            // Stops just before the touch, so that rounding does not put it behind the surface.
            at += left * (contact.fraction - SKIN / length).max(0.0);
            left *= 1.0 - contact.fraction;
            left -= contact.normal * left.dot(contact.normal).min(0.0);
            // In a corner: along the edge of the two surfaces.
            if let Some(before) = contacts.last().filter(|before| left.dot(before.normal) < 0.0) {
                let edge = before.normal.cross(contact.normal).normalize_or_zero();
                left = edge * left.dot(edge);
            }
            contacts.push(contact);
        }
        (at, contacts)
    }

    /// Every triangle whose box meets the bounds.
    fn for_each_near(&self, bounds: &Aabb, counts: impl Fn(Entity) -> bool, mut f: impl FnMut(Entity, [Vec3; 3])) {
        self.top.overlapping(bounds, |index| {
            let instance = &self.instances[index as usize];
            if instance.is_ghost || !counts(instance.entity) {
                return;
            }
            let bvh = instance.mesh.hierarchy();
            let local = bounds.transformed(&instance.object_from_world);
            bvh.bvh.overlapping(&local, |triangle| f(instance.entity, instance.corners(bvh, triangle)));
        });
    }
}

impl Instance {
    fn corners(&self, bvh: &MeshBvh, triangle: u32) -> [Vec3; 3] {
        bvh.corners()[triangle as usize].map(|corner| self.world_from_object.transform_point3(corner))
    }
}
