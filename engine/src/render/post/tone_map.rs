//! Exposure, tone map and sRGB encoding: the display image.

use crate::gpu::{Binding, ComputeKey};
use crate::graph::{Graph, Handle, Texture, TextureDesc};
use crate::render::settings::{Layer, RenderSettings};
use encase::ShaderType;

/// Name of the retained display image.
pub const DISPLAY: &str = "display";
/// Name of the image before its edges are smoothed.
const TONE_MAPPED: &str = "tone mapped";

/// `ToneMap` of `post/tone_map.wgsl`.
#[derive(ShaderType)]
pub(crate) struct ToneMapUniform {
    scale: f32,
    mode: u32,
}

/// Declares the pass; the result is rgba8unorm, sRGB-encoded.
pub fn declare(
    graph: &mut Graph,
    settings: &RenderSettings,
    radiance: Handle<Texture>,
    [width, height]: [u32; 2],
) -> Handle<Texture> {
    let usage = wgpu::TextureUsages::STORAGE_BINDING | wgpu::TextureUsages::TEXTURE_BINDING;
    let name = if settings.mlaa { TONE_MAPPED } else { DISPLAY };
    let display = graph.retained_texture(name, TextureDesc::d2(width, height, wgpu::TextureFormat::Rgba8Unorm, usage));
    let mut pass = graph.pass("tone map");
    pass.read(radiance);
    let display = pass.write(display);
    // 2^±60 shows anything that a float can hold; beyond, the factor itself would leave the range.
    let exposure = if settings.exposure.is_finite() { settings.exposure.clamp(-60.0, 60.0) } else { 0.0 };
    // The constants of `post/tone_map.wgsl`.
    let (mode, scale) = match settings.only {
        Layer::Total | Layer::Direct | Layer::Indirect => (0, exposure.exp2()),
        Layer::Albedo | Layer::Normal => (1, 1.0),
        Layer::Depth => (2, 1.0),
    };
    let uniform = ToneMapUniform { scale, mode };
    pass.key(&(uniform.scale.to_bits(), uniform.mode));
    pass.execute(move |cx| {
        let (source, target) = (cx.view(radiance), cx.view(display));
        let uniform = cx.gpu.uniform("tone map", &uniform);
        cx.dispatch(
            &ComputeKey::new("post/tone_map.wgsl", "main"),
            &[
                ("tone_map", Binding::Buffer(&uniform)),
                ("radiance", Binding::Texture(&source)),
                ("display", Binding::Texture(&target)),
            ],
            [width.div_ceil(8), height.div_ceil(8), 1],
        )
    });
    display
}
