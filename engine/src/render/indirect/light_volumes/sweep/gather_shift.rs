//! Light of an image from what another one with a shifted pixel grid has gathered. See
//! `indirect/light_volumes/sweep/gather_shift.wgsl`.

use super::gather_filter::{self, Gathered};
use super::strays::Strays;
use crate::gpu::ComputeKey;
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
    let shader = ComputeKey::new("indirect/light_volumes/sweep/gather_shift.wgsl", "main");
    let mut pass = graph.compute("gather shift", shader);
    pass.uniform("shift", &ShiftUniform { view: frame.view_values(), gathered: gathered_at.frame.view_values() });
    pass.read("base_color", gbuffer.base_color);
    pass.read("normal", gbuffer.normal);
    pass.read("depth", gbuffer.depth);
    pass.read("gathered_normal", gathered_at.gbuffer.normal);
    pass.read("gathered_depth", gathered_at.gbuffer.depth);
    pass.read("diffuse", gathered.diffuse);
    pass.read("specular", gathered.specular);
    gather_filter::bind_tint(&mut pass, frame, gbuffer);
    let (indirect, strays) = (pass.write("indirect", indirect), strays.fill(&mut pass));
    pass.step("main").over(frame.view.size);
    pass.finish();
    (indirect, strays)
}
