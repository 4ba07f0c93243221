//! What glossy surfaces reflect of the propagated light: a march along the reflected ray (Šefčík 2016, sections 3.10.4 and
//! 5.6, `MarchGlossIntensity`).

use super::relight::{self, cascade_buffers};
use crate::gpu::{Binding, ComputeKey, ShaderDef};
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
    let mut pass = graph.pass(NAME);
    let inputs = [gbuffer.base_color, gbuffer.normal, gbuffer.object, gbuffer.depth, diffuse];
    inputs.into_iter().for_each(|input| pass.read(input));
    lit.iter().for_each(|&volume| pass.read(volume));
    let indirect = pass.write(indirect);
    let uniform = relight::uniform(settings, volumes);
    pass.key(&(volumes[0].key(), uniform.key(), settings.gloss_march, frame.view_key()));
    let is_square = settings.gloss_march == GlossMarch::InverseSquare;
    let shader = ComputeKey {
        defs: is_square.then_some(("INVERSE_SQUARE", ShaderDef::Flag(true))).into_iter().collect(),
        ..ComputeKey::new("indirect/light_volumes/diffusion/gloss_march.wgsl", "main")
    };
    let (frame, lit) = (frame.clone(), lit.to_vec());
    pass.execute(move |cx| {
        let views = inputs.map(|handle| cx.view(handle));
        let target = cx.view(indirect);
        let [finest, second, third, coarsest] = cascade_buffers(cx, &lit);
        let (view, relight) = (frame.view_uniform(cx.gpu), cx.gpu.uniform("relight", &uniform));
        cx.counts().texels += u64::from(width) * u64::from(height);
        let mut bindings = vec![
            ("view", Binding::Buffer(&view)),
            ("relight", Binding::Buffer(&relight)),
            ("light_finest", Binding::Buffer(&finest)),
            ("light_second", Binding::Buffer(&second)),
            ("light_third", Binding::Buffer(&third)),
            ("light_coarsest", Binding::Buffer(&coarsest)),
            ("indirect", Binding::Texture(&target)),
        ];
        let names = ["base_color", "normal", "object", "depth", "diffuse"];
        bindings.extend(names.into_iter().zip(&views).map(|(name, view)| (name, Binding::Texture(view))));
        cx.dispatch(&shader, &bindings, [width.div_ceil(8), height.div_ceil(8), 1])
    });
    Some(indirect)
}
