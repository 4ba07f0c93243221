//! What is scattered towards the eye up to each slice. See `haze/integrate.wgsl`.

use super::as_bindings;
use super::grid::Grid;
use crate::gpu::ComputeKey;
use crate::graph::{Buffer, BufferDesc, Graph, Handle};
use crate::render::frame::{Frame, linear_groups};
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
    let mut pass = graph.pass("haze integrate");
    pass.read(scattered);
    let in_scattered = pass.write(in_scattered);
    pass.key(&(frame.media_key(), grid.key(), frame.view_key()));
    let (frame, grid) = (frame.clone(), *grid);
    pass.execute(move |cx| {
        let mut buffers = vec![
            ("view", frame.view_uniform(cx.gpu)),
            ("haze", grid.uniform(cx.gpu)),
            ("scattered", cx.buffer(scattered).clone()),
            ("in_scattered", cx.buffer(in_scattered).clone()),
        ];
        buffers.extend(frame.gpu_scene.media_binding(cx.gpu));
        let key = frame.gpu_scene.with_media(ComputeKey::new("haze/integrate.wgsl", "main"));
        cx.counts().cells += u64::from(grid.cells());
        cx.dispatch(&key, &as_bindings(&buffers), linear_groups(grid.columns()))
    });
    in_scattered
}
