//! Uniforms, constants and bind groups that are kept over frames: what has not changed is neither uploaded nor bound
//! anew.

use std::collections::HashMap;
use std::hash::Hash;

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
    pub(super) fn end_frame(&mut self, keep: u64) {
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
