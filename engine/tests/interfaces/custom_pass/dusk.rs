//! Dusk: where there is little light, colours fade into blue, as they do for the eye.

use lightwell::gpu::ComputeKey;
use lightwell::graph::{Graph, Handle, Texture, TextureDesc};
use lightwell::render::Picture;
use wgpu::{TextureFormat, TextureUsages};

/// Declares the pass; the result is the image's radiance at dusk.
pub fn declare(graph: &mut Graph, picture: &Picture) -> Handle<Texture> {
    let ([width, height], radiance) = (picture.size, picture.radiance);
    let usage = TextureUsages::STORAGE_BINDING | TextureUsages::TEXTURE_BINDING;
    let desc = TextureDesc::d2(width, height, TextureFormat::Rgba32Float, usage);
    let dusk = graph.retained_texture("dusk", desc);
    let mut pass = graph.compute("dusk", ComputeKey::new("dusk.wgsl", "main"));
    pass.read("radiance", radiance);
    let dusk = pass.write("dusk", dusk);
    pass.dispatch_over(picture.size);
    dusk
}
