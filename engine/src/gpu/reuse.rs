//! Uniforms, constants and bind groups that are kept over frames: what has not changed is neither uploaded nor bound
//! anew.

use super::Gpu;
use std::collections::HashMap;
use std::hash::Hash;
use std::sync::PoisonError;

/// Frames for which a buffer is kept that no frame uses.
const KEEP_CONSTANTS: u64 = 32;

/// Frames for which a view or a bind group is kept that no frame uses: they keep memory of the device alive.
const KEEP_BOUND: u64 = 8;

/// Things by what they are made of, and the frame in which each was used last.
pub(super) struct Kept<K, V> {
    entries: HashMap<K, (V, u64)>,
    frame: u64,
}

impl<K, V> Default for Kept<K, V> {
    fn default() -> Self {
        Self { entries: HashMap::new(), frame: 0 }
    }
}

impl<K: Hash + Eq, V: Clone> Kept<K, V> {
    /// The thing made of that, if it is there.
    pub fn get<Q: Hash + Eq + ?Sized>(&mut self, key: &Q) -> Option<V>
    where
        K: std::borrow::Borrow<Q>,
    {
        let (value, used) = self.entries.get_mut(key)?;
        *used = self.frame;
        Some(value.clone())
    }

    pub fn insert(&mut self, key: K, value: V) {
        self.entries.insert(key, (value, self.frame));
    }

    /// A frame is over: lets go of what none of the last so many has used.
    fn end_frame(&mut self, keep: u64) {
        self.entries.retain(|_, (_, used)| self.frame - *used < keep);
        self.frame += 1;
    }
}

/// The content of a buffer that no shader writes.
pub(super) type ConstantsKey = Vec<u8>;

/// The key of a bind group. It keeps its resources alive, so that none of their identities comes back as another.
#[derive(Clone, PartialEq, Eq, Hash)]
pub(super) struct BindKey {
    pub layout: wgpu::BindGroupLayout,
    pub resources: Vec<(u32, BoundResource)>,
}

#[derive(Clone, PartialEq, Eq, Hash)]
pub(super) enum BoundResource {
    View(wgpu::TextureView),
    Sampler(wgpu::Sampler),
    Buffer(wgpu::Buffer, u64, Option<wgpu::BufferSize>),
}

impl BoundResource {
    pub fn of(resource: &wgpu::BindingResource) -> Option<Self> {
        match resource {
            wgpu::BindingResource::TextureView(view) => Some(Self::View((*view).clone())),
            wgpu::BindingResource::Sampler(sampler) => Some(Self::Sampler((*sampler).clone())),
            wgpu::BindingResource::Buffer(part) => Some(Self::Buffer(part.buffer.clone(), part.offset, part.size)),
            _ => None,
        }
    }
}

/// A texture, and which of its layers a view shows as what.
pub(super) type ViewKey = (wgpu::Texture, wgpu::TextureViewDimension, std::ops::Range<u32>);

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
    pub(crate) fn stand_in(
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

#[cfg(test)]
mod tests {
    use super::Kept;

    #[test]
    fn what_is_used_stays_and_what_is_not_goes() {
        let mut kept: Kept<Vec<u8>, u32> = Kept::default();
        kept.insert(vec![1], 10);
        kept.insert(vec![2], 20);
        for _ in 0..5 {
            assert_eq!(kept.get([1].as_slice()), Some(10));
            kept.end_frame(3);
        }
        assert_eq!(kept.get([2].as_slice()), None);
        assert_eq!(kept.get([1].as_slice()), Some(10));
        kept.insert(vec![3], 30);
        kept.end_frame(1);
        assert_eq!(kept.get([3].as_slice()), Some(30), "used in the frame that has just ended");
        kept.end_frame(1);
        kept.end_frame(1);
        assert_eq!(kept.get([3].as_slice()), None);
    }
}
