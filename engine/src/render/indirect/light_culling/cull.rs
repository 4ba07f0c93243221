//! Which lights may reach which part of which tile.

use super::{Method, SLICES, Sources};
use crate::gpu::{Binding, ComputeKey};
use crate::graph::{Buffer, BufferDesc, Graph, Handle};
use crate::render::frame::Frame;
use crate::render::geometry::gbuffer::GBuffer;
use wgpu::BufferUsages;

/// Lights of the parts of the tiles.
#[derive(Clone, Copy)]
pub(super) struct Culled {
    /// A bit a light, for every subset, tile, slice and lobe.
    pub masks: Handle<Buffer>,
    /// The slice of every pixel.
    pub slices: Handle<Buffer>,
}

/// Declares the pass.
pub(super) fn declare<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    gbuffer: &GBuffer,
    method: &Method,
    sources: Sources,
) -> Culled {
    let [width, height] = frame.view.size;
    let buffer = |graph: &mut Graph<'a>, name: &str, words: u64| {
        graph.retained_buffer(name, BufferDesc::new(4 * words, BufferUsages::STORAGE))
    };
    let masks = buffer(graph, "slc masks", method.mask_words());
    let slices = buffer(graph, "slc slices", u64::from(width) * u64::from(height));
    let mut pass = graph.pass("slc cull");
    pass.read(gbuffer.depth);
    pass.read(sources.ranges);
    let (masks, slices) = (pass.write(masks), pass.write(slices));
    pass.key(&method.key(frame));
    let (frame, method, depth) = (frame.clone(), method.clone(), gbuffer.depth);
    pass.execute(move |cx| {
        let gpu = cx.gpu;
        let depth = cx.view(depth);
        let [ranges, masks, slices] = [sources.ranges, masks, slices].map(|handle| cx.buffer(handle).clone());
        let [x, y] = method.tiles;
        let counts = cx.counts();
        counts.cells += u64::from(x) * u64::from(y) * u64::from(method.subsets()) * u64::from(SLICES);
        cx.dispatch(
            &ComputeKey::new("indirect/light_culling/cull.wgsl", "main"),
            &[
                ("culling", Binding::Buffer(&method.uniform(gpu, &frame, 0))),
                ("depth", Binding::Texture(&depth)),
                ("ranges", Binding::Buffer(&ranges)),
                ("masks", Binding::Buffer(&masks)),
                ("slices", Binding::Buffer(&slices)),
            ],
            [x, y, method.subsets()],
        )
    });
    Culled { masks, slices }
}
