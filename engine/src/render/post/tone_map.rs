//! Exposure, tone map and sRGB encoding: the display image.

use crate::gpu::{Binding, ComputeKey};
use crate::graph::{Graph, Handle, Texture, TextureDesc};
use crate::render::settings::{Beside, Layer, RenderSettings, Shown, ToneMap};
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
    is_auto: u32,
}

/// Declares the pass; the result is rgba8unorm, sRGB-encoded.
pub fn declare(
    graph: &mut Graph,
    settings: &RenderSettings,
    radiance: Handle<Texture>,
    [width, height]: [u32; 2],
) -> Handle<Texture> {
    // Overlays are drawn into it.
    let usage = wgpu::TextureUsages::STORAGE_BINDING
        | wgpu::TextureUsages::TEXTURE_BINDING
        | wgpu::TextureUsages::RENDER_ATTACHMENT;
    let name = if settings.mlaa { TONE_MAPPED } else { DISPLAY };
    let display = graph.retained_texture(name, TextureDesc::d2(width, height, wgpu::TextureFormat::Rgba8Unorm, usage));
    let is_difference = matches!(settings.beside, Some(Beside { shown: Shown::Difference(_), .. }));
    let automatic = (settings.show.auto_exposure && settings.only.is_light() && !is_difference)
        .then(|| super::auto_exposure::declare(graph, radiance));
    let mut pass = graph.pass("tone map");
    pass.read(radiance);
    if let Some(automatic) = automatic {
        pass.read(automatic);
    }
    let display = pass.write(display);
    // 2^±60 shows anything that a float can hold; beyond, the factor itself would leave the range.
    let wanted = settings.show.exposure + if automatic.is_some() { 0.0 } else { settings.exposure };
    let exposure = if wanted.is_finite() { wanted.clamp(-60.0, 60.0) } else { 0.0 };
    // The constants of `post/tone_map.wgsl`.
    let (mode, scale) = match settings.only {
        // Its values are the colours of a scale.
        _ if is_difference && settings.only.is_light() => (1, 1.0),
        Layer::Total | Layer::Direct | Layer::Indirect => match settings.show.tone_map {
            ToneMap::Neutral => (0, exposure.exp2()),
            ToneMap::Filmic => (3, exposure.exp2()),
            ToneMap::Linear => (1, exposure.exp2()),
        },
        Layer::Albedo | Layer::Normal => (1, 1.0),
        Layer::Depth => (2, 1.0),
    };
    let uniform = ToneMapUniform { scale, mode, is_auto: automatic.is_some().into() };
    pass.key(&(uniform.scale.to_bits(), uniform.mode, uniform.is_auto));
    pass.execute(move |cx| {
        let (source, target) = (cx.view(radiance), cx.view(display));
        let uniform = cx.gpu.uniform("tone map", &uniform);
        let automatic = match automatic {
            Some(automatic) => cx.buffer(automatic).clone(),
            None => cx.gpu.constants("no exposure", &[1.0f32]),
        };
        cx.dispatch(
            &ComputeKey::new("post/tone_map.wgsl", "main"),
            &[
                ("automatic", Binding::Buffer(&automatic)),
                ("tone_map", Binding::Buffer(&uniform)),
                ("radiance", Binding::Texture(&source)),
                ("display", Binding::Texture(&target)),
            ],
            [width.div_ceil(8), height.div_ceil(8), 1],
        )
    });
    display
}
