//! Lights in the layout of `lib/lights.wgsl`.

use crate::gpu::Gpu;
use crate::scene::{LightShape, SceneLight};
use encase::ShaderType;
use glam::Vec3;

/// `Light` of `lib/lights.wgsl`.
#[derive(ShaderType)]
pub(crate) struct LightUniform {
    position: Vec3,
    shape: u32,
    direction: Vec3,
    range: f32,
    intensity: Vec3,
    cone_scale: f32,
    cone_offset: f32,
}

impl LightUniform {
    /// The light's values.
    pub(crate) fn new(light: &SceneLight) -> Self {
        let (shape, cone_scale, cone_offset) = match light.shape {
            LightShape::Directional => (0, 0.0, 0.0),
            LightShape::Point => (1, 0.0, 0.0),
            LightShape::Spot { inner, outer } => {
                // KHR_lights_punctual, "Inner and outer cone angles".
                let scale = 1.0 / (inner.cos() - outer.cos()).max(1e-6);
                (2, scale, -outer.cos() * scale)
            }
        };
        Self {
            position: light.position,
            shape,
            direction: light.direction,
            range: light.range.unwrap_or(0.0),
            intensity: light.intensity,
            cone_scale,
            cone_offset,
        }
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
            cone_offset: 0.0,
        }
    }

    /// A buffer with the light's values.
    pub(crate) fn buffer(gpu: &Gpu, light: &SceneLight) -> wgpu::Buffer {
        gpu.uniform(&light.name, &Self::new(light))
    }
}
