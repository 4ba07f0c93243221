//! Rays, and where they hit boxes and triangles.

use super::Aabb;
use glam::Vec3;

/// A ray: the points `origin + t·direction` with `t` from 0 on. The direction need not be of unit length; distances
/// are in its units, so that they stay the same under a change of space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where it starts.
    pub origin: Vec3,
    /// Where it goes.
    pub direction: Vec3,
    inverse: Vec3,
}

impl Ray {
    /// A ray. Components of the direction that are zero are treated as very small ones, so that no 0·∞ arises.
    pub fn new(origin: Vec3, direction: Vec3) -> Self {
        let inverse = |d: f32| if d.abs() > 1e-30 { 1.0 / d } else { 1e30_f32.copysign(d) };
        let inverse = Vec3::new(inverse(direction.x), inverse(direction.y), inverse(direction.z));
        Self { origin, direction, inverse }
    }

    /// The point at `t`.
    pub fn at(&self, t: f32) -> Vec3 {
        self.origin + t * self.direction
    }

    /// Where the ray enters the box (0 if it starts inside), if it does so before `t_max`. The far side is moved out
    /// by two roundings, so that no box is missed that holds a hit (Ize 2013).
    pub fn enters(&self, bounds: &Aabb, t_max: f32) -> Option<f32> {
        let a = (bounds.min - self.origin) * self.inverse;
        let b = (bounds.max - self.origin) * self.inverse;
        let enter = a.min(b).max_element().max(0.0);
        let leave = a.max(b).min_element() * (1.0 + 4.0 * f32::EPSILON);
        (enter <= leave.min(t_max)).then_some(enter)
    }
}

/// Where a ray meets a triangle: `t` and the barycentric coordinates of the second and third corner (Möller and
/// Trumbore 1997). Both sides count; triangles without area are never met. No tolerance: a scale would be hidden in
/// it.
pub fn intersect_triangle(ray: &Ray, corners: [Vec3; 3], t_max: f32) -> Option<(f32, f32, f32)> {
    let (a, b) = (corners[1] - corners[0], corners[2] - corners[0]);
    let p = ray.direction.cross(b);
    let determinant = a.dot(p);
    if determinant == 0.0 {
        return None;
    }
    let inverse = 1.0 / determinant;
    let s = ray.origin - corners[0];
    let u = s.dot(p) * inverse;
    let q = s.cross(a);
    let v = ray.direction.dot(q) * inverse;
    let t = b.dot(q) * inverse;
    // False for NaN too.
    let hit = u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0 && t < t_max;
    hit.then_some((t, u, v))
}
