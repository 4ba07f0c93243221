//! The scene's surfels in world space. See `indirect/light_volumes/sweep/surfels.wgsl`.

use crate::gpu::ComputeKey;
use crate::graph::{Buffer, BufferDesc, Graph, Handle};
use crate::render::frame::Frame;
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
    let mut pass = graph.compute(NAME, ComputeKey::new("indirect/light_volumes/sweep/surfels.wgsl", "main"));
    gpu_surfels.bind(&mut pass, &frame.geometry_key());
    let surfels = pass.write("surfels", surfels);
    pass.dispatch_items(count);
    surfels
}
