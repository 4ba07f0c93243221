//! The views that a light sees the scene by: one for spot and directional lights, six for point lights and for spots whose cone
//! nears a half space. Lights with a surface see from their middle.
//!
//! Shadow maps and reflective shadow maps are drawn through the same views.

use crate::scene::{Aabb, LightShape, SceneLight, perspective};
use glam::{Mat3, Mat4, Vec3, Vec4};

/// One view of a light. Depth is reversed: 1 at `near`, 0 at `far`.
#[derive(Clone, Debug, PartialEq)]
pub struct LightView {
    /// Clip from world space.
    pub clip_from_world: Mat4,
    /// World from clip space.
    pub world_from_clip: Mat4,
    /// Where the light stands \[m\]; for directional lights the centre of the near plane.
    pub eye: Vec3,
    /// Unit direction of the view's axis.
    pub direction: Vec3,
    /// Distance of the near plane along the axis \[m\].
    pub near: f32,
    /// Distance of the far plane along the axis \[m\]: nothing to be seen lies beyond.
    pub far: f32,
    /// Cube face 0..5 in the order +X −X +Y −Y +Z −Z, 0 for the others.
    pub face: u32,
    /// Half width of the view: tangent of the half angle, or metres for directional lights.
    pub half_extent: f32,
}

impl LightView {
    /// Whether the image is a mirror image, as the faces of a cube are.
    pub fn is_mirrored(&self) -> bool {
        self.clip_from_world.determinant() < 0.0
    }
}

/// Cube faces: viewing direction and up vector, as cube texture sampling expects them.
const CUBE_FACES: [(Vec3, Vec3); 6] = [
    (Vec3::X, Vec3::Y),
    (Vec3::NEG_X, Vec3::Y),
    (Vec3::Y, Vec3::NEG_Z),
    (Vec3::NEG_Y, Vec3::Z),
    (Vec3::Z, Vec3::Y),
    (Vec3::NEG_Z, Vec3::Y),
];

/// Half angle \[rad\] above which a spot sees by the faces of a cube: a single image spreads its texels by the square of the
/// tangent, which is 4.6 there and has no bound towards a half space.
const WIDE: f32 = 65.0 * std::f32::consts::PI / 180.0;

/// Whether the light sees by the faces of a cube.
pub(super) fn sees_by_cube(shape: &LightShape) -> bool {
    match shape {
        LightShape::Directional | LightShape::Sun { .. } => false,
        LightShape::Spot { outer, .. } => *outer > WIDE,
        _ => true,
    }
}

/// Distances of a view's clip planes along its axis [m].
#[derive(Clone, Copy)]
struct Depth {
    near: f32,
    far: f32,
}

/// The views that cover all that a light can reach within `bounds`, tightly. Empty bounds give no view.
pub fn light_views(light: &SceneLight, bounds: &Aabb) -> Vec<LightView> {
    if bounds.is_empty() {
        return Vec::new();
    }
    match light.shape {
        LightShape::Directional | LightShape::Sun { .. } => {
            directional_view(light.direction, bounds).into_iter().collect()
        }
        LightShape::Spot { outer, .. } if !sees_by_cube(&light.shape) => {
            let Some(depth) = depth_range(light, bounds) else { return Vec::new() };
            let up = any_perpendicular(light.direction);
            let view_from_world = view_matrix(light.position, light.direction, up);
            vec![perspective_view(light.position, light.direction, view_from_world, outer.tan(), depth, 0)]
        }
        _ => {
            let Some(depth) = depth_range(light, bounds) else { return Vec::new() };
            let mut faces = Vec::with_capacity(6);
            for (&(direction, up), face) in CUBE_FACES.iter().zip(0..) {
                let view_from_world = view_matrix(light.position, direction, up);
                let mirrored = Mat4::from_scale(Vec3::new(-1.0, 1.0, 1.0)) * view_from_world;
                faces.push(perspective_view(light.position, direction, mirrored, 1.0, depth, face));
            }
            faces
        }
    }
}

