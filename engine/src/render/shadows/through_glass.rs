//! What glass takes of a light on its way to the surfaces in its reflective shadow map. See `shadows/through_glass.wgsl`.

use super::reflective::Rsm;
use crate::gpu::Binding;
use crate::graph::{Graph, Handle, PassContext, PassError, Texture, TextureDesc};
use crate::render::frame::Frame;
use crate::render::rays::{RayScene, dispatch_rays};
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
    if !frame.gpu_scene.has_glass() || frame.shadow_rays.is_none() || !rsm.light.casts_shadow {
        return rsm;
    }
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
    let mut pass = graph.pass(name);
    [rsm.base_color, rsm.specular, rsm.depth].into_iter().for_each(|input| pass.read(input));
    let (base_color, specular) = (pass.write(base_color), pass.write(specular));
    pass.key(&(frame.geometry_key(), frame.media_key(), rsm.light.revision));
    pass.key(&frame.shadow_rays.map(RayScene::has_area_lights));
    let work = Work { frame: frame.clone(), rsm: rsm.clone(), base_color, specular };
    pass.execute(move |cx| (0..work.rsm.views.len()).try_for_each(|layer| work.run(cx, layer)));
    Rsm { base_color, specular, ..rsm }
}

struct Work<'a> {
    frame: Frame<'a>,
    rsm: Rsm<'a>,
    base_color: Handle<Texture>,
    specular: Handle<Texture>,
}

impl Work<'_> {
    fn run(&self, cx: &mut PassContext, layer: usize) -> Result<(), PassError> {
        let scene =
            self.frame.shadow_rays.ok_or_else(|| PassError::message("the scene is not ready for rays".to_owned()))?;
        let (gpu, rsm) = (cx.gpu, &self.rsm);
        cx.counts().texels += rsm.layer_texels();
        let uniform = gpu.uniform("through glass", &ThroughGlassUniform { root: scene.root() });
        let light = LightUniform::buffer(gpu, rsm.light);
        let map = gpu.uniform("rsm", &rsm.layer_uniform(layer, 1.0));
        let textures = [
            ("base_color", rsm.base_color),
            ("specular", rsm.specular),
            ("depth", rsm.depth),
            ("lit_base_color", self.base_color),
            ("lit_specular", self.specular),
        ];
        let textures = textures.map(|(name, handle)| {
            let texture = cx.texture(handle);
            let layers = 0..texture.depth_or_array_layers();
            (name, gpu.view_of_layers(texture, wgpu::TextureViewDimension::D2Array, layers))
        });
        let mut group = vec![
            ("through_glass", Binding::Buffer(&uniform)),
            ("light", Binding::Buffer(&light)),
            ("rsm", Binding::Buffer(&map)),
        ];
        group.extend(textures.iter().map(|(name, view)| (*name, Binding::Texture(view))));
        let groups = rsm.size.div_ceil(8);
        dispatch_rays(cx, &scene.shader("shadows/through_glass.wgsl", "main"), &group, scene, [groups, groups, 1])
    }
}
