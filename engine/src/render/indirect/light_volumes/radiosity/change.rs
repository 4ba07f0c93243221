//! How the light of patches changes from frame to frame. See `indirect/light_volumes/radiosity/change.wgsl`.

use crate::gpu::ComputeKey;
use crate::graph::{Buffer, BufferDesc, Graph, Handle, Tracked};
use crate::render::frame::Frame;
use wgpu::BufferUsages;

/// Declares the pass, if frames are averaged: for each patch its light over that of the frame before, by channel, and how
/// uncertain that is for single points of it.
pub(super) fn declare<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    surfels: Handle<Buffer>,
    patches: Handle<Buffer>,
) -> Option<Handle<Buffer>> {
    let (step, history) = frame.history.step().zip(frame.history.patches())?;
    let count = frame.surfels.patch_count();
    let desc = BufferDesc::new(16 * u64::from(count.max(1)), BufferUsages::STORAGE);
    let change = graph.retained_buffer("change of patches", desc);
    let mut pass =
        graph.compute("change of patches", ComputeKey::new("indirect/light_volumes/radiosity/change.wgsl", "main"));
    let [now, before] = history.now_and_before();
    let cloud = frame.surfels;
    let of_frame = (step.row, step.number, cloud.revision());
    pass.read("patch_light", patches);
    pass.tracked("history_now", Tracked::buffer(now, &of_frame));
    let change = pass.write("patch_change", change);
    if history.is_known() {
        pass.flag("KNOWN", true);
        pass.tracked("history_before", Tracked::buffer(before, &of_frame));
        pass.tracked("patches", cloud.ranges());
        pass.read("surfels", surfels);
        pass.uniform("spacing", &cloud.patch_size());
        cloud.patches().bind_grids(&mut pass, &(frame.geometry_key(), cloud.revision()));
    }
    pass.dispatch_items(count);
    Some(change)
}
