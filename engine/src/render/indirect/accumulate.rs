//! Temporal accumulation of indirect light: the mean over frames, which random rays and directions rebuild in each.
//!
//! A view that rests is averaged over its frames until there are [`MOST_FRAMES`](crate::render::MOST_FRAMES), and is then
//! at rest. What the camera saw before is found where it and the object stood in the last frame (Nehab et al. 2007,
//! "Accelerating real-time shading with reverse reprojection caching"). See `indirect/accumulate.wgsl`, and
//! [`History`](crate::render::history::History) for what counts how much.

use super::IndirectLight;
use crate::gpu::{Binding, ComputeKey, ShaderDef};
use crate::graph::{Graph, Handle, Texture};
use crate::render::frame::{Frame, ViewUniform};
use crate::render::geometry::gbuffer::GBuffer;
use crate::render::rays::mirror_define;
use encase::ShaderType;
use glam::Mat4;

/// `Average` of `indirect/accumulate.wgsl`.
#[derive(ShaderType)]
pub(crate) struct AverageUniform {
    view: ViewUniform,
    clip_from_world_before: Mat4,
    world_from_clip_before: Mat4,
    most: f32,
    most_glossy: f32,
    is_first: u32,
    is_still: u32,
    tolerance: f32,
}

/// Declares the pass; the result is the mean of the light's radiance [W/(m² sr)] and what it was in the frames before. What is
/// not averaged stays as it is.
pub(in crate::render) fn declare<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    gbuffer: &GBuffer,
    light: &IndirectLight,
) -> Handle<Texture> {
    let indirect = light.radiance;
    let Some((step, targets)) = frame.history.step().zip(frame.history.targets()) else {
        graph.skip("average", "frames are shown as they are");
        return indirect;
    };
    let averaged = graph.retained_texture("averaged indirect radiance", frame.image_desc());
    let mut pass = graph.pass("average");
    let inputs = [gbuffer.base_color, gbuffer.normal, gbuffer.object];
    inputs.into_iter().chain([gbuffer.depth, indirect]).for_each(|handle| pass.read(handle));
    light.change.into_iter().for_each(|handle| pass.read(handle));
    let averaged = pass.write(averaged);
    pass.key(&(step.row, step.number, frame.view_key(), light.change.is_some(), light.mirrored.is_some()));
    let [width, height] = frame.view.size;
    let is_followed = light.change.is_some() && frame.history.follows_patches();
    let most = if is_followed { step.most_followed } else { step.most };
    let uniform = AverageUniform {
        view: frame.view_values(),
        clip_from_world_before: step.clip_from_world_before,
        world_from_clip_before: step.world_from_clip_before,
        most,
        most_glossy: if step.is_still { most } else { step.most_glossy },
        is_first: u32::from(step.number == 0),
        is_still: u32::from(step.is_still),
        tolerance: step.tolerance,
    };
    let now = (step.number % 2) as usize;
    let (written, before) = (&targets[now], &targets[1 - now]);
    let has_mirrors = light.mirrored.is_some();
    let (depth, change, frame) = (gbuffer.depth, light.change, frame.clone());
    pass.execute(move |cx| {
        let [base_color, normal, object] = inputs.map(|handle| cx.view(handle));
        let [depth, indirect, averaged] = [depth, indirect, averaged].map(|handle| cx.view(handle));
        let change = change.map(|handle| cx.buffer(handle).clone());
        let uniform = cx.gpu.uniform("average", &uniform);
        cx.counts().texels += u64::from(width) * u64::from(height);
        let mut key = ComputeKey::new("indirect/accumulate.wgsl", "main");
        let mut group = vec![
            ("average", Binding::Buffer(&uniform)),
            ("base_color", Binding::Texture(&base_color)),
            ("normal", Binding::Texture(&normal)),
            ("object", Binding::Texture(&object)),
            ("depth", Binding::Texture(&depth)),
            ("indirect", Binding::Texture(&indirect)),
            ("light_before", Binding::Texture(&before.light)),
            ("surface_before", Binding::Texture(&before.surface)),
            ("light_now", Binding::Texture(&written.light)),
            ("surface_now", Binding::Texture(&written.surface)),
            ("averaged", Binding::Texture(&averaged)),
        ];
        if let Some(moved) = frame.history.motions().buffer() {
            key = key.def("MOVED", ShaderDef::Flag(true));
            group.push(("moved", Binding::Buffer(moved)));
        }
        if has_mirrors {
            let (name, value) = mirror_define(false);
            key = key.def(name, value);
        }
        if let Some(change) = &change {
            key = key.def("PATCHES", ShaderDef::Flag(true));
            group.push(("patch_change", Binding::Buffer(change)));
            group.push(("primitive_ids", frame.surfels.primitive_ids()));
            group.extend(frame.surfels.patches().bindings());
        }
        cx.dispatch(&key, &group, [width.div_ceil(8), height.div_ceil(8), 1])
    });
    averaged
}
