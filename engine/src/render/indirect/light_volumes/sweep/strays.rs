//! Strays: pixels whose surface no gathered pixel beside them shows. The passes that hand gathered light to other pixels put
//! them into a queue, and `gather` casts rays of their own for them. See `lib/strays.wgsl`.

use crate::gpu::Binding;
use crate::graph::{Buffer, BufferDesc, Graph, Groups, Handle, PassBuilder, PassContext};
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

/// The buffers of the queue in a running pass.
pub(super) struct Queue {
    pixels: wgpu::Buffer,
    counts: wgpu::Buffer,
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

    /// The queue after a pass that fills it.
    pub fn write(self, pass: &mut PassBuilder) -> Self {
        Self { pixels: pass.write(self.pixels), counts: pass.write(self.counts), ..self }
    }

    /// Lets a pass read it.
    pub fn read(self, pass: &mut PassBuilder) {
        pass.read(self.pixels);
        pass.read(self.counts);
    }

    /// The queue in a pass that reads it.
    pub fn queue(self, cx: &PassContext) -> Queue {
        let [pixels, counts] = [self.pixels, self.counts].map(|handle| cx.buffer(handle).clone());
        Queue { pixels, counts }
    }

    /// The empty queue in the pass that fills it.
    pub fn cleared(self, cx: &mut PassContext) -> Queue {
        let queue = self.queue(cx);
        cx.encoder().clear_buffer(&queue.counts, 0, None);
        queue
    }

    /// The first pixel of each slice, with how many there are at most.
    pub fn slices(self) -> impl Iterator<Item = (u32, u32)> {
        (0..self.room).step_by(SLICE as usize).map(move |first| (first, SLICE.min(self.room - first)))
    }
}

impl Queue {
    /// By the names of `lib/strays.wgsl`.
    pub fn bindings(&self) -> [(&'static str, Binding<'_>); 2] {
        [("stray_pixels", Binding::Buffer(&self.pixels)), ("stray_counts", Binding::Buffer(&self.counts))]
    }

    /// The workgroups of a slice, by its first pixel.
    pub fn groups(&self, first: u32, most: u32) -> Groups<'_> {
        let offset = 4 + 12 * u64::from(first / SLICE);
        Groups::Buffer { counts: &self.counts, offset, most: [most.div_ceil(64), 1, 1] }
    }
}
