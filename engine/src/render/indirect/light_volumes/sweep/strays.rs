//! Strays: pixels whose surface no gathered pixel beside them shows. The passes that hand gathered light to other pixels put
//! them into a queue, and `gather` casts rays of their own for them. See `lib/strays.wgsl`.

use crate::graph::{Buffer, BufferDesc, ComputeBuilder, Graph, Handle, PassBindings, Step};
use crate::render::frame::Frame;
use wgpu::BufferUsages;

/// Pixels of a slice of the queue, which is dispatched by itself: `SLICE` of `lib/strays.wgsl`.
pub(super) const SLICE: u32 = 1 << 19;

/// The queue of the pixels of a frame. It has room for all of them.
#[derive(Clone, Copy)]
pub(super) struct Strays {
    /// x | y << 16.
    pixels: Handle<Buffer>,
    /// The number of pixels, and for each slice that of its workgroups along three axes.
    counts: Handle<Buffer>,
    room: u32,
}

impl Strays {
    /// An empty queue.
    pub fn declare(graph: &mut Graph, frame: &Frame) -> Self {
        let [width, height] = frame.view.size;
        let room = width * height;
        let desc = BufferDesc::new(4 * u64::from(room), BufferUsages::STORAGE);
        let pixels = graph.buffer("pixels that are left out", desc);
        let bytes = 4 + 12 * u64::from(room.div_ceil(SLICE));
        let desc = BufferDesc::new(bytes, BufferUsages::STORAGE | BufferUsages::INDIRECT);
        Self { pixels, counts: graph.retained_buffer("number of pixels that are left out", desc), room }
    }

    /// The queue after a pass that fills it; it is empty before.
    pub fn fill(self, pass: &mut ComputeBuilder) -> Self {
        let (pixels, counts) = (pass.write("stray_pixels", self.pixels), pass.write("stray_counts", self.counts));
        pass.clear(counts);
        Self { pixels, counts, ..self }
    }

    /// Binds it to a pass that reads it.
    pub fn bind(self, pass: &mut PassBindings) {
        pass.read("stray_pixels", self.pixels);
        pass.read("stray_counts", self.counts);
    }

    /// The first pixel of each slice, with how many there are at most.
    pub fn slices(self) -> impl Iterator<Item = (u32, u32)> {
        (0..self.room).step_by(SLICE as usize).map(move |first| (first, SLICE.min(self.room - first)))
    }

    /// Dispatches a slice, by its first pixel: the device knows how many workgroups it takes.
    pub fn dispatch(self, step: Step, first: u32, most: u32) {
        let offset = 4 + 12 * u64::from(first / SLICE);
        step.in_groups_of(self.counts, offset, [most.div_ceil(64), 1, 1]);
    }
}
