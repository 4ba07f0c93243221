//! Where the scene's origin lies.

use crate::world::{Camera, GlobalTransform, Identity, Projection};
use bevy_ecs::prelude::*;
use glam::DVec3;

/// Distance from the origin, in near planes of the camera, up to which single precision does: its numbers are then no
/// farther apart than 2⁻¹⁰ of the near plane.
const REACH: f64 = 16384.0;

/// The camera that the origin goes by.
pub(super) struct Anchor {
    cameras: QueryState<(&'static Identity, &'static GlobalTransform, &'static Camera)>,
}

impl Anchor {
    pub fn new(world: &mut World) -> Self {
        Self { cameras: world.query() }
    }

    /// The multiple of [`REACH`] that lies nearest to the primary camera, zero where there is none. It depends on where
    /// the camera is and not on where it was, so that a frame does not depend on how it was reached.
    pub fn origin(&mut self, world: &World) -> DVec3 {
        let cameras = self.cameras.iter(world);
        let chosen = cameras.min_by_key(|(identity, _, camera)| (!camera.primary, **identity));
        chosen.map_or(DVec3::ZERO, |(_, place, camera)| nearest(place.translation(), f64::from(least(camera))))
    }
}

/// The least length that the camera shows \[m\].
fn least(camera: &Camera) -> f32 {
    match camera.projection {
        Projection::Perspective => camera.near,
        // Corresponds to the step of a perspective with the default near plane at its usual distance.
        Projection::Orthographic { height } => 0.05 * height,
    }
}

fn nearest(place: DVec3, near: f64) -> DVec3 {
    // By a power of two, so that the origin has few digits.
    let reach = (REACH * near).log2().floor().exp2();
    let origin = (place / reach).round() * reach;
    if reach.is_normal() && origin.is_finite() { origin + 0.0 } else { DVec3::ZERO }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_origin_is_near_the_camera_and_zero_where_that_does() {
        assert_eq!(nearest(DVec3::new(-300.0, 2.0, 400.0), 0.1), DVec3::ZERO);
        let far = DVec3::new(1e5, -3.0, -7e4);
        let origin = nearest(far, 0.1);
        assert!((far - origin).abs().max_element() <= 512.0 && origin.y == 0.0, "{origin}");
        for near in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert_eq!(nearest(far, near), DVec3::ZERO);
        }
    }
}
