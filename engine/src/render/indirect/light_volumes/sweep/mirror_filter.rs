//! The filter over mirror reflections, by how far their surfaces blur them. See
//! `indirect/light_volumes/sweep/mirror_filter.wgsl`.

use crate::gpu::{Binding, ComputeKey};
use crate::graph::{Graph, Handle, Texture};
use crate::render::frame::{Frame, ViewUniform};
use crate::render::geometry::gbuffer::GBuffer;
use encase::ShaderType;

/// Width of the filter over that of the lobe: both together are a tenth wider than the lobe.
const WIDTH: f32 = 0.5;
/// The same in frames of a window, which have a ray a pixel: as wide as the lobe.
const WIDTH_IN_WINDOWS: f32 = 1.0;

/// `MirrorFilter` of `indirect/light_volumes/sweep/mirror_filter.wgsl`.
#[derive(ShaderType)]
pub(crate) struct MirrorFilterUniform {
    view: ViewUniform,
    width: f32,
}

/// Declares the pass; the result is as the input, with less noise.
pub(in crate::render) fn declare<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    gbuffer: &GBuffer,
    mirrored: Handle<Texture>,
) -> Handle<Texture> {
    let filtered = graph.retained_texture(gbuffer.surfaces.name("mirrored radiance, filtered"), frame.image_desc());
    let mut pass = graph.pass(gbuffer.surfaces.name("mirror filter"));
    let inputs = [gbuffer.normal, gbuffer.object, gbuffer.depth, mirrored];
    inputs.into_iter().for_each(|handle| pass.read(handle));
    let filtered = pass.write(filtered);
    // As the filter of the gather: the more images, the narrower.
    let width = if frame.number().is_some() { WIDTH_IN_WINDOWS } else { WIDTH };
    let width = width / (frame.images().max(1) as f32).cbrt();
    pass.key(&(width.to_bits(), frame.view_key()));
    let [columns, rows] = frame.view.size;
    let uniform = MirrorFilterUniform { view: frame.view_values(), width };
    pass.execute(move |cx| {
        let views = inputs.map(|handle| cx.view(handle));
        let target = cx.view(filtered);
        let uniform = cx.gpu.uniform("mirror filter", &uniform);
        cx.counts().texels += u64::from(columns) * u64::from(rows);
        let mut group = vec![("mirror_filter", Binding::Buffer(&uniform)), ("filtered", Binding::Texture(&target))];
        let names = ["normal", "object", "depth", "mirrored"];
        group.extend(names.into_iter().zip(&views).map(|(name, view)| (name, Binding::Texture(view))));
        let key = ComputeKey::new("indirect/light_volumes/sweep/mirror_filter.wgsl", "main");
        cx.dispatch(&key, &group, [columns.div_ceil(8), rows.div_ceil(8), 1])
    });
    filtered
}
