//! Temporal anti-aliasing: smooth edges by the mean over frames whose pixel grids are shifted (Karis 2014, "High-quality
//! temporal supersampling"). A view that rests is the mean of its frames; where anything moves, what is remembered may not
//! leave what is seen around the pixel now. See `post/temporal_antialiasing.wgsl`.

use crate::gpu::{Binding, ComputeKey, ShaderDef};
use crate::graph::{Graph, Handle, Texture};
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
    let mut pass = graph.pass("temporal anti-aliasing");
    [radiance, gbuffer.object, gbuffer.depth].into_iter().for_each(|handle| pass.read(handle));
    let smooth = pass.write(smooth);
    let exposure = frame.settings.exposure_factor(&frame.view.camera.lens);
    pass.key(&(step.row, step.number, frame.view_key(), exposure.to_bits(), colors.is_known()));
    let [width, height] = frame.view.size;
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
    let (gbuffer, frame) = (*gbuffer, frame.clone());
    pass.execute(move |cx| {
        let [now, before] = colors.now_and_before();
        let [radiance, object, depth, target] =
            [radiance, gbuffer.object, gbuffer.depth, smooth].map(|handle| cx.view(handle));
        let uniform = cx.gpu.uniform("smooth", &uniform);
        cx.counts().texels += u64::from(width) * u64::from(height);
        let mut key = ComputeKey::new("post/temporal_antialiasing.wgsl", "main");
        let mut group = vec![
            ("smooth_edges", Binding::Buffer(&uniform)),
            ("radiance", Binding::Texture(&radiance)),
            ("object", Binding::Texture(&object)),
            ("depth", Binding::Texture(&depth)),
            ("color_before", Binding::Texture(before)),
            ("color_now", Binding::Texture(now)),
            ("smoothed", Binding::Texture(&target)),
        ];
        if let Some(moved) = frame.history.motions().buffer() {
            key = key.def("MOVED", ShaderDef::Flag(true));
            group.push(("moved", Binding::Buffer(moved)));
        }
        cx.dispatch(&key, &group, [width.div_ceil(8), height.div_ceil(8), 1])
    });
    Some(smooth)
}
