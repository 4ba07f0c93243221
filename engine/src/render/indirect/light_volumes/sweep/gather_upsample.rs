//! Light of all pixels from that of one in each square of four. See `indirect/light_volumes/sweep/gather_upsample.wgsl`.

use super::gather_filter::Gathered;
use super::interleave::{Interleave, InterleaveUniform};
use crate::gpu::{Binding, ComputeKey};
use crate::graph::{Graph, Handle, Texture};
use crate::render::frame::{Frame, ViewUniform};
use crate::render::geometry::gbuffer::GBuffer;
use encase::ShaderType;

/// `Upsample` of `indirect/light_volumes/sweep/gather_upsample.wgsl`.
#[derive(ShaderType)]
pub(crate) struct UpsampleUniform {
    view: ViewUniform,
    #[shader(align(16))]
    interleave: InterleaveUniform,
}

/// Declares the pass; the result is reflected radiance of all pixels, with how much it counts beside that of other frames.
pub(super) fn declare<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    gbuffer: &GBuffer,
    gathered: Gathered,
    interleave: Interleave,
) -> Handle<Texture> {
    let indirect = graph.retained_texture("indirect radiance", frame.image_desc());
    let mut pass = graph.pass("gather upsample");
    let inputs = [gbuffer.base_color, gbuffer.normal, gbuffer.depth, gathered.diffuse, gathered.specular];
    inputs.into_iter().for_each(|handle| pass.read(handle));
    let indirect = pass.write(indirect);
    pass.key(&(interleave.key(), frame.view_key()));
    let [width, height] = frame.view.size;
    let uniform = UpsampleUniform { view: frame.view_values(), interleave: interleave.uniform() };
    pass.execute(move |cx| {
        let views = inputs.map(|handle| cx.view(handle));
        let target = cx.view(indirect);
        let uniform = cx.gpu.uniform("upsample", &uniform);
        let names = ["base_color", "normal", "depth", "diffuse", "specular"];
        let mut group = vec![("upsample", Binding::Buffer(&uniform)), ("indirect", Binding::Texture(&target))];
        group.extend(names.into_iter().zip(&views).map(|(name, view)| (name, Binding::Texture(view))));
        cx.counts().texels += u64::from(width) * u64::from(height);
        let key = ComputeKey::new("indirect/light_volumes/sweep/gather_upsample.wgsl", "main");
        cx.dispatch(&key, &group, [width.div_ceil(8), height.div_ceil(8), 1])
    });
    indirect
}
