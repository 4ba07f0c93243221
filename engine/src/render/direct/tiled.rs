//! Direct light of many lights without shadows, in one pass by tiles of the image.

use super::DirectLight;
use crate::gpu::{Binding, ComputeKey};
use crate::graph::{Graph, Handle, Texture};
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
    let mut pass = graph.pass(gbuffer.surfaces.name("direct, lights without shadows"));
    let inputs = [gbuffer.base_color, gbuffer.normal, gbuffer.object, gbuffer.depth];
    for input in inputs {
        pass.read(input);
    }
    let radiance = pass.write(radiance);
    let revisions: Vec<u64> = direct_lights.iter().map(|direct_light| direct_light.light.revision).collect();
    pass.key(&(frame.media_key(), revisions, frame.view_key()));
    let (frame, surfaces) = (frame.clone(), gbuffer.surfaces);
    pass.execute(move |cx| {
        let view = frame.view_uniform(cx.gpu);
        let [base_color, normal, object, depth] = inputs.map(|handle| cx.view(handle));
        let target = cx.view(radiance);
        let [width, height] = frame.view.size;
        for some in direct_lights.chunks(MOST) {
            let lights: Vec<LightUniform> =
                some.iter().map(|direct_light| LightUniform::new(direct_light.light)).collect();
            let uniform = LightsUniform { count: lights.len() as u32, padding: UVec3::ZERO };
            let lights = cx.gpu.constants_of("lights without shadows", &lights);
            cx.counts().lights += u64::from(uniform.count);
            cx.counts().texels += u64::from(width) * u64::from(height);
            let some = cx.gpu.uniform("lights", &uniform);
            let media = frame.gpu_scene.media_binding(cx.gpu);
            let mut group = vec![
                ("view", Binding::Buffer(&view)),
                ("some", Binding::Buffer(&some)),
                ("lights", Binding::Buffer(&lights)),
                ("base_color", Binding::Texture(&base_color)),
                ("normal", Binding::Texture(&normal)),
                ("object", Binding::Texture(&object)),
                ("depth", Binding::Texture(&depth)),
                ("radiance", Binding::Texture(&target)),
            ];
            group.extend(media.iter().map(|(name, buffer)| (*name, Binding::Buffer(buffer))));
            let key = frame.gpu_scene.with_media(surfaces.define(ComputeKey::new("direct/tiled.wgsl", "main")));
            cx.dispatch(&key, &group, [width.div_ceil(8), height.div_ceil(8), 1])?;
        }
        Ok(())
    });
    radiance
}
