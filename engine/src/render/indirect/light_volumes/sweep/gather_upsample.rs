//! Light of all pixels from that of one in each square of four. See `indirect/light_volumes/sweep/gather_upsample.wgsl`.

use super::gather_filter::{self, Gathered};
use super::interleave::{Interleave, InterleaveUniform};
use super::strays::Strays;
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

/// Declares the pass; the result is reflected radiance of all pixels, with how much it counts beside that of other frames, and
/// which of them are left out.
pub(super) fn declare<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    gbuffer: &GBuffer,
    gathered: Gathered,
    interleave: Interleave,
) -> (Handle<Texture>, Strays) {
    let strays = Strays::declare(graph, frame);
    let indirect = graph.retained_texture("indirect radiance", frame.image_desc());
    let mut pass = graph.pass("gather upsample");
    let inputs = [
        ("base_color", gbuffer.base_color),
        ("normal", gbuffer.normal),
        ("depth", gbuffer.depth),
        ("diffuse", gathered.diffuse),
        ("specular", gathered.specular),
    ];
    let inputs: Vec<_> = inputs.into_iter().chain(gather_filter::tint(frame, gbuffer)).collect();
    inputs.iter().for_each(|(_, handle)| pass.read(*handle));
    let (indirect, strays) = (pass.write(indirect), strays.write(&mut pass));
    pass.key(&(interleave.key(), frame.view_key(), gather_filter::is_tinted(frame)));
    let [width, height] = frame.view.size;
    let uniform = UpsampleUniform { view: frame.view_values(), interleave: interleave.uniform() };
    let frame = frame.clone();
    pass.execute(move |cx| {
        let queue = strays.cleared(cx);
        let views: Vec<_> = inputs.iter().map(|(name, handle)| (*name, cx.view(*handle))).collect();
        let target = cx.view(indirect);
        let uniform = cx.gpu.uniform("upsample", &uniform);
        let mut group = vec![("upsample", Binding::Buffer(&uniform)), ("indirect", Binding::Texture(&target))];
        group.extend(views.iter().map(|(name, view)| (*name, Binding::Texture(view))));
        group.extend(queue.bindings());
        cx.counts().texels += u64::from(width) * u64::from(height);
        let key = ComputeKey::new("indirect/light_volumes/sweep/gather_upsample.wgsl", "main");
        let key = gather_filter::tinted(&frame, key);
        cx.dispatch(&key, &group, [width.div_ceil(8), height.div_ceil(8), 1])
    });
    (indirect, strays)
}
