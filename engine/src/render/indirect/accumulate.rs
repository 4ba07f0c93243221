//! Temporal accumulation of indirect light: the mean over frames, which random rays and directions rebuild in each.
//!
//! A view that rests is averaged over its frames until there are [`MOST_FRAMES`](crate::render::MOST_FRAMES), and is then
//! at rest. What the camera saw before is found where it and the object stood in the last frame (Nehab et al. 2007,
//! "Accelerating real-time shading with reverse reprojection caching"). See `indirect/accumulate.wgsl`, and
//! [`History`](crate::render::history::History) for what counts how much.

use super::IndirectLight;
use crate::gpu::ComputeKey;
use crate::graph::{Graph, Handle, Texture, Tracked};
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
    let of_frame = |view| Tracked::texture(view, &step.key());
    let mut pass = graph.compute("average", ComputeKey::new("indirect/accumulate.wgsl", "main"));
    pass.uniform("average", &uniform);
    gbuffer.bind(&mut pass);
    pass.read("indirect", indirect);
    pass.tracked("light_before", of_frame(&before.light));
    pass.tracked("surface_before", of_frame(&before.surface));
    pass.tracked("light_now", of_frame(&written.light));
    pass.tracked("surface_now", of_frame(&written.surface));
    let averaged = pass.write("averaged", averaged);
    frame.bind_motions(&mut pass);
    if light.mirrored.is_some() {
        let (name, value) = mirror_define(false);
        pass.define(name, value);
    }
    if let Some(change) = light.change {
        pass.flag("PATCHES", true);
        pass.read("patch_change", change);
        pass.tracked("primitive_ids", frame.surfels.primitive_ids(&frame.geometry_key()));
        frame.bind_patches(&mut pass);
    }
    pass.dispatch_over([width, height]);
    averaged
}
