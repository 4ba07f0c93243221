//! Which cells the surfels take their light from and send it to.

use crate::gpu::ComputeKey;
use crate::graph::{Buffer, BufferDesc, Graph, Handle};
use crate::render::indirect::light_volumes::volume::Volume;
use wgpu::BufferUsages;

/// Declares the links of the surfels to a cascade: a word each, see `indirect/light_volumes/sweep/links.wgsl`. They depend on the scene's
/// surfaces alone.
pub(super) fn declare(
    graph: &mut Graph<'_>,
    [surfels, coverage]: [Handle<Buffer>; 2],
    count: u32,
    level: &str,
    volume: &Volume,
) -> Handle<Buffer> {
    let name = format!("links, {level}");
    let links = graph.retained_buffer(name.as_str(), BufferDesc::new(4 * u64::from(count), BufferUsages::STORAGE));
    let mut pass = graph.compute(name.as_str(), shader());
    pass.uniform("volume", &volume.uniform());
    pass.read("surfels", surfels);
    pass.read("coverage", coverage);
    let links = pass.write("links", links);
    pass.dispatch_items(count);
    links
}

/// Finds the links of surfels to a cascade.
pub(super) fn shader() -> ComputeKey {
    ComputeKey::new("indirect/light_volumes/sweep/links.wgsl", "main")
}
