//! Triangles of a scene in world space, and the order of their corners.

use crate::bvh::Ray;
use crate::scene::Primitive;
use glam::{Affine3A, Mat3, Vec3, Vec3A};

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

/// Takes the corners of triangles of the primitive's mesh in world space. A mirroring transform turns their order around,
/// so that outside stays outside.
pub(super) fn place_corners(primitive: &Primitive, triangles: &mut [SceneTriangle]) {
    let transform = &primitive.world_from_object;
    let is_mirrored = is_mirrored(transform);
    for triangle in triangles {
        triangle.corners = corner_indices(primitive, triangle.triangle, is_mirrored)
            .map(|index| transform.transform_point3(primitive.mesh.vertices[index].position.into()));
    }
}

/// Whether a transform turns the inside out: its determinant is negative. Axes are scaled first, since the products of
/// very short or very long ones leave the range of floats.
#[doc(hidden)]
pub fn is_mirrored(transform: &Affine3A) -> bool {
    let scaled = |axis: Vec3A| axis / axis.abs().max_element();
    let m = transform.matrix3;
    scaled(m.x_axis).dot(scaled(m.y_axis).cross(scaled(m.z_axis))) < 0.0
}

/// Indices of a triangle's vertices in its mesh, in the order of [`SceneTriangle::corners`].
#[doc(hidden)]
pub fn corner_indices(primitive: &Primitive, triangle: u32, is_mirrored: bool) -> [usize; 3] {
    let first = 3 * triangle as usize;
    let corners = &primitive.mesh.indices[first..first + 3];
    let [a, b, c] = [0, 1, 2].map(|corner| corners[corner] as usize);
    if is_mirrored { [a, c, b] } else { [a, b, c] }
}

/// The same where it is not known whether the primitive is mirrored.
#[doc(hidden)]
pub fn vertex_indices(primitive: &Primitive, triangle: u32) -> [usize; 3] {
    corner_indices(primitive, triangle, is_mirrored(&primitive.world_from_object))
}

/// World normals from an object's normals, but for their length: the cofactor matrix, which singular transforms have too;
/// the sign of the determinant is taken out, so that mirrored objects keep their outside.
#[doc(hidden)]
pub fn normal_matrix(transform: &Affine3A) -> Mat3 {
    let m = transform.matrix3;
    let (x, y, z) = (Vec3::from(m.x_axis), Vec3::from(m.y_axis), Vec3::from(m.z_axis));
    let cofactors = Mat3::from_cols(y.cross(z), z.cross(x), x.cross(y));
    if is_mirrored(transform) { -cofactors } else { cofactors }
}

/// A world normal by the [`normal_matrix`]; zero stays zero.
#[doc(hidden)]
pub fn turned_normal(matrix: &Mat3, normal: Vec3) -> Vec3 {
    let turned = *matrix * normal;
    let largest = turned.abs().max_element();
    if !(largest > 0.0 && largest.is_finite()) {
        return Vec3::ZERO;
    }
    (turned / largest).normalize_or_zero()
}

/// World normal of an object's normal.
#[doc(hidden)]
pub fn world_normal(transform: &Affine3A, normal: Vec3) -> Vec3 {
    turned_normal(&normal_matrix(transform), normal)
}
