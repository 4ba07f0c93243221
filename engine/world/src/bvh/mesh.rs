//! The hierarchy over the triangles of a mesh, in object space.

use super::tree::Bvh;
use crate::core::{Aabb, Ray, intersect_triangle};
use glam::Vec3;

/// Most triangles of a leaf.
const LEAF_SIZE: usize = 4;

/// A hit of a ray on a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshHit {
    /// Distance in units of the ray's direction.
    pub t: f32,
    /// Index of the triangle in the mesh.
    pub triangle: u32,
    /// Barycentric coordinates of its second and third corner.
    pub barycentric: [f32; 2],
}

/// A mesh that rays can be cast at.
#[derive(Clone, Debug, Default)]
pub struct MeshBvh {
    /// The hierarchy over the triangles.
    pub bvh: Bvh,
    /// Corners of all triangles in the order of the mesh.
    corners: Vec<[Vec3; 3]>,
}

impl MeshBvh {
    /// Builds the hierarchy of a soup of triangles.
    pub fn from_triangles(corners: Vec<[Vec3; 3]>) -> Self {
        Self { bvh: Bvh::new(&boxes(&corners), LEAF_SIZE), corners }
    }

    /// Takes new corners for the same triangles, as of a deformed mesh, and fits the boxes to them; rebuilds where
    /// the tree has become half as slow again.
    ///
    /// # Panics
    /// If the number of triangles is another.
    pub fn refit(&mut self, corners: Vec<[Vec3; 3]>) {
        assert_eq!(corners.len(), self.corners.len(), "a refit keeps all triangles");
        let before = self.bvh.cost();
        let boxes = boxes(&corners);
        let left_out = self.bvh.order.len() < corners.len();
        self.bvh.refit(&boxes);
        if left_out || self.bvh.cost() > 1.5 * before {
            self.bvh = Bvh::new(&boxes, LEAF_SIZE);
        }
        self.corners = corners;
    }

    /// Corners of all triangles in the order of the mesh.
    pub fn corners(&self) -> &[[Vec3; 3]] {
        &self.corners
    }

    /// The nearest hit of the ray before `t_max` among the triangles that `accept` takes.
    pub fn closest_hit(&self, ray: &Ray, t_max: f32, mut accept: impl FnMut(&MeshHit) -> bool) -> Option<MeshHit> {
        let mut closest: Option<MeshHit> = None;
        self.bvh.traverse(ray, t_max, |triangle, bound| {
            let Some((t, u, v)) = intersect_triangle(ray, self.corners[triangle as usize], f32::INFINITY) else {
                return bound;
            };
            let hit = MeshHit { t, triangle, barycentric: [u, v] };
            // Where two triangles are met at the same distance the lower index wins, whatever the order of the tree.
            let nearer = t < bound || closest.is_some_and(|best| t == best.t && triangle < best.triangle);
            if nearer && accept(&hit) {
                closest = Some(hit);
                return t;
            }
            bound
        });
        closest
    }

    /// The same by trying every triangle: what the hierarchy is tested against.
    pub fn closest_hit_by_brute_force(&self, ray: &Ray, t_max: f32) -> Option<MeshHit> {
        let mut closest: Option<MeshHit> = None;
        for (&corners, triangle) in self.corners.iter().zip(0..) {
            let bound = closest.map_or(t_max, |hit| hit.t);
            if let Some((t, u, v)) = intersect_triangle(ray, corners, bound) {
                closest = Some(MeshHit { t, triangle, barycentric: [u, v] });
            }
        }
        closest
    }
}

fn boxes(corners: &[[Vec3; 3]]) -> Vec<Aabb> {
    let bounds = |corners: &[Vec3; 3]| {
        if corners.iter().all(|corner| corner.is_finite()) {
            Aabb::from_points(corners.iter().copied())
        } else {
            Aabb::EMPTY
        }
    };
    corners.iter().map(bounds).collect()
}
