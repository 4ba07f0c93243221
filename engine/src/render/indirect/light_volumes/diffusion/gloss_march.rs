//! What glossy surfaces reflect of the propagated light: a march along the reflected ray (Šefčík 2016, sections 3.10.4 and
//! 5.6, `MarchGlossIntensity`).

use super::relight;
use crate::gpu::ComputeKey;
use crate::graph::{Buffer, Graph, Handle, Texture, TextureDesc};
use crate::render::frame::Frame;
use crate::render::geometry::gbuffer::GBuffer;
use crate::render::indirect::gloss;
use crate::render::indirect::light_volumes::volume::Volume;
use crate::world::{Clpv, GlossMarch};

/// Declares the pass; the result is `diffuse` with what glossy surfaces reflect, and without what that takes from the
/// diffuse reflection. `None`, with the reason in the report, if nothing is to be reflected.
pub(super) fn declare<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    gbuffer: &GBuffer,
    settings: &Clpv,
    diffuse: Handle<Texture>,
    (volumes, lit): (&[Volume], &[Handle<Buffer>]),
) -> Option<Handle<Texture>> {
    const NAME: &str = "gloss march";
    if settings.gloss_march == GlossMarch::Off {
        graph.skip(NAME, "the march is switched off");
        return None;
    }
    if !gloss::is_wanted(frame.scene) {
        graph.skip(NAME, "no surface of the scene is glossy");
        return None;
    }
    let [width, height] = frame.view.size;
    let usage = wgpu::TextureUsages::STORAGE_BINDING | wgpu::TextureUsages::TEXTURE_BINDING;
    let desc = TextureDesc::d2(width, height, wgpu::TextureFormat::Rgba32Float, usage);
    let indirect = graph.retained_texture("marched radiance", desc);
    let shader = ComputeKey::new("indirect/light_volumes/diffusion/gloss_march.wgsl", "main");
    let mut pass = graph.compute(NAME, shader);
    pass.flag("INVERSE_SQUARE", settings.gloss_march == GlossMarch::InverseSquare);
    frame.bind_view(&mut pass);
    pass.uniform("relight", &relight::uniform(settings, volumes));
    gbuffer.bind(&mut pass);
    pass.read("diffuse", diffuse);
    relight::bind_cascades(&mut pass, lit);
    let indirect = pass.write("indirect", indirect);
    pass.dispatch_over([width, height]);
    Some(indirect)
}
