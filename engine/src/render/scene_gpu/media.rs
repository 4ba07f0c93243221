//! Participating media in the layout of `lib/media.wgsl`.

use crate::gpu::{Gpu, ShaderDef, uniform_bytes};
use crate::graph::PassBindings;
use crate::scene::{MAX_MEDIA, MediumShape, Scene, SceneMedium};
use encase::ShaderType;
use glam::{Vec3, Vec4};

/// `Medium` of `lib/media.wgsl`.
#[derive(Clone, Copy, Debug, ShaderType)]
pub(crate) struct MediumUniform {
    local_rows: [Vec4; 3],
    up: Vec3,
    base: f32,
    albedo: Vec3,
    extinction: f32,
    falloff: f32,
    anisotropy: f32,
    shape: u32,
    padding: u32,
}

impl MediumUniform {
    fn new(medium: &SceneMedium) -> Self {
        let rows = glam::Mat4::from(medium.local_from_world).transpose();
        Self {
            local_rows: [rows.x_axis, rows.y_axis, rows.z_axis],
            up: medium.up,
            base: medium.up.dot(medium.base),
            albedo: medium.albedo,
            extinction: medium.extinction,
            falloff: medium.falloff,
            anisotropy: medium.anisotropy,
            shape: match medium.shape {
                MediumShape::Everywhere => 0,
                MediumShape::Box => 1,
                MediumShape::Sphere => 2,
            },
            padding: 0,
        }
    }

    fn none() -> Self {
        Self {
            local_rows: [Vec4::ZERO; 3],
            up: Vec3::Y,
            base: 0.0,
            albedo: Vec3::ZERO,
            extinction: 0.0,
            falloff: 0.0,
            anisotropy: 0.0,
            shape: 1,
            padding: 0,
        }
    }
}

/// The media of a scene as shaders read them; none where there are none, so that nothing is compiled or bound for them.
#[derive(Clone, Debug)]
pub(crate) struct GpuMedia {
    values: [MediumUniform; MAX_MEDIA],
    count: u32,
}

impl GpuMedia {
    /// Those of a scene.
    pub(crate) fn of(scene: &Scene) -> Option<Self> {
        let media = &scene.media[..scene.media.len().min(MAX_MEDIA)];
        (!media.is_empty()).then(|| Self {
            values: std::array::from_fn(|i| media.get(i).map_or_else(MediumUniform::none, MediumUniform::new)),
            count: media.len() as u32,
        })
    }

    /// The buffer `media`.
    pub(crate) fn buffer(&self, gpu: &Gpu) -> wgpu::Buffer {
        gpu.uniform("media", &self.values)
    }

    /// Their values as shaders read them.
    pub(crate) fn bytes(&self) -> Vec<u8> {
        uniform_bytes("media", &self.values)
    }

    /// Binds it to a pass, whose shader then knows of media.
    pub(crate) fn bind(&self, pass: &mut PassBindings) {
        let (name, count) = self.define();
        pass.define(name, count);
        pass.uniform("media", &self.values);
    }

    /// The definition with which shaders know them.
    pub(crate) fn define(&self) -> (&'static str, ShaderDef) {
        ("MEDIA", ShaderDef::Uint(self.count))
    }
}
