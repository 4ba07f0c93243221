//! Temporal accumulation of mirror reflections, which move otherwise than the surfaces that show them. See
//! `indirect/mirror_average.wgsl`.

use crate::gpu::{Binding, ComputeKey, ShaderDef};
use crate::graph::{Graph, Handle, Texture};
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
    let mut pass = graph.pass(name);
    let inputs = [gbuffer.normal, gbuffer.object, gbuffer.depth, mirrored];
    inputs.into_iter().for_each(|handle| pass.read(handle));
    let averaged = pass.write(averaged);
    pass.key(&(step.row, step.number, frame.view_key(), images.is_known()));
    let [width, height] = frame.view.size;
    let is_resting = step.is_still && !frame.history.is_changing();
    let uniform = MirrorAverageUniform {
        view: frame.view_values(),
        clip_from_world_before: step.clip_from_world_before,
        most: if is_resting { step.most } else { MOST_WHILE_CHANGING },
        is_known: u32::from(images.is_known()),
        is_still: u32::from(step.is_still),
        is_bounded: u32::from(!is_resting),
    };
    let frame = frame.clone();
    pass.execute(move |cx| {
        let [now, before] = images.now_and_before();
        let views = inputs.map(|handle| cx.view(handle));
        let target = cx.view(averaged);
        let uniform = cx.gpu.uniform("mirror average", &uniform);
        cx.counts().texels += u64::from(width) * u64::from(height);
        let mut key = ComputeKey::new("indirect/mirror_average.wgsl", "main");
        let mut group = vec![
            ("average", Binding::Buffer(&uniform)),
            ("before", Binding::Texture(before)),
            ("now", Binding::Texture(now)),
            ("averaged", Binding::Texture(&target)),
        ];
        let names = ["normal", "object", "depth", "mirrored"];
        group.extend(names.into_iter().zip(&views).map(|(name, view)| (name, Binding::Texture(view))));
        if let Some(moved) = frame.history.motions().buffer() {
            key = key.def("MOVED", ShaderDef::Flag(true));
            group.push(("moved", Binding::Buffer(moved)));
        }
        cx.dispatch(&key, &group, [width.div_ceil(8), height.div_ceil(8), 1])
    });
    averaged
}
