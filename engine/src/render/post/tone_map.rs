//! Exposure, tone map and sRGB encoding: the display image.

use crate::assets::CubeTable;
use crate::gpu::{Binding, ComputeKey, Gpu, ShaderDef};
use crate::graph::{Graph, Handle, Texture, TextureDesc};
use crate::render::settings::{Beside, Layer, RenderSettings, Shown, ToneMap};
use crate::scene::SceneCamera;
use crate::world::Lens;
use encase::ShaderType;
use glam::Vec3;

/// Name of the retained display image.
pub const DISPLAY: &str = "display";
/// Name of the image before its edges are smoothed, or film is added.
pub(in crate::render) const TONE_MAPPED: &str = "tone mapped";

/// `ToneMap` of `post/tone_map.wgsl`.
#[derive(ShaderType)]
pub(crate) struct ToneMapUniform {
    scale: f32,
    vignette: f32,
    low: Vec3,
    entries: u32,
    high: Vec3,
}

/// Declares the pass; the result is an image of that name, rgba8unorm, sRGB-encoded.
pub fn declare(
    graph: &mut Graph,
    settings: &RenderSettings,
    camera: &SceneCamera,
    radiance: Handle<Texture>,
    [width, height]: [u32; 2],
    name: &str,
) -> Handle<Texture> {
    let lens = &camera.lens;
    // Overlays are drawn into it.
    let usage = wgpu::TextureUsages::STORAGE_BINDING
        | wgpu::TextureUsages::TEXTURE_BINDING
        | wgpu::TextureUsages::RENDER_ATTACHMENT;
    let display = graph.retained_texture(name, TextureDesc::d2(width, height, wgpu::TextureFormat::Rgba8Unorm, usage));
    let is_light = shows_light(settings);
    let automatic =
        (settings.is_auto_exposed(lens) && is_light).then(|| super::auto_exposure::declare(graph, radiance));
    let mut pass = graph.pass("tone map");
    pass.read(radiance);
    if let Some(automatic) = automatic {
        pass.read(automatic);
    }
    let display = pass.write(display);
    let scale = if is_light { settings.exposure_factor(lens) } else { 1.0 };
    let mode = mode(settings, lens);
    let vignette = if is_light { vignette(lens.vignette) } else { 0.0 };
    let table = camera.grading.clone().filter(|_| is_light);
    let id = table.as_ref().map(|table| table.id);
    pass.key(&(scale.to_bits(), vignette.to_bits(), mode, automatic.is_some(), id));
    pass.execute(move |cx| {
        let (source, target) = (cx.view(radiance), cx.view(display));
        let (entries, [low, high]) = table.as_ref().map_or((0, [Vec3::ZERO; 2]), |table| (table.size, table.domain));
        let uniform = cx.gpu.uniform("tone map", &ToneMapUniform { scale, vignette, low, entries, high });
        let grading = table.as_ref().map(|table| entries_of(cx.gpu, table));
        let automatic = match automatic {
            Some(automatic) => cx.buffer(automatic).clone(),
            None => cx.gpu.constants("no exposure", &[1.0f32]),
        };
        let mut key = ComputeKey::new("post/tone_map.wgsl", "main").def("MODE", ShaderDef::Uint(mode));
        if vignette > 0.0 {
            key = key.def("VIGNETTE", ShaderDef::Flag(true));
        }
        let mut group = vec![
            ("automatic", Binding::Buffer(&automatic)),
            ("tone_map", Binding::Buffer(&uniform)),
            ("radiance", Binding::Texture(&source)),
            ("display", Binding::Texture(&target)),
        ];
        if let Some(grading) = &grading {
            key = key.def("GRADING", ShaderDef::Flag(true));
            group.push(("grading", Binding::Buffer(grading)));
        }
        cx.dispatch(&key, &group, [width.div_ceil(8), height.div_ceil(8), 1])
    });
    display
}

/// The entries of a table on the device.
fn entries_of(gpu: &Gpu, table: &CubeTable) -> wgpu::Buffer {
    let entries: Vec<[f32; 4]> = table.entries.iter().map(|entry| entry.extend(0.0).to_array()).collect();
    gpu.constants("colour table", &entries)
}

/// Square of the tangent at the corners, tan²θ, for which cos⁴θ leaves all but that share of the light.
fn vignette(loss: f32) -> f32 {
    (1.0 - loss).sqrt().recip() - 1.0
}

/// Whether the image holds light, rather than colours that are shown as they are.
pub(in crate::render) fn shows_light(settings: &RenderSettings) -> bool {
    let is_difference = matches!(settings.beside, Some(Beside { shown: Shown::Difference(_), .. }));
    settings.only.is_light() && !is_difference
}

/// The constants of `post/tone_map.wgsl`.
fn mode(settings: &RenderSettings, lens: &Lens) -> u32 {
    const AS_IT_IS: u32 = 1;
    match settings.only {
        Layer::Depth => 2,
        _ if !shows_light(settings) => AS_IT_IS,
        _ => match settings.show.tone_map.unwrap_or(lens.tone_map) {
            ToneMap::Neutral => 0,
            ToneMap::Linear => AS_IT_IS,
            ToneMap::Filmic => 3,
            ToneMap::AgX => 4,
            ToneMap::Aces => 5,
            ToneMap::Reinhard => 6,
        },
    }
}
