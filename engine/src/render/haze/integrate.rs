//! What is scattered towards the eye up to each slice. See `haze/integrate.wgsl`.

use super::grid::Grid;
use crate::gpu::ComputeKey;
use crate::graph::{Buffer, BufferDesc, Counts, Graph, Handle};
use crate::render::frame::Frame;
use wgpu::BufferUsages;

/// Declares the pass; the result is light \[W/(m² sr)\] by column and slice.
pub(super) fn declare<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    grid: &Grid,
    scattered: Handle<Buffer>,
) -> Handle<Buffer> {
    let desc = BufferDesc::new(grid.bytes(), BufferUsages::STORAGE);
    let in_scattered = graph.retained_buffer("haze, light up to slices", desc);
    let mut pass = graph.compute("haze integrate", ComputeKey::new("haze/integrate.wgsl", "main"));
    frame.bind_view(&mut pass);
    grid.bind(&mut pass);
    frame.gpu_scene.bind_media(&mut pass);
    pass.read("scattered", scattered);
    let in_scattered = pass.write("in_scattered", in_scattered);
    pass.count(Counts { cells: grid.cells().into(), ..Counts::default() });
    pass.dispatch_items(grid.columns());
    in_scattered
}
