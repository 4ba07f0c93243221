//! Temporal anti-aliasing: smooth edges by the mean over frames whose pixel grids are shifted (Karis 2014, "High-quality
//! temporal supersampling"). A view that rests is the mean of its frames; where anything moves, what is remembered may not
//! leave what is seen around the pixel now. See `post/temporal_antialiasing.wgsl`.

use crate::gpu::ComputeKey;
use crate::graph::{Graph, Handle, Texture, Tracked};
use crate::render::frame::{Frame, ViewUniform};
use crate::render::geometry::gbuffer::GBuffer;
use encase::ShaderType;
use glam::Mat4;

/// Frames before that count at most while anything moves.
const MOST_WHILE_CHANGING: f32 = 9.0;

/// `Smooth` of `post/temporal_antialiasing.wgsl`.
#[derive(ShaderType)]
pub(crate) struct SmoothUniform {
    view: ViewUniform,
    unshifted: Mat4,
    unshifted_before: Mat4,
    most: f32,
    exposure: f32,
    is_known: u32,
    is_still: u32,
    is_bounded: u32,
}

/// Declares the pass; the result is linear radiance with smooth edges, rgba32float. None if that is not wanted.
pub(in crate::render) fn declare<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    gbuffer: &GBuffer,
    radiance: Handle<Texture>,
) -> Option<Handle<Texture>> {
    let (step, colors) = frame.history.step().zip(frame.history.colors())?;
    let smooth = graph.retained_texture("smooth radiance", frame.image_desc());
    let exposure = frame.settings.exposure_factor(&frame.view.camera.lens);
    let is_resting = step.is_still && step.tolerance == f32::MAX;
    let uniform = SmoothUniform {
        view: frame.view_values(),
        unshifted: step.unshifted[0],
        unshifted_before: step.unshifted[1],
        most: if is_resting { step.most } else { MOST_WHILE_CHANGING },
        exposure,
        is_known: u32::from(colors.is_known()),
        is_still: u32::from(step.is_still),
        is_bounded: u32::from(!is_resting),
    };
    let [now, before] = colors.now_and_before();
    let mut pass = graph.compute("temporal anti-aliasing", ComputeKey::new("post/temporal_antialiasing.wgsl", "main"));
    pass.uniform("smooth_edges", &uniform);
    pass.read("radiance", radiance);
    pass.read("object", gbuffer.object);
    pass.read("depth", gbuffer.depth);
    pass.tracked("color_before", Tracked::texture(before, &step.key()));
    pass.tracked("color_now", Tracked::texture(now, &step.key()));
    frame.bind_motions(&mut pass);
    let smooth = pass.write("smoothed", smooth);
    pass.dispatch_over(frame.view.size);
    Some(smooth)
}
