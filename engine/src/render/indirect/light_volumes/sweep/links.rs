//! Which cells the surfels take their light from and send it to.

use crate::gpu::{Binding, ComputeKey};
use crate::graph::{Buffer, BufferDesc, Graph, Handle, PassContext, PassError};
use crate::render::frame::linear_groups;
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
    let mut pass = graph.pass(name.as_str());
    pass.read(surfels);
    pass.read(coverage);
    let links = pass.write(links);
    pass.key(&volume.key());
    let volume = *volume;
    pass.execute(move |cx| {
        let [surfels, coverage, links] = [surfels, coverage, links].map(|handle| cx.buffer(handle).clone());
        find(cx, &volume, [&surfels, &coverage, &links], count)
    });
    links
}

/// Finds the links of so many surfels.
pub(super) fn find(
    cx: &mut PassContext,
    volume: &Volume,
    [surfels, coverage, links]: [&wgpu::Buffer; 3],
    count: u32,
) -> Result<(), PassError> {
    let uniform = cx.gpu.uniform("volume", &volume.uniform());
    cx.dispatch(
        &ComputeKey::new("indirect/light_volumes/sweep/links.wgsl", "main"),
        &[
            ("volume", Binding::Buffer(&uniform)),
            ("surfels", Binding::Buffer(surfels)),
            ("coverage", Binding::Buffer(coverage)),
            ("links", Binding::Buffer(links)),
        ],
        linear_groups(count),
    )
}
