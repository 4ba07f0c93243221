//! Dusk: where there is little light, colours fade into blue, as they do for the eye.

use lightwell::gpu::{Binding, ComputeKey};
use lightwell::graph::{Graph, Handle, Texture, TextureDesc};
use lightwell::render::Picture;
use wgpu::{TextureFormat, TextureUsages};

/// Declares the pass; the result is the image's radiance at dusk.
pub fn declare(graph: &mut Graph, picture: &Picture) -> Handle<Texture> {
    let ([width, height], radiance) = (picture.size, picture.radiance);
    let usage = TextureUsages::STORAGE_BINDING | TextureUsages::TEXTURE_BINDING;
    let desc = TextureDesc::d2(width, height, TextureFormat::Rgba32Float, usage);
    let dusk = graph.retained_texture("dusk", desc);
    let mut pass = graph.pass("dusk");
    pass.read(radiance);
    let dusk = pass.write(dusk);
    // What the result depends on besides what is read: here nothing.
    pass.key(&());
    pass.execute(move |cx| {
        let (source, target) = (cx.view(radiance), cx.view(dusk));
        cx.counts().texels += u64::from(width) * u64::from(height);
        cx.dispatch(
            &ComputeKey::new("dusk.wgsl", "main"),
            &[("radiance", Binding::Texture(&source)), ("dusk", Binding::Texture(&target))],
            [width.div_ceil(8), height.div_ceil(8), 1],
        )
    });
    dusk
}
