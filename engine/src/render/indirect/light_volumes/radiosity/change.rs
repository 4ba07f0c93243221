//! How the light of patches changes from frame to frame. See `indirect/light_volumes/radiosity/change.wgsl`.

use crate::gpu::{Binding, ComputeKey, ShaderDef};
use crate::graph::{Buffer, BufferDesc, Graph, Handle};
use crate::render::frame::{Frame, linear_groups};
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
    let mut pass = graph.pass("change of patches");
    [surfels, patches].into_iter().for_each(|handle| pass.read(handle));
    let change = pass.write(change);
    pass.key(&(step.row, step.number, frame.surfels.revision(), history.is_known()));
    let cloud = frame.surfels;
    pass.execute(move |cx| {
        let [surfels, patches, change] = [surfels, patches, change].map(|handle| cx.buffer(handle).clone());
        let spacing = cx.gpu.uniform("spacing", &cloud.patch_size());
        let [now, before] = history.now_and_before();
        let mut key = ComputeKey::new("indirect/light_volumes/radiosity/change.wgsl", "main");
        let mut group = vec![
            ("patch_light", Binding::Buffer(&patches)),
            ("history_now", Binding::Buffer(now)),
            ("patch_change", Binding::Buffer(&change)),
        ];
        if history.is_known() {
            key = key.def("KNOWN", ShaderDef::Flag(true));
            group.extend([("history_before", Binding::Buffer(before)), ("patches", cloud.patches().ranges())]);
            group.extend([("surfels", Binding::Buffer(&surfels)), ("spacing", Binding::Buffer(&spacing))]);
            group.extend(cloud.patches().bindings().into_iter().filter(|(name, _)| *name != "place_of_primitive"));
        }
        cx.dispatch(&key, &group, linear_groups(count))
    });
    Some(change)
}
