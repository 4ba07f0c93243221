//! Screen-space ambient occlusion: how much of the volumes' light nearby surfaces keep away (Šefčík 2016, section 8.2; Jimenez
//! et al. 2016). See `indirect/light_volumes/diffusion/ambient_occlusion.wgsl`.

use crate::gpu::ComputeKey;
use crate::graph::{Graph, Handle, Texture, TextureDesc};
use crate::render::direct::Region;
use crate::render::frame::Frame;
use crate::render::geometry::gbuffer::GBuffer;
use crate::world::Clpv;
use encase::ShaderType;
use glam::UVec2;

/// `Occlusion` of `indirect/light_volumes/diffusion/ambient_occlusion.wgsl`.
#[derive(ShaderType)]
pub(crate) struct OcclusionUniform {
    origin: UVec2,
    size: UVec2,
    radius: f32,
    padding: u32,
}

/// Declares the pass; the result is the share of light that arrives, r32float, in a region of the image. `None`, with the
/// reason in the report, if it is switched off.
pub(super) fn declare<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    gbuffer: &GBuffer,
    settings: &Clpv,
    region: Region,
) -> Option<Handle<Texture>> {
    const NAME: &str = "ambient occlusion";
    const SHADER: &str = "indirect/light_volumes/diffusion/ambient_occlusion.wgsl";
    let radius = settings.ambient_occlusion;
    if !(radius > 0.0 && radius.is_finite()) {
        graph.skip(NAME, "it is switched off");
        return None;
    }
    if region.size == UVec2::ZERO {
        graph.skip(NAME, "no volume is in view");
        return None;
    }
    let [width, height] = frame.view.size;
    let usage = wgpu::TextureUsages::STORAGE_BINDING | wgpu::TextureUsages::TEXTURE_BINDING;
    let desc = TextureDesc::d2(width, height, wgpu::TextureFormat::R32Float, usage);
    let slices = TextureDesc::d2(width, height, wgpu::TextureFormat::Rg32Float, usage);
    let noisy = graph.texture("slices of ambient occlusion", slices);
    let visibility = graph.retained_texture(NAME, desc);
    let mut pass = graph.compute(NAME, ComputeKey::new(SHADER, "occlude"));
    let Region { origin, size } = region;
    frame.bind_view(&mut pass);
    pass.uniform("occlusion", &OcclusionUniform { origin, size, radius, padding: 0 });
    pass.read("normal", gbuffer.normal);
    pass.read("depth", gbuffer.depth);
    let noisy = pass.write("integrals", noisy);
    let visibility = pass.write("visibility", visibility);
    pass.step("occlude").over(size.into());
    let mut denoise = pass.step("denoise");
    denoise.read("noisy", noisy);
    denoise.over_uncounted(size.into());
    pass.finish();
    Some(visibility)
}
