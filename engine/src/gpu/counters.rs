//! Counts of requests of the host to the device, which do not depend on the machine.

use super::Gpu;
use std::fmt;
use std::sync::PoisonError;

/// Counts of requests of the host to the device. They are of all that goes through [`Gpu`] and the render graph.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct HostCounts {
    /// Compute dispatches.
    pub dispatches: u64,
    /// Compute passes; several dispatches may share one.
    pub compute_passes: u64,
    /// Render passes.
    pub render_passes: u64,
    /// Submits to the queue.
    pub submits: u64,
    /// Bind groups made.
    pub bind_groups: u64,
    /// Buffers made.
    pub buffers: u64,
    /// Bytes uploaded into buffers and textures.
    pub uploaded: u64,
    /// Waits for the device.
    pub waits: u64,
    /// Pipelines made.
    pub pipelines: u64,
    /// Expressions and statements of their entry points, every call inlined: what the driver compiles.
    pub operations: u64,
}

impl HostCounts {
    /// All counts with their names.
    pub fn named(&self) -> [(&'static str, u64); 10] {
        [
            ("dispatches", self.dispatches),
            ("compute passes", self.compute_passes),
            ("render passes", self.render_passes),
            ("submits", self.submits),
            ("bind groups made", self.bind_groups),
            ("buffers made", self.buffers),
            ("bytes uploaded", self.uploaded),
            ("waits", self.waits),
            ("pipelines made", self.pipelines),
            ("operations compiled", self.operations),
        ]
    }

    /// The counts since then.
    pub fn since(&self, then: &Self) -> Self {
        Self {
            dispatches: self.dispatches - then.dispatches,
            compute_passes: self.compute_passes - then.compute_passes,
            render_passes: self.render_passes - then.render_passes,
            submits: self.submits - then.submits,
            bind_groups: self.bind_groups - then.bind_groups,
            buffers: self.buffers - then.buffers,
            uploaded: self.uploaded - then.uploaded,
            waits: self.waits - then.waits,
            pipelines: self.pipelines - then.pipelines,
            operations: self.operations - then.operations,
        }
    }
}

impl fmt::Display for HostCounts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let counts: Vec<String> = self.named().map(|(name, count)| format!("{count} {name}")).into();
        f.pad(&counts.join(", "))
    }
}

/// Calls to the device that are counted.
impl Gpu {
    /// The counts since the device was opened, on all threads.
    pub fn counts(&self) -> HostCounts {
        *self.counts.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(crate) fn count(&self, add: impl FnOnce(&mut HostCounts)) {
        add(&mut self.counts.lock().unwrap_or_else(PoisonError::into_inner));
    }

    /// Makes a buffer.
    pub fn create_buffer(&self, descriptor: &wgpu::BufferDescriptor) -> wgpu::Buffer {
        self.count(|counts| counts.buffers += 1);
        self.device.create_buffer(descriptor)
    }

    /// Writes into a buffer, before what is submitted next. Offset and length are multiples of 4 bytes.
    pub fn write_buffer(&self, buffer: &wgpu::Buffer, offset: u64, bytes: &[u8]) {
        self.count(|counts| counts.uploaded += bytes.len() as u64);
        self.queue.write_buffer(buffer, offset, bytes);
    }

    /// Writes texels into a texture, before what is submitted next.
    pub fn write_texture(
        &self,
        texture: wgpu::TexelCopyTextureInfo,
        bytes: &[u8],
        layout: wgpu::TexelCopyBufferLayout,
        size: wgpu::Extent3d,
    ) {
        self.count(|counts| counts.uploaded += bytes.len() as u64);
        self.queue.write_texture(texture, bytes, layout, size);
    }

    /// Submits what was recorded, or only what was written if that is nothing.
    pub fn submit(&self, recorded: Option<wgpu::CommandEncoder>) -> wgpu::SubmissionIndex {
        self.count(|counts| counts.submits += 1);
        self.queue.submit(recorded.map(wgpu::CommandEncoder::finish))
    }

    /// Begins a render pass.
    pub fn render_pass<'e>(
        &self,
        encoder: &'e mut wgpu::CommandEncoder,
        descriptor: &wgpu::RenderPassDescriptor,
    ) -> wgpu::RenderPass<'e> {
        self.count(|counts| counts.render_passes += 1);
        encoder.begin_render_pass(descriptor)
    }

    /// Waits until the device has done all that was submitted.
    pub fn wait(&self) {
        self.count(|counts| counts.waits += 1);
        if let Err(error) = self.device.poll(wgpu::PollType::Wait { submission_index: None, timeout: None }) {
            log::error!("waiting for the graphics device: {error}");
        }
    }
}
