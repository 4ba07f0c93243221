//! Glossy reflection of the swept light, at the visible surfaces.

use super::frame::Frame;
use super::gbuffer::GBuffer;
use super::lpv::Field;
use crate::gpu::{Binding, ComputeKey};
use crate::graph::{Graph, Handle, Texture, TextureDesc};

/// Declares the pass; the result is `diffuse` with what glossy surfaces reflect, and without what that takes from it.
/// Propagated light keeps what it had: the thesis marches for gloss.
pub(super) fn declare<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    gbuffer: &GBuffer,
    field: &Field,
    diffuse: Handle<Texture>,
) -> Handle<Texture> {
    let Field::Swept { volume, .. } = field else {
        graph.skip("gloss", "propagated light is reflected diffusely alone");
        return diffuse;
    };
    if !frame.scene.primitives.iter().any(|p| p.material.specular != 0.0 || p.material.metallic != 0.0) {
        graph.skip("gloss", "no surface of the scene is glossy");
        return diffuse;
    }
    let [width, height] = frame.view.size;
    let usage = wgpu::TextureUsages::STORAGE_BINDING | wgpu::TextureUsages::TEXTURE_BINDING;
    let desc = TextureDesc::d2(width, height, wgpu::TextureFormat::Rgba32Float, usage);
    let indirect = graph.retained_texture("glossy radiance", desc);
    let mut pass = graph.pass("gloss");
    let inputs = [gbuffer.base_color, gbuffer.normal, gbuffer.object, gbuffer.depth, diffuse];
    for input in inputs {
        pass.read(input);
    }
    field.buffers().iter().for_each(|&buffer| pass.read(buffer));
    let indirect = pass.write(indirect);
    pass.key(&(volume.key(), frame.view_key()));
    let (frame, field) = (frame.clone(), field.clone());
    pass.execute(move |cx| {
        let views = inputs.map(|handle| cx.view(handle));
        let target = cx.view(indirect);
        let volume = field.bindings(cx);
        let view = frame.view_uniform(cx.gpu);
        cx.counts().texels += u64::from(width) * u64::from(height);
        let mut bindings = vec![("view", Binding::Buffer(&view)), ("indirect", Binding::Texture(&target))];
        let names = ["base_color", "normal", "object", "depth", "diffuse"];
        bindings.extend(names.into_iter().zip(&views).map(|(name, view)| (name, Binding::Texture(view))));
        bindings.extend(volume.iter().map(|(name, buffer)| (*name, Binding::Buffer(buffer))));
        cx.dispatch(&ComputeKey::new("gloss.wgsl", "main"), &bindings, [width.div_ceil(8), height.div_ceil(8), 1])
    });
    indirect
}
