//! Light of an image from what another one with a shifted pixel grid has gathered. See
//! `indirect/light_volumes/sweep/gather_shift.wgsl`.

use super::gather_filter::{self, Gathered};
use super::strays::Strays;
use crate::gpu::{Binding, ComputeKey};
use crate::graph::{Graph, Handle, Texture};
use crate::render::frame::{Frame, ViewUniform};
use crate::render::geometry::gbuffer::GBuffer;
use encase::ShaderType;

/// `Shift` of `indirect/light_volumes/sweep/gather_shift.wgsl`.
#[derive(ShaderType)]
pub(crate) struct ShiftUniform {
    view: ViewUniform,
    gathered: ViewUniform,
}

/// An image: the frame that it belongs to, and what its pixels see.
#[derive(Clone, Copy)]
pub(super) struct Seen<'f, 'a> {
    pub frame: &'f Frame<'a>,
    pub gbuffer: &'f GBuffer,
}

/// Declares the pass; the result is reflected radiance of the pixels of `shown`, and which of them are left out.
pub(super) fn declare<'a>(
    graph: &mut Graph<'a>,
    shown: Seen<'_, 'a>,
    gathered_at: Seen<'_, 'a>,
    gathered: Gathered,
) -> (Handle<Texture>, Strays) {
    let Seen { frame, gbuffer } = shown;
    let strays = Strays::declare(graph, frame);
    let indirect = graph.retained_texture("indirect radiance", frame.image_desc());
    let mut pass = graph.pass("gather shift");
    let inputs = [
        ("base_color", gbuffer.base_color),
        ("normal", gbuffer.normal),
        ("depth", gbuffer.depth),
        ("gathered_normal", gathered_at.gbuffer.normal),
        ("gathered_depth", gathered_at.gbuffer.depth),
        ("diffuse", gathered.diffuse),
        ("specular", gathered.specular),
    ];
    let inputs: Vec<_> = inputs.into_iter().chain(gather_filter::tint(frame, gbuffer)).collect();
    inputs.iter().for_each(|(_, handle)| pass.read(*handle));
    let (indirect, strays) = (pass.write(indirect), strays.write(&mut pass));
    pass.key(&(frame.view_key(), gathered_at.frame.view_key(), gather_filter::is_tinted(frame)));
    let [width, height] = frame.view.size;
    let uniform = ShiftUniform { view: frame.view_values(), gathered: gathered_at.frame.view_values() };
    let frame = frame.clone();
    pass.execute(move |cx| {
        let queue = strays.cleared(cx);
        let views: Vec<_> = inputs.iter().map(|(name, handle)| (*name, cx.view(*handle))).collect();
        let target = cx.view(indirect);
        let uniform = cx.gpu.uniform("shift", &uniform);
        let mut group = vec![("shift", Binding::Buffer(&uniform)), ("indirect", Binding::Texture(&target))];
        group.extend(views.iter().map(|(name, view)| (*name, Binding::Texture(view))));
        group.extend(queue.bindings());
        cx.counts().texels += u64::from(width) * u64::from(height);
        let key = ComputeKey::new("indirect/light_volumes/sweep/gather_shift.wgsl", "main");
        let key = gather_filter::tinted(&frame, key);
        cx.dispatch(&key, &group, [width.div_ceil(8), height.div_ceil(8), 1])
    });
    (indirect, strays)
}
