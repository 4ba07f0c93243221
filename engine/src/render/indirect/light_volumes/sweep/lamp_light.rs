//! Light straight from the lights in each cell, for media to scatter. See `indirect/light_volumes/sweep/lamp_light.wgsl`.

use crate::gpu::ComputeKey;
use crate::graph::{Buffer, BufferDesc, Counts, Graph, Handle};
use crate::render::direct::lamps::Lamps;
use crate::render::frame::Frame;
use crate::render::indirect::light_volumes::volume::Volume;
use wgpu::BufferUsages;

/// Bytes of a cell.
const CELL_BYTES: u64 = 48;

/// Declares the pass; the result is three vectors a cell. None where there are no media.
pub(super) fn declare<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    name: &str,
    volume: &Volume,
) -> Option<Handle<Buffer>> {
    let lamps = Lamps::of(graph, frame)?;
    let name = format!("haze, {name}");
    let usage = BufferUsages::STORAGE | BufferUsages::COPY_DST;
    let desc = BufferDesc::new(CELL_BYTES * u64::from(volume.cell_count()), usage);
    let light = graph.retained_buffer(name.clone(), desc);
    let mut pass = graph.compute(name, ComputeKey::new("indirect/light_volumes/sweep/lamp_light.wgsl", "main"));
    frame.gpu_scene.bind_media(&mut pass);
    pass.uniform("volume", &volume.uniform());
    let light = pass.write("lamp_light", light);
    pass.count(Counts { cells: volume.cell_count().into(), ..Counts::default() });
    match lamps.is_empty() {
        true => pass.step("main").over_items(volume.cell_count()),
        false => lamps.declare_steps(&mut pass, false, volume.cell_count()),
    }
    pass.finish();
    Some(light)
}
