//! Requests to the device, which are counted.

use super::context::Gpu;
use super::counters::HostCounts;
use std::sync::PoisonError;

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
