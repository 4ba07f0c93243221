//! What stops light in the cells of a cascade: opacity tensor and seal.

use super::{coverage, links};
use crate::gpu::ComputeKey;
use crate::graph::{Buffer, BufferDesc, Counts, Graph, Handle};
use crate::render::frame::Frame;
use crate::render::indirect::light_volumes::volume::Volume;
use wgpu::BufferUsages;

/// Bytes of a cell: 44 numbers.
const CELL_BYTES: u64 = 176;

/// Obstacles of light in a cascade.
#[derive(Clone, Copy)]
pub(super) struct Obstacles {
    /// Opacity of the cells and their faces, see `indirect/light_volumes/sweep/opacity.wgsl`.
    pub opacity: Handle<Buffer>,
    /// Coverage between the parts of cells, see `indirect/light_volumes/sweep/coverage.wgsl`.
    pub coverage: Handle<Buffer>,
    /// Which cells each surfel has to do with, see `indirect/light_volumes/sweep/links.wgsl`.
    pub links: Handle<Buffer>,
}

/// Declares what stops light in one cascade. It depends on the scene's surfaces alone, not on any light.
pub(super) fn declare<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    surfels: Handle<Buffer>,
    level: &str,
    volume: &Volume,
) -> Obstacles {
    let coverage = coverage::declare(graph, frame, level, volume);
    let links = links::declare(graph, [surfels, coverage], frame.surfels.count(), level, volume);
    let name = format!("opacity, {level}");
    let usage = BufferUsages::STORAGE | BufferUsages::COPY_DST;
    let desc = BufferDesc::new(CELL_BYTES * u64::from(volume.cell_count()), usage);
    let sums = graph.buffer(format!("{name}, fixed point"), desc.clone());
    let opacity = graph.retained_buffer(name.as_str(), desc);
    let count = frame.surfels.count();
    let mut pass = graph.compute(name, ComputeKey::new("indirect/light_volumes/sweep/opacity.wgsl", "scatter"));
    pass.uniform("volume", &volume.uniform());
    pass.read("surfels", surfels);
    pass.read("coverage", coverage);
    let (sums, opacity) = (pass.write("sums", sums), pass.write("opacity", opacity));
    pass.count(Counts { injections: count.into(), cells: volume.cell_count().into(), ..Counts::default() });
    pass.clear(sums);
    pass.step("scatter").over_items(count);
    pass.step("finish").over_items(volume.cell_count());
    pass.finish();
    Obstacles { opacity, coverage, links }
}
