//! The report's main lights, in place of the direct passes when its shading is asked for.

use crate::gpu::ComputeKey;
use crate::graph::{Counts, Graph, Handle, Texture};
use crate::render::direct::{declare_clear, no_shadow_map};
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
    settings: &InstantRadiosity,
) -> Handle<Texture> {
    let mut radiance = declare_clear(graph, frame);
    for light in &frame.scene.lights {
        let name = format!("main light {}", light.pass_name());
        if light.intensity == Vec3::ZERO {
            graph.skip(&name, "the light has no intensity");
            continue;
        }
        let shadow = shadow_map::declare(graph, frame, light);
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
        let shader = ComputeKey::new("indirect/instant_radiosity/main_light.wgsl", "add_light");
        let mut pass = graph.compute(name, shader);
        frame.bind_view(&mut pass);
        pass.uniform("light", &LightUniform::new(light));
        pass.uniform("shadow", &shadow.as_ref().map_or_else(ShadowMap::none_uniform, ShadowMap::uniform));
        pass.uniform("main_light", &uniform);
        gbuffer.bind(&mut pass);
        match &shadow {
            Some(shadow) => pass.read_layers("shadow_map", shadow.map),
            None => pass.stand_in("shadow_map", no_shadow_map),
        }
        radiance = pass.write("radiance", radiance);
        pass.count(Counts { lights: 1, ..Counts::default() });
        pass.step("add_light").over_uncounted(frame.view.size);
        pass.finish();
    }
    radiance
}
