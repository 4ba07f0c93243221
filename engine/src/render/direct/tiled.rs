//! Direct light of many lights without shadows, in one pass by tiles of the image.

use super::DirectLight;
use crate::gpu::ComputeKey;
use crate::graph::{Counts, Graph, Handle, Texture};
use crate::render::frame::Frame;
use crate::render::geometry::gbuffer::GBuffer;
use crate::render::scene_gpu::light_uniform::LightUniform;
use encase::ShaderType;
use glam::UVec3;

/// Lights of a dispatch: tests and sums of a pixel stay below the 65,535 turns after which a software driver ends all
/// loops of an invocation.
const MOST: usize = 32_768;

/// `Lights` of `direct/tiled.wgsl`.
#[derive(ShaderType, Clone, Copy)]
pub(crate) struct LightsUniform {
    count: u32,
    padding: UVec3,
}

/// Declares the pass, which adds to the radiance.
pub(in crate::render) fn declare<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    gbuffer: &GBuffer,
    radiance: Handle<Texture>,
    direct_lights: Vec<DirectLight<'a>>,
) -> Handle<Texture> {
    let name = gbuffer.surfaces.name("direct, lights without shadows");
    let mut pass = graph.compute(name, ComputeKey::new("direct/tiled.wgsl", "main"));
    gbuffer.surfaces.define_for(&mut pass);
    frame.gpu_scene.bind_media(&mut pass);
    frame.bind_view(&mut pass);
    gbuffer.bind(&mut pass);
    let radiance = pass.write("radiance", radiance);
    pass.count(Counts { lights: direct_lights.len() as u64, ..Counts::default() });
    for some in direct_lights.chunks(MOST) {
        let lights: Vec<_> = some.iter().map(|direct_light| LightUniform::new(direct_light.light)).collect();
        let mut step = pass.step("main");
        step.uniform("some", &LightsUniform { count: lights.len() as u32, padding: UVec3::ZERO });
        step.constants("lights", &lights);
        step.over(frame.view.size);
    }
    pass.finish();
    radiance
}