/// Nearest and farthest distance that the light has to see, rounded so that a small move of one object does not change the
/// view. Depth is reversed floating point, so that a near plane far closer than anything visible costs no precision.
fn depth_range(light: &SceneLight, bounds: &Aabb) -> Option<Depth> {
    let farthest = bounds.corners().iter().map(|c| c.distance(light.position)).fold(0.0, f32::max);
    let reach = light.range.map_or(farthest, |range| farthest.min(range)) * 1.001;
    if !(reach.is_finite() && reach > 1e-30) {
        return None;
    }
    let far = quantised_size(reach);
    // Along the axis of a view a point may be nearer than its distance, by the cosine to the view's corner.
    let nearest = bounds.distance(light.position) / 3.0_f32.sqrt();
    let near = nearest.log2().floor().exp2().clamp(far * 1e-4, far * 0.5);
    (far.is_finite() && near < far).then_some(Depth { near, far })
}

fn perspective_view(
    eye: Vec3,
    direction: Vec3,
    view_from_world: Mat4,
    half_extent: f32,
    Depth { near, far }: Depth,
    face: u32,
) -> LightView {
    let clip_from_view = perspective(2.0 * half_extent.atan(), 1.0, near, Some(far));
    LightView {
        clip_from_world: clip_from_view * view_from_world,
        // Inverted by parts: each is well conditioned by itself.
        world_from_clip: view_from_world.inverse() * clip_from_view.inverse(),
        eye,
        direction,
        near,
        far,
        face,
        half_extent,
    }
}

/// Orthographic view along `direction` that just holds the bounds. It is a square whose size is rounded up to
/// the next eighth of a power of two and whose place is rounded to a 64th of it, so that a small move of one
/// object neither changes the view nor makes shadows crawl.
fn directional_view(direction: Vec3, bounds: &Aabb) -> Option<LightView> {
    let light_from_world = view_matrix(Vec3::ZERO, direction, any_perpendicular(direction));
    let in_light = Aabb::from_points(bounds.corners().iter().map(|c| light_from_world.transform_point3(*c)));
    let size = in_light.size();
    let margin = 1.0 + 2.0 / 64.0;
    let edge = quantised_size(size.x.max(size.y).max(size.z * 1e-3) * margin);
    let depth = quantised_size(size.z.max(size.x.max(size.y) * 1e-3) * margin);
    if !(edge.is_finite() && depth.is_finite() && edge > 0.0) {
        return None;
    }
    let snap = |value: f32, unit: f32| (value / unit).round() * unit;
    let center = in_light.center();
    let center = Vec3::new(snap(center.x, edge / 64.0), snap(center.y, edge / 64.0), snap(center.z, depth / 64.0));
    let half = 0.5 * edge;
    let (front, back) = (center.z + 0.5 * depth, center.z - 0.5 * depth);
    // z_clip: 1 at the front (towards the light), 0 at the back.
    let clip_from_light = Mat4::from_cols(
        Vec4::new(1.0 / half, 0.0, 0.0, 0.0),
        Vec4::new(0.0, 1.0 / half, 0.0, 0.0),
        Vec4::new(0.0, 0.0, 1.0 / depth, 0.0),
        Vec4::new(-center.x / half, -center.y / half, -back / depth, 1.0),
    );
    let world_from_light = light_from_world.inverse();
    Some(LightView {
        clip_from_world: clip_from_light * light_from_world,
        world_from_clip: world_from_light * clip_from_light.inverse(),
        eye: world_from_light.transform_point3(Vec3::new(center.x, center.y, front)),
        direction,
        near: 0.0,
        far: depth,
        face: 0,
        half_extent: half,
    })
}

/// The next length at or above `length` of the form (1 + k/8)·2ⁿ.
fn quantised_size(length: f32) -> f32 {
    let power = length.log2().floor().exp2();
    (length / power * 8.0).ceil() / 8.0 * power
}

/// View from world for an eye that looks along `direction` (unit) with −Z.
fn view_matrix(eye: Vec3, direction: Vec3, up: Vec3) -> Mat4 {
    let right = direction.cross(up).normalize();
    let rotation = Mat3::from_cols(right, right.cross(direction), -direction).transpose();
    Mat4::from_mat3(rotation) * Mat4::from_translation(-eye)
}

