//! The scene's surfels in world space. See `indirect/light_volumes/sweep/surfels.wgsl`.

use crate::gpu::{Binding, ComputeKey};
use crate::graph::{Buffer, BufferDesc, Graph, Handle};
use crate::render::frame::{Frame, linear_groups};
use crate::scene::Surfel;
use wgpu::BufferUsages;

/// Declares the surfels in world space; once a frame, whoever needs them.
pub(in crate::render::indirect::light_volumes) fn declare<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
) -> Handle<Buffer> {
    const NAME: &str = "surfels";
    if let Some(declared) = graph.latest(NAME) {
        return declared;
    }
    let gpu_surfels = frame.surfels;
    let count = gpu_surfels.count();
    let bytes = u64::from(count) * size_of::<Surfel>() as u64;
    let surfels = graph.retained_buffer(NAME, BufferDesc::new(bytes, BufferUsages::STORAGE));
    let mut pass = graph.pass(NAME);
    let surfels = pass.write(surfels);
    pass.key(&(frame.geometry_key(), gpu_surfels.revision()));
    pass.execute(move |cx| {
        let target = cx.buffer(surfels).clone();
        let [cloud, places] = gpu_surfels.bindings();
        cx.dispatch(
            &ComputeKey::new("indirect/light_volumes/sweep/surfels.wgsl", "main"),
            &[cloud, places, ("surfels", Binding::Buffer(&target))],
            linear_groups(count),
        )
    });
    surfels
}
