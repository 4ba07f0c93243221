//! The report's main lights, in place of the direct passes when its shading is asked for.

use crate::gpu::{Binding, ComputeKey};
use crate::graph::{Graph, Handle, Texture};
use crate::render::direct::{declare_clear, layered_view, no_shadow_map};
use crate::render::frame::Frame;
use crate::render::geometry::gbuffer::GBuffer;
use crate::render::scene_gpu::light_uniform::LightUniform;
use crate::render::shadows::shadow_map::{self, ShadowMap};
use crate::world::{InstantRadiosity, ShadowLookup};
use encase::ShaderType;
use glam::Vec3;

/// `MainLight` of `indirect/instant_radiosity/main_light.wgsl`.
#[derive(ShaderType)]
pub(crate) struct MainLightUniform {
    weight: f32,
    bias: f32,
    slope_bias: f32,
    samples: u32,
    offset: f32,
    in_space: u32,
    pad_a: u32,
    pad_b: u32,
}

/// Declares a pass a light. The result is radiance, red, green and blue as layers of r32float.
pub(in crate::render) fn declare<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    gbuffer: &GBuffer,
    settings: &'a InstantRadiosity,
) -> Handle<Texture> {
    let mut radiance = declare_clear(graph, frame);
    let [width, height] = frame.view.size;
    for light in &frame.scene.lights {
        let name = format!("main light {}", light.pass_name());
        if light.intensity == Vec3::ZERO {
            graph.skip(&name, "the light has no intensity");
            continue;
        }
        let shadow = shadow_map::declare(graph, frame, light);
        let mut pass = graph.pass(name);
        let inputs = [gbuffer.base_color, gbuffer.normal, gbuffer.object, gbuffer.depth];
        for input in inputs {
            pass.read(input);
        }
        if let Some(shadow) = &shadow {
            pass.read(shadow.map);
        }
        radiance = pass.write(radiance);
        pass.key(&(frame.scene.identity, light.revision, shadow.is_some(), frame.view_key(), format!("{settings:?}")));
        let (frame, target) = (frame.clone(), radiance);
        pass.execute(move |cx| {
            let gpu = cx.gpu;
            let map = shadow.as_ref().map_or_else(|| no_shadow_map(gpu), |s| layered_view(gpu, cx.texture(s.map)));
            let lookup = shadow.as_ref().map_or_else(ShadowMap::none_uniform, ShadowMap::uniform);
            let uniform = MainLightUniform {
                weight: 1.0 / settings.particles as f32,
                bias: settings.shadow_bias,
                slope_bias: settings.shadow_slope_bias,
                samples: settings.shadow_samples,
                offset: settings.shadow_offset,
                in_space: u32::from(settings.shadow_lookup == ShadowLookup::AsPublished),
                pad_a: 0,
                pad_b: 0,
            };
            let [base_color, normal, object, depth] = inputs.map(|handle| cx.view(handle));
            let target = cx.view(target);
            cx.counts().lights += 1;
            cx.dispatch(
                &ComputeKey::new("indirect/instant_radiosity/main_light.wgsl", "add_light"),
                &[
                    ("view", Binding::Buffer(&frame.view_uniform(gpu))),
                    ("light", Binding::Buffer(&LightUniform::buffer(gpu, light))),
                    ("shadow", Binding::Buffer(&gpu.uniform("shadow", &lookup))),
                    ("main_light", Binding::Buffer(&gpu.uniform("main light", &uniform))),
                    ("base_color", Binding::Texture(&base_color)),
                    ("normal", Binding::Texture(&normal)),
                    ("object", Binding::Texture(&object)),
                    ("depth", Binding::Texture(&depth)),
                    ("shadow_map", Binding::Texture(&map)),
                    ("radiance", Binding::Texture(&target)),
                ],
                [width.div_ceil(8), height.div_ceil(8), 1],
            )
        });
    }
    radiance
}
