//! Projections of a view.

use glam::{Mat4, Vec4};
use std::ops::RangeInclusive;

/// Near plane of a camera that names none \[m\].
pub const DEFAULT_NEAR: f32 = 0.05;

/// Heights that an orthographic view may have \[m\].
pub const ORTHOGRAPHIC_HEIGHTS: RangeInclusive<f32> = 1e-6..=1e9;

/// How a view projects, with the parameters that only it has.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ViewProjection {
    /// All lines of sight meet in the eye.
    Perspective {
        /// Vertical field of view \[rad\].
        vertical_fov: f32,
    },
    /// All lines of sight are parallel.
    Orthographic {
        /// Height of what is seen \[m\].
        height: f32,
    },
}

/// Right-handed perspective projection with reversed depth: z = 1 at `near`, 0 at `far` or at infinity.
pub fn perspective(vertical_fov: f32, aspect: f32, near: f32, far: Option<f32>) -> Mat4 {
    let focal = 1.0 / (0.5 * vertical_fov).tan();
    let (a, b) = match far {
        // z_clip = a·z_view + b with z_clip/w = 1 at −near and 0 at −far, w = −z_view.
        Some(far) => (near / (far - near), near * far / (far - near)),
        None => (0.0, near),
    };
    Mat4::from_cols(
        Vec4::new(focal / aspect, 0.0, 0.0, 0.0),
        Vec4::new(0.0, focal, 0.0, 0.0),
        Vec4::new(0.0, 0.0, a, -1.0),
        Vec4::new(0.0, 0.0, b, 0.0),
    )
}

/// Right-handed orthographic projection with reversed depth: z = 1 at `near`, 0 at `far`, linear between; w = 1.
pub fn orthographic(height: f32, aspect: f32, near: f32, far: f32) -> Mat4 {
    let scale = 2.0 / height;
    let depth = (far - near).recip();
    Mat4::from_cols(
        Vec4::new(scale / aspect, 0.0, 0.0, 0.0),
        Vec4::new(0.0, scale, 0.0, 0.0),
        Vec4::new(0.0, 0.0, depth, 0.0),
        Vec4::new(0.0, 0.0, far * depth, 1.0),
    )
}
