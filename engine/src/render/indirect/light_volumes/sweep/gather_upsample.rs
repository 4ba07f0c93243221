//! Light of all pixels from that of one in each square of four. See `indirect/light_volumes/sweep/gather_upsample.wgsl`.

use super::gather_filter::{self, Gathered};
use super::interleave::{Interleave, InterleaveUniform};
use super::strays::Strays;
use crate::gpu::ComputeKey;
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
    let shader = ComputeKey::new("indirect/light_volumes/sweep/gather_upsample.wgsl", "main");
    let mut pass = graph.compute("gather upsample", shader);
    pass.uniform("upsample", &UpsampleUniform { view: frame.view_values(), interleave: interleave.uniform() });
    pass.read("base_color", gbuffer.base_color);
    pass.read("normal", gbuffer.normal);
    pass.read("depth", gbuffer.depth);
    pass.read("diffuse", gathered.diffuse);
    pass.read("specular", gathered.specular);
    gather_filter::bind_tint(&mut pass, frame, gbuffer);
    let (indirect, strays) = (pass.write("indirect", indirect), strays.fill(&mut pass));
    pass.step("main").over(frame.view.size);
    pass.finish();
    (indirect, strays)
}
