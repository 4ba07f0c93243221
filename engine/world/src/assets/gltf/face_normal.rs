//! Normals of flat triangles.

use glam::Vec3;

/// Unit normal of a triangle; zero if it has no area. The largest component of the edges is scaled to 1 first, so that
/// neither tiny nor huge triangles leave the range of floats.
pub(super) fn face_normal(corners: [[f32; 3]; 3]) -> Vec3 {
    let [a, b, c] = corners.map(Vec3::from);
    let (u, v) = (b - a, c - a);
    let largest = u.abs().max(v.abs()).max_element();
    if !(largest > 0.0 && largest.is_finite()) {
        return Vec3::ZERO;
    }
    (u / largest).cross(v / largest).normalize_or_zero()
}
