//! Light of the sky where the method of indirect light brings none, and the sky's image in glossy surfaces.
//!
//! The sky's light is swept once through a coarse grid around the scene, past what blocks it, so that rooms stay dark
//! that the sky does not see. Surfaces reflect it once.

use crate::assets::REFLECTION_LEVELS;
use crate::gpu::{Binding, ComputeKey};
use crate::graph::{Graph, Handle, Texture, TextureDesc};
use crate::render::frame::Frame;
use crate::render::geometry::gbuffer::GBuffer;
use crate::render::indirect::gloss;
use crate::render::indirect::light_volumes::{self, Field};
use crate::render::indirect::{IndirectLight, IndirectMethod};
use crate::render::settings::RenderSettings;
use crate::scene::Scene;
use encase::ShaderType;
use glam::{UVec2, Vec3, Vec4};

/// Whether the sky must be swept for itself: the image shows indirect light, and the method has no light of the sky.
pub(in crate::render) fn is_needed(scene: &Scene, settings: &RenderSettings, method: &dyn IndirectMethod) -> bool {
    let is_lit = scene.sky_light && scene.sky != Vec3::ZERO;
    settings.only.shows_indirect() && is_lit && !method.has_sky_light(scene)
}

/// Whether surfaces show an image of the sky, beside its light.
pub(in crate::render) fn is_mirrored(scene: &Scene) -> bool {
    scene.sky_map.is_some() && gloss::is_wanted(scene)
}

/// Declares the light of the sky; none if the method has it, or there is none.
pub(in crate::render) fn declare<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    gbuffer: &GBuffer,
    method: &dyn IndirectMethod,
) -> Option<IndirectLight> {
    if !is_needed(frame.scene, frame.settings, method) {
        return None;
    }
    let swept = light_volumes::sweep::sky::declare(graph, frame, gbuffer);
    let radiance = gloss::declare(graph, frame, gbuffer, &swept, gloss::Names::SKY);
    Some(IndirectLight { radiance, field: Some(swept.field) })
}

/// `Reflection` of `sky/sky_light.wgsl`.
#[derive(ShaderType, Clone, Copy)]
pub(crate) struct ReflectionUniform {
    irradiance: [Vec4; 9],
    size: UVec2,
    levels: u32,
    mean: Vec3,
    turn: f32,
}

/// Declares what the sky's image adds to the sky's light in the lobes of glossy surfaces: radiance that may be negative.
/// `field` holds the light of the sky alone.
pub(in crate::render) fn reflection<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    gbuffer: &GBuffer,
    field: &Field,
) -> Option<Handle<Texture>> {
    let (map, reflections) = (frame.scene.sky_map.as_deref()?, frame.gpu_scene.sky_reflections()?);
    let Field::Swept { volume, .. } = field else { return None };
    let [width, height] = frame.view.size;
    let usage = wgpu::TextureUsages::STORAGE_BINDING | wgpu::TextureUsages::TEXTURE_BINDING;
    let desc = TextureDesc::d2(width, height, wgpu::TextureFormat::Rgba32Float, usage);
    let reflected = graph.retained_texture("sky reflection", desc);
    let mut pass = graph.pass("sky reflection");
    let inputs = [gbuffer.normal, gbuffer.object, gbuffer.depth];
    for input in inputs {
        pass.read(input);
    }
    field.buffers().iter().for_each(|&buffer| pass.read(buffer));
    let reflected = pass.write(reflected);
    pass.key(&(volume.key(), frame.view_key(), map.id));
    let uniform = ReflectionUniform {
        irradiance: reflections.irradiance,
        size: reflections.size.into(),
        levels: REFLECTION_LEVELS,
        mean: frame.scene.sky,
        turn: map.turn,
    };
    let (frame, field) = (frame.clone(), field.clone());
    pass.execute(move |cx| {
        let [normal, object, depth] = inputs.map(|handle| cx.view(handle));
        let target = cx.view(reflected);
        let volume = field.bindings(cx);
        let view = frame.view_uniform(cx.gpu);
        let uniform = cx.gpu.uniform("sky reflection", &uniform);
        cx.counts().texels += u64::from(width) * u64::from(height);
        let mut bindings = vec![
            ("view", Binding::Buffer(&view)),
            ("reflection", Binding::Buffer(&uniform)),
            ("normal", Binding::Texture(&normal)),
            ("object", Binding::Texture(&object)),
            ("depth", Binding::Texture(&depth)),
            ("levels", Binding::Texture(&reflections.levels)),
            ("reflected", Binding::Texture(&target)),
        ];
        bindings.extend(volume.iter().map(|(name, buffer)| (*name, Binding::Buffer(buffer))));
        let groups = [width.div_ceil(8), height.div_ceil(8), 1];
        cx.dispatch(&ComputeKey::new("sky/sky_light.wgsl", "main"), &bindings, groups)
    });
    Some(reflected)
}
