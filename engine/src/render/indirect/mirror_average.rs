//! Temporal accumulation of mirror reflections, which move otherwise than the surfaces that show them. See
//! `indirect/mirror_average.wgsl`.

use crate::gpu::ComputeKey;
use crate::graph::{Graph, Handle, Texture, Tracked};
use crate::render::frame::{Frame, ViewUniform};
use crate::render::geometry::gbuffer::GBuffer;
use encase::ShaderType;
use glam::Mat4;

/// Frames before that count at most while anything moves.
const MOST_WHILE_CHANGING: f32 = 7.0;

/// `MirrorAverage` of `indirect/mirror_average.wgsl`.
#[derive(ShaderType)]
pub(crate) struct MirrorAverageUniform {
    view: ViewUniform,
    clip_from_world_before: Mat4,
    most: f32,
    is_known: u32,
    is_still: u32,
    is_bounded: u32,
}

/// Declares the pass; the result is the mean of the mirrored radiance [W/(m² sr)] and what it was in the frames before. What
/// is not averaged stays as it is.
pub(in crate::render) fn declare<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    gbuffer: &GBuffer,
    mirrored: Handle<Texture>,
) -> Handle<Texture> {
    let name = gbuffer.surfaces.name("mirror average");
    let Some((step, images)) = frame.history.step().zip(frame.history.mirrors(gbuffer.surfaces)) else {
        graph.skip(name, "frames are shown as they are");
        return mirrored;
    };
    let averaged = graph.retained_texture(gbuffer.surfaces.name("averaged mirrored radiance"), frame.image_desc());
    let is_resting = step.is_still && !frame.history.is_changing();
    let uniform = MirrorAverageUniform {
        view: frame.view_values(),
        clip_from_world_before: step.clip_from_world_before,
        most: if is_resting { step.most } else { MOST_WHILE_CHANGING },
        is_known: u32::from(images.is_known()),
        is_still: u32::from(step.is_still),
        is_bounded: u32::from(!is_resting),
    };
    let [now, before] = images.now_and_before();
    let mut pass = graph.compute(name, ComputeKey::new("indirect/mirror_average.wgsl", "main"));
    pass.uniform("average", &uniform);
    pass.tracked("before", Tracked::texture(before, &step.key()));
    pass.tracked("now", Tracked::texture(now, &step.key()));
    pass.read("normal", gbuffer.normal);
    pass.read("object", gbuffer.object);
    pass.read("depth", gbuffer.depth);
    pass.read("mirrored", mirrored);
    frame.bind_motions(&mut pass);
    let averaged = pass.write("averaged", averaged);
    pass.dispatch_over(frame.view.size);
    averaged
}
