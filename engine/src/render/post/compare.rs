//! Two images in one: a wipe from one to the other, or their difference.

use crate::gpu::{Binding, ComputeKey};
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
    let mut pass = graph.pass("compare");
    pass.read(drawn);
    pass.read(traced);
    let both = pass.write(both);
    // The constants of `post/compare.wgsl`.
    let (mode, value) = match shown {
        Shown::Wipe(share) => (0, if share.is_finite() { share.clamp(0.0, 1.0) } else { 0.5 }),
        Shown::Difference(full) => (1, if full > 0.0 && full.is_finite() { full } else { 1.0 }),
    };
    pass.key(&(mode, value.to_bits()));
    pass.execute(move |cx| {
        let [drawn, traced, target] = [drawn, traced, both].map(|handle| cx.view(handle));
        let uniform = cx.gpu.uniform("compare", &CompareUniform { mode, value });
        cx.counts().texels += u64::from(width) * u64::from(height);
        cx.dispatch(
            &ComputeKey::new("post/compare.wgsl", "main"),
            &[
                ("compare", Binding::Buffer(&uniform)),
                ("drawn", Binding::Texture(&drawn)),
                ("traced", Binding::Texture(&traced)),
                ("both", Binding::Texture(&target)),
            ],
            [width.div_ceil(8), height.div_ceil(8), 1],
        )
    });
    both
}
