//! Screen-space ambient occlusion: how much of the volumes' light nearby surfaces keep away (Šefčík 2016, section 8.2; Jimenez
//! et al. 2016). See `indirect/light_volumes/diffusion/ambient_occlusion.wgsl`.

use crate::gpu::{Binding, ComputeKey};
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
    let mut pass = graph.pass(NAME);
    let inputs = [gbuffer.normal, gbuffer.depth];
    inputs.into_iter().for_each(|input| pass.read(input));
    let [noisy, visibility] = [noisy, visibility].map(|target| pass.write(target));
    let Region { origin, size } = region;
    pass.key(&(radius.to_bits(), origin.to_array(), size.to_array(), frame.view_key()));
    let uniform = OcclusionUniform { origin, size, radius, padding: 0 };
    let frame = frame.clone();
    pass.execute(move |cx| {
        let view = frame.view_uniform(cx.gpu);
        let occlusion = cx.gpu.uniform("occlusion", &uniform);
        let [normal, depth, noisy, visibility] =
            [inputs[0], inputs[1], noisy, visibility].map(|handle| cx.view(handle));
        cx.counts().texels += u64::from(size.x) * u64::from(size.y);
        let inputs = [
            ("view", Binding::Buffer(&view)),
            ("occlusion", Binding::Buffer(&occlusion)),
            ("normal", Binding::Texture(&normal)),
            ("depth", Binding::Texture(&depth)),
        ];
        let groups = [size.x.div_ceil(8), size.y.div_ceil(8), 1];
        let occlude = [&inputs[..], &[("integrals", Binding::Texture(&noisy))]].concat();
        cx.dispatch(&ComputeKey::new(SHADER, "occlude"), &occlude, groups)?;
        let denoise =
            [&inputs[..], &[("noisy", Binding::Texture(&noisy)), ("visibility", Binding::Texture(&visibility))]]
                .concat();
        cx.dispatch(&ComputeKey::new(SHADER, "denoise"), &denoise, groups)
    });
    Some(visibility)
}
