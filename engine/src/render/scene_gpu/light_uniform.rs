//! Lights in the layout of `lib/lights.wgsl`.

use crate::scene::{LightShape, SceneLight};
use encase::ShaderType;
use glam::{Vec2, Vec3};

/// `Light` of `lib/lights.wgsl`.
#[derive(ShaderType, Clone, Copy)]
pub(crate) struct LightUniform {
    position: Vec3,
    shape: u32,
    direction: Vec3,
    range: f32,
    intensity: Vec3,
    cone_scale: f32,
    axis: Vec3,
    cone_offset: f32,
    size: Vec2,
}

impl LightUniform {
    /// The light's values.
    pub(crate) fn new(light: &SceneLight) -> Self {
        let (cone_scale, cone_offset) = match light.shape {
            LightShape::Spot { inner, outer } => {
                // KHR_lights_punctual, "Inner and outer cone angles".
                let scale = 1.0 / (inner.cos() - outer.cos()).max(1e-6);
                (scale, -outer.cos() * scale)
            }
            _ => (0.0, 0.0),
        };
        let (shape, size) = match light.shape {
            LightShape::Directional => (0, Vec2::ZERO),
            LightShape::Point => (1, Vec2::ZERO),
            LightShape::Spot { .. } => (2, Vec2::ZERO),
            LightShape::Sun { half_angle } => (3, Vec2::new(half_angle.sin(), half_angle.cos())),
            LightShape::Sphere { radius } => (4, Vec2::new(radius, 0.0)),
            LightShape::Disc { radius } => (5, Vec2::new(radius, 0.0)),
            LightShape::Rectangle { half_size } => (6, half_size),
            LightShape::Tube { half_length, radius } => (7, Vec2::new(half_length, radius)),
        };
        Self {
            position: light.position,
            shape,
            direction: light.direction,
            range: light.range.unwrap_or(0.0),
            intensity: light.intensity,
            cone_scale,
            axis: light.axis,
            cone_offset,
            size,
        }
    }

    /// The light with intensity 1: for passes that ask where it is and not how bright, and keep their results while it flickers.
    pub(crate) fn of_unit_intensity(light: &SceneLight) -> Self {
        Self { intensity: Vec3::ONE, ..Self::new(light) }
    }

    /// No light at all.
    pub(crate) fn none() -> Self {
        Self {
            position: Vec3::ZERO,
            shape: 0,
            direction: Vec3::NEG_Y,
            range: 0.0,
            intensity: Vec3::ZERO,
            cone_scale: 0.0,
            axis: Vec3::X,
            cone_offset: 0.0,
            size: Vec2::ZERO,
        }
    }
}
