//! Which lights may reach which part of which tile.

use super::lights::groups_of;
use super::{Method, Sources};
use crate::gpu::{Binding, ComputeKey};
use crate::graph::{Buffer, BufferDesc, Graph, Handle};
use crate::render::frame::Frame;
use crate::render::geometry::gbuffer::GBuffer;
use wgpu::BufferUsages;

/// Bytes of `TestFrame` of `lib/slc.wgsl`.
pub(super) const FRAME_BYTES: u64 = 48;

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
    let frames = declare_frames(graph, frame, method, sources);
    let mut pass = graph.pass("slc cull");
    pass.read(gbuffer.depth);
    pass.read(sources.ranges);
    pass.read(frames);
    let (masks, slices) = (pass.write(masks), pass.write(slices));
    pass.key(&method.key(frame));
    let (frame, method, depth) = (frame.clone(), method.clone(), gbuffer.depth);
    pass.execute(move |cx| {
        let gpu = cx.gpu;
        let depth = cx.view(depth);
        let buffers = [sources.ranges, frames, masks, slices];
        let [ranges, frames, masks, slices] = buffers.map(|handle| cx.buffer(handle).clone());
        let [x, y] = method.tiles;
        let counts = cx.counts();
        counts.cells += u64::from(x) * u64::from(y) * u64::from(method.subsets()) * u64::from(method.slices());
        cx.dispatch(
            &method.sliced(ComputeKey::new("indirect/light_culling/cull.wgsl", "main")),
            &[
                ("culling", Binding::Buffer(&method.uniform(gpu, &frame, 0))),
                ("depth", Binding::Texture(&depth)),
                ("ranges", Binding::Buffer(&ranges)),
                ("frames", Binding::Buffer(&frames)),
                ("masks", Binding::Buffer(&masks)),
                ("slices", Binding::Buffer(&slices)),
            ],
            [x, y, method.subsets()],
        )
    });
    Culled { masks, slices }
}

/// Declares the pass that stores each light's space of tests (2017, section 5.2).
fn declare_frames<'a>(graph: &mut Graph<'a>, frame: &Frame<'a>, method: &Method, sources: Sources) -> Handle<Buffer> {
    let count = method.lights.saturating_mul(method.subsets());
    let desc = BufferDesc::new(FRAME_BYTES * u64::from(count), BufferUsages::STORAGE);
    let frames = graph.retained_buffer("slc frames", desc);
    let mut pass = graph.pass("slc frames");
    pass.read(sources.ranges);
    let frames = pass.write(frames);
    pass.key(&method.key(frame));
    let (frame, method) = (frame.clone(), method.clone());
    pass.execute(move |cx| {
        let [ranges, target] = [sources.ranges, frames].map(|handle| cx.buffer(handle).clone());
        cx.counts().lights += u64::from(count);
        cx.dispatch(
            &ComputeKey::new("indirect/light_culling/frames.wgsl", "main"),
            &[
                ("culling", Binding::Buffer(&method.uniform(cx.gpu, &frame, 0))),
                ("ranges", Binding::Buffer(&ranges)),
                ("frames", Binding::Buffer(&target)),
            ],
            groups_of(count),
        )
    });
    frames
}