/// A unit vector at right angles to `direction`: +Y made perpendicular, or +Z for nearly vertical directions.
fn any_perpendicular(direction: Vec3) -> Vec3 {
    let up = if direction.y.abs() < 0.99 { Vec3::Y } else { Vec3::Z };
    (up - direction * up.dot(direction)).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::SceneId;

    fn light(shape: LightShape) -> SceneLight {
        SceneLight {
            id: SceneId(1),
            name: "light".into(),
            shape,
            intensity: Vec3::ONE,
            position: Vec3::new(0.2, 0.5, -0.3),
            direction: Vec3::new(0.3, -1.0, 0.2).normalize(),
            axis: Vec3::X,
            range: None,
            casts_shadow: true,
            indirect: true,
            shadow_size: 64,
            rsm_size: 64,
            revision: 0,
        }
    }

    const BOUNDS: Aabb = Aabb { min: Vec3::new(-2.0, -1.0, -3.0), max: Vec3::new(2.0, 3.0, 1.0) };

    #[test]
    fn every_corner_of_the_bounds_is_in_some_view_and_comes_back() {
        for shape in [LightShape::Directional, LightShape::Point] {
            let views = light_views(&light(shape), &BOUNDS);
            for corner in BOUNDS.corners() {
                let inside = views.iter().filter(|view| {
                    let ndc = view.clip_from_world.project_point3(corner);
                    let clip_w = (view.clip_from_world * corner.extend(1.0)).w;
                    let back = view.world_from_clip.project_point3(ndc);
                    assert!(back.distance(corner) < 1e-3, "{shape:?}: {corner} came back as {back}");
                    clip_w > 0.0 && ndc.truncate().abs().max_element() <= 1.0001 && (0.0..=1.0).contains(&ndc.z)
                });
                assert!(inside.count() >= 1, "{shape:?}: corner {corner} is in no view");
            }
        }
    }

    #[test]
    fn wide_spots_see_as_points_do() {
        for degrees in [66.0_f32, 80.0, 90.0] {
            let spot = light(LightShape::Spot { inner: 0.0, outer: degrees.to_radians() });
            assert_eq!(light_views(&spot, &BOUNDS), light_views(&light(LightShape::Point), &BOUNDS), "{degrees}°");
        }
        let narrow = light(LightShape::Spot { inner: 0.0, outer: 1.0 });
        assert_eq!(light_views(&narrow, &BOUNDS).len(), 1);
    }

    #[test]
    fn cube_faces_match_cube_sampling() {
        // Cube sampling maps +X to s = −z, t = −y (t downwards): a point up and to −z shows up right and above.
        let views = light_views(&SceneLight { position: Vec3::ZERO, ..light(LightShape::Point) }, &BOUNDS);
        let ndc = views[0].clip_from_world.project_point3(Vec3::new(1.0, 0.5, -0.25));
        assert!((ndc.x - 0.25).abs() < 1e-5 && (ndc.y - 0.5).abs() < 1e-5, "{ndc}");
        assert!(views.iter().all(LightView::is_mirrored));
        assert!(!light_views(&light(LightShape::Directional), &BOUNDS)[0].is_mirrored());
        assert!(!light_views(&light(LightShape::Spot { inner: 0.5, outer: 0.6 }), &BOUNDS)[0].is_mirrored());
        // +Y: s = x, t = z.
        let ndc = views[2].clip_from_world.project_point3(Vec3::new(0.25, 1.0, 0.5));
        assert!((ndc.x - 0.25).abs() < 1e-5 && (ndc.y + 0.5).abs() < 1e-5, "{ndc}");
    }

    #[test]
    fn a_small_move_of_the_bounds_leaves_the_views_as_they_were() {
        let moved = Aabb { max: BOUNDS.max + Vec3::splat(1e-3), ..BOUNDS };
        for shape in [LightShape::Directional, LightShape::Point, LightShape::Spot { inner: 0.5, outer: 0.6 }] {
            for place in [Vec3::ZERO, Vec3::new(9.0, 1.0, 0.0)] {
                let light = SceneLight { position: place, ..light(shape) };
                assert_eq!(light_views(&light, &BOUNDS), light_views(&light, &moved), "{shape:?} {place}");
            }
        }
    }
}
