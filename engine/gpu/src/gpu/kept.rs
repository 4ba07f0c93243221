//! What the device keeps over frames: uniforms, constants, views and bind groups.

use super::context::Gpu;
use super::reuse::BindKey;
use std::sync::PoisonError;

/// Frames for which a buffer is kept that no frame uses.
const KEEP_CONSTANTS: u64 = 32;

/// Frames for which a view or a bind group is kept that no frame uses: they keep memory of the device alive.
const KEEP_BOUND: u64 = 8;

impl Gpu {
    /// A view of all mip levels of some layers: the same one as long as frames ask for it.
    pub fn view_of_layers(
        &self,
        texture: &wgpu::Texture,
        dimension: wgpu::TextureViewDimension,
        layers: std::ops::Range<u32>,
    ) -> wgpu::TextureView {
        let mut views = self.views.lock().unwrap_or_else(PoisonError::into_inner);
        let key = (texture.clone(), dimension, layers);
        if let Some(view) = views.get(&key) {
            return view;
        }
        let view = texture.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(dimension),
            base_array_layer: key.2.start,
            array_layer_count: Some(key.2.end - key.2.start),
            ..Default::default()
        });
        views.insert(key, view.clone());
        view
    }

    /// The texture view of that name and number of layers, made once: for what is bound where there is nothing to bind.
    #[doc(hidden)]
    pub fn stand_in(
        &self,
        name: &'static str,
        layers: u32,
        make: impl FnOnce() -> wgpu::TextureView,
    ) -> wgpu::TextureView {
        let mut stand_ins = self.stand_ins.lock().unwrap_or_else(PoisonError::into_inner);
        stand_ins.entry((name, layers)).or_insert_with(make).clone()
    }

    /// The buffer with that content, which is made and uploaded if no frame lately had it.
    pub(crate) fn kept(&self, label: &str, bytes: Vec<u8>, usage: wgpu::BufferUsages) -> wgpu::Buffer {
        self.audit.note(label, &bytes);
        let is_uniform = usage.contains(wgpu::BufferUsages::UNIFORM);
        let kept = if is_uniform { &self.uniforms } else { &self.constants };
        let mut kept = kept.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(buffer) = kept.get(bytes.as_slice()) {
            return buffer;
        }
        let buffer = self.filled_buffer(label, &bytes, usage);
        kept.insert(bytes, buffer.clone());
        buffer
    }

    /// The bind group made of that; the error is what the device says where it refuses it.
    pub(super) fn kept_bind_group(
        &self,
        key: BindKey,
        descriptor: &wgpu::BindGroupDescriptor,
    ) -> Result<wgpu::BindGroup, String> {
        let mut groups = self.bind_groups.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(group) = groups.get(&key) {
            return Ok(group);
        }
        self.count(|counts| counts.bind_groups += 1);
        let group = self.checked(|| self.device.create_bind_group(descriptor))?;
        groups.insert(key, group.clone());
        Ok(group)
    }

    /// A frame is over. Where it let go of targets, views and bind groups that it did not use may hold them: those go
    /// too.
    pub(crate) fn end_frame(&self, has_evicted: bool) {
        let keep = if has_evicted { 1 } else { KEEP_BOUND };
        self.bind_groups.lock().unwrap_or_else(PoisonError::into_inner).end_frame(keep);
        self.views.lock().unwrap_or_else(PoisonError::into_inner).end_frame(keep);
        for kept in [&self.uniforms, &self.constants] {
            kept.lock().unwrap_or_else(PoisonError::into_inner).end_frame(KEEP_CONSTANTS);
        }
    }
}
