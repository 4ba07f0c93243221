//! What glass takes of a light on its way to the surfaces in its reflective shadow map. See `shadows/through_glass.wgsl`.

use super::reflective::Rsm;
use crate::gpu::ComputeKey;
use crate::graph::{Graph, TextureDesc};
use crate::render::frame::Frame;
use crate::render::scene_gpu::light_uniform::LightUniform;
use encase::ShaderType;
use wgpu::TextureFormat;

/// `ThroughGlass` of `shadows/through_glass.wgsl`.
#[derive(ShaderType)]
pub(crate) struct ThroughGlassUniform {
    root: u32,
}

/// Declares the pass where there is glass; the map with the colours that its light finds.
pub(super) fn declare<'a>(graph: &mut Graph<'a>, frame: &Frame<'a>, rsm: Rsm<'a>) -> Rsm<'a> {
    let may_be_lit_through = frame.gpu_scene.has_glass() && rsm.light.casts_shadow;
    let Some(rays) = frame.shadow_rays.filter(|_| may_be_lit_through) else { return rsm };
    let name = format!("rsm through glass {}", rsm.light.pass_name());
    let usage = wgpu::TextureUsages::STORAGE_BINDING | wgpu::TextureUsages::TEXTURE_BINDING;
    let layers = rsm.views.len() as u32;
    let mut target = |part: &str, format| {
        graph.retained_texture(
            format!("{name} {part}"),
            TextureDesc::d2_array(rsm.size, rsm.size, layers, format, usage),
        )
    };
    let base_color = target("base color", TextureFormat::Rgba16Uint);
    let specular = target("specular", TextureFormat::R32Uint);
    let mut pass = graph.compute(name, ComputeKey::new("shadows/through_glass.wgsl", "main"));
    rays.bind_surfaces(&mut pass);
    pass.uniform("through_glass", &ThroughGlassUniform { root: rays.root() });
    pass.uniform("light", &LightUniform::new(rsm.light));
    pass.read_layers("base_color", rsm.base_color);
    pass.read_layers("specular", rsm.specular);
    pass.read_layers("depth", rsm.depth);
    let base_color = pass.write_layers("lit_base_color", base_color);
    let specular = pass.write_layers("lit_specular", specular);
    for layer in 0..rsm.views.len() {
        let mut step = pass.step("main");
        step.uniform("rsm", &rsm.layer_uniform(layer, 1.0));
        step.over([rsm.size; 2]);
    }
    pass.finish();
    Rsm { base_color, specular, ..rsm }
}
