//! Triangles of a scene in world space, and the order of their corners.

use super::Ray;
use crate::scene::Primitive;
use glam::{Affine3A, Vec3};

/// A triangle of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SceneTriangle {
    /// Corners in world space \[m\], counter-clockwise seen from outside (whether its object is mirrored or not).
    pub corners: [Vec3; 3],
    /// Index in [`Scene::primitives`](crate::scene::Scene::primitives).
    pub primitive: u32,
    /// Index in the primitive's mesh.
    pub triangle: u32,
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
pub(super) fn world_corners(primitive: &Primitive, triangle: u32) -> [Vec3; 3] {
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
