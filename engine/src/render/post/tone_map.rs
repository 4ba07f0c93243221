//! Exposure, tone map and sRGB encoding: the display image.

use crate::assets::CubeTable;
use crate::gpu::{ComputeKey, ShaderDef};
use crate::graph::{Graph, Handle, Texture, TextureDesc};
use crate::render::settings::{Beside, Layer, RenderSettings, Shown, ToneMap};
use crate::scene::SceneCamera;
use crate::world::Lens;
use encase::ShaderType;
use glam::Vec3;
use std::sync::Arc;

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
    // Overlays are drawn into it.
    let usage = wgpu::TextureUsages::STORAGE_BINDING
        | wgpu::TextureUsages::TEXTURE_BINDING
        | wgpu::TextureUsages::RENDER_ATTACHMENT;
    let display = graph.retained_texture(name, TextureDesc::d2(width, height, wgpu::TextureFormat::Rgba8Unorm, usage));
    let is_automatic = settings.is_auto_exposed(&camera.lens) && shows_light(settings);
    let automatic = is_automatic.then(|| super::auto_exposure::declare(graph, radiance));
    let curve = Curve::of(settings, camera, is_automatic);
    let mut pass = graph.compute("tone map", curve.shader());
    match automatic {
        Some(automatic) => pass.read("automatic", automatic),
        None => pass.values("automatic", &[1.0_f32]),
    }
    pass.uniform("tone_map", &curve.uniform());
    pass.read("radiance", radiance);
    let display = pass.write("display", display);
    if let Some(table) = curve.table {
        let id = table.id;
        let entries = move || table.entries.iter().map(|entry| entry.extend(0.0).to_array()).collect();
        pass.values_of("grading", &id, entries);
    }
    pass.dispatch_over([width, height]);
    display
}

/// What becomes of radiance.
struct Curve {
    scale: f32,
    vignette: f32,
    mode: u32,
    table: Option<Arc<CubeTable>>,
}

impl Curve {
    fn of(settings: &RenderSettings, camera: &SceneCamera, is_automatic: bool) -> Self {
        let lens = &camera.lens;
        let mode = mode(settings, lens);
        if !shows_light(settings) {
            return Self { scale: 1.0, vignette: 0.0, mode, table: None };
        }
        let scale = if is_automatic { settings.correction_factor(lens) } else { settings.exposure_factor(lens) };
        Self { scale, vignette: vignette(lens.vignette), mode, table: camera.grading.clone() }
    }

    fn uniform(&self) -> ToneMapUniform {
        let (entries, [low, high]) =
            self.table.as_ref().map_or((0, [Vec3::ZERO; 2]), |table| (table.size, table.domain));
        ToneMapUniform { scale: self.scale, vignette: self.vignette, low, entries, high }
    }

    fn shader(&self) -> ComputeKey {
        let mut key = ComputeKey::new("post/tone_map.wgsl", "main").def("MODE", ShaderDef::Uint(self.mode));
        if self.vignette > 0.0 {
            key = key.def("VIGNETTE", ShaderDef::Flag(true));
        }
        if self.table.is_some() {
            key = key.def("GRADING", ShaderDef::Flag(true));
        }
        key
    }
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
