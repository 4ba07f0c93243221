//! Two images in one: a wipe from one to the other, or their difference.

use crate::gpu::ComputeKey;
use crate::graph::{Graph, Handle, Texture, TextureDesc};
use crate::render::settings::Shown;
use encase::ShaderType;

/// `Compare` of `post/compare.wgsl`.
#[derive(ShaderType)]
pub(crate) struct CompareUniform {
    mode: u32,
    value: f32,
}

/// Declares the pass; the result is what is to be shown of the two images of radiance.
pub(in crate::render) fn declare(
    graph: &mut Graph,
    drawn: Handle<Texture>,
    traced: Handle<Texture>,
    shown: Shown,
) -> Handle<Texture> {
    let [width, height] = graph.texture_desc(drawn).map_or([1, 1], |desc| [desc.size[0], desc.size[1]]);
    let usage = wgpu::TextureUsages::STORAGE_BINDING | wgpu::TextureUsages::TEXTURE_BINDING;
    let desc = TextureDesc::d2(width, height, wgpu::TextureFormat::Rgba32Float, usage);
    let both = graph.texture("drawn and traced", desc);
    // The constants of `post/compare.wgsl`.
    let (mode, value) = match shown {
        Shown::Wipe(share) => (0, if share.is_finite() { share.clamp(0.0, 1.0) } else { 0.5 }),
        Shown::Difference(full) => (1, if full > 0.0 && full.is_finite() { full } else { 1.0 }),
    };
    let mut pass = graph.compute("compare", ComputeKey::new("post/compare.wgsl", "main"));
    pass.uniform("compare", &CompareUniform { mode, value });
    pass.read("drawn", drawn);
    pass.read("traced", traced);
    let both = pass.write("both", both);
    pass.dispatch_over([width, height]);
    both
}
