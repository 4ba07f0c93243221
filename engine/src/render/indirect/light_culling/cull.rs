//! Which lights may reach which part of which tile.

use super::{Method, Sources};
use crate::gpu::ComputeKey;
use crate::graph::{Buffer, BufferDesc, Counts, Graph, Handle};
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
    let shader = ComputeKey::new("indirect/light_culling/cull.wgsl", "main");
    let mut pass = graph.compute("slc cull", shader);
    method.define_slices(&mut pass);
    pass.uniform("culling", &method.values(frame, 0));
    pass.read("depth", gbuffer.depth);
    pass.read("ranges", sources.ranges);
    pass.read("frames", frames);
    let (masks, slices) = (pass.write("masks", masks), pass.write("slices", slices));
    let [x, y] = method.tiles;
    let parts = method.subsets() * method.slices();
    pass.count(Counts { cells: u64::from(x) * u64::from(y) * u64::from(parts), ..Counts::default() });
    pass.dispatch_groups([x, y, method.subsets()]);
    Culled { masks, slices }
}

/// Declares the pass that stores each light's space of tests (2017, section 5.2).
fn declare_frames<'a>(graph: &mut Graph<'a>, frame: &Frame<'a>, method: &Method, sources: Sources) -> Handle<Buffer> {
    let count = method.lights.saturating_mul(method.subsets());
    let desc = BufferDesc::new(FRAME_BYTES * u64::from(count), BufferUsages::STORAGE);
    let frames = graph.retained_buffer("slc frames", desc);
    let mut pass = graph.compute("slc frames", ComputeKey::new("indirect/light_culling/frames.wgsl", "main"));
    pass.uniform("culling", &method.values(frame, 0));
    pass.read("ranges", sources.ranges);
    let frames = pass.write("frames", frames);
    pass.count(Counts { lights: count.into(), ..Counts::default() });
    pass.dispatch_items(count);
    frames
}
