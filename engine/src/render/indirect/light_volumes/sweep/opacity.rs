//! What stops light in the cells of a cascade: opacity tensor and seal.

use super::{coverage, links};
use crate::gpu::{Binding, ComputeKey};
use crate::graph::{Buffer, BufferDesc, Graph, Handle};
use crate::render::frame::Frame;
use crate::render::frame::linear_groups;
use crate::render::indirect::light_volumes::volume::Volume;
use crate::scene::Surfel;
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
    let mut pass = graph.pass(name.as_str());
    pass.read(surfels);
    pass.read(coverage);
    let (sums, opacity) = (pass.write(sums), pass.write(opacity));
    pass.key(&volume.key());
    let volume = *volume;
    pass.execute(move |cx| {
        let handles = [surfels, coverage, sums, opacity];
        let [source, coverage, fixed, target] = handles.map(|handle| cx.buffer(handle).clone());
        cx.encoder().clear_buffer(&fixed, 0, None);
        let uniform = cx.gpu.uniform("volume", &volume.uniform());
        let count = (source.size() / size_of::<Surfel>() as u64) as u32;
        cx.dispatch(
            &ComputeKey::new("indirect/light_volumes/sweep/opacity.wgsl", "scatter"),
            &[
                ("volume", Binding::Buffer(&uniform)),
                ("surfels", Binding::Buffer(&source)),
                ("sums", Binding::Buffer(&fixed)),
            ],
            linear_groups(count),
        )?;
        cx.counts().injections += u64::from(count);
        cx.counts().cells += u64::from(volume.cell_count());
        cx.dispatch(
            &ComputeKey::new("indirect/light_volumes/sweep/opacity.wgsl", "finish"),
            &[
                ("volume", Binding::Buffer(&uniform)),
                ("sums", Binding::Buffer(&fixed)),
                ("coverage", Binding::Buffer(&coverage)),
                ("opacity", Binding::Buffer(&target)),
            ],
            linear_groups(volume.cell_count()),
        )
    });
    Obstacles { opacity, coverage, links }
}
