//! The target cache (thesis 6.6.2): memory of transient targets, and the content of retained ones.
//!
//! Its bookkeeping knows nothing of the device: `P` is whatever stands for a piece of memory.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use super::audit::Audited;
use super::cost::Costs;
use super::desc::ResourceDesc;
use super::frame_pacing::FramePacing;
use super::key::{Key, Recipe};
use super::plan::{Layout, Place, PlannedResource};
use super::timer::{PassTimer, Timing};

/// A piece of memory on the device.
#[derive(Clone, Debug)]
pub enum Target {
    /// A texture and its default view.
    Texture(wgpu::Texture, wgpu::TextureView),
    /// A buffer.
    Buffer(wgpu::Buffer),
}

impl Target {
    pub(super) fn of_texture(texture: wgpu::Texture, dimension: Option<wgpu::TextureViewDimension>) -> Self {
        let view = texture.create_view(&wgpu::TextureViewDescriptor { dimension, ..Default::default() });
        Self::Texture(texture, view)
    }
}

/// The state of a retained resource between frames.
pub(super) struct Slot<P> {
    pub desc: ResourceDesc,
    pub memory: P,
    /// The content key of the version in it; `None` if that is volatile or unfinished.
    pub content: Key,
    /// How each version up to that one was made.
    pub recipes: Vec<Recipe>,
    last_used: u64,
}

struct Pooled<P> {
    desc: ResourceDesc,
    memory: P,
    last_used: u64,
}

/// The contents of the cache.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CacheFigures {
    /// Memory of retained resources \[bytes\].
    pub retained_bytes: u64,
    /// Memory that transient resources share \[bytes\].
    pub pooled_bytes: u64,
    /// Number of retained resources.
    pub retained: usize,
    /// Number of pieces of shared memory.
    pub pooled: usize,
    /// Pieces of memory that the last frame made.
    pub created: usize,
    /// Pieces of memory that the last frame let go.
    pub evicted: usize,
}

/// Targets that outlive the frame: retained ones by name with their content, and a pool of
/// memory for transient ones by description.
pub struct TargetCache<P = Target> {
    slots: BTreeMap<String, Slot<P>>,
    pool: Vec<Pooled<P>>,
    frame: u64,
    keep_frames: u64,
    /// Changes whenever the content does, so that an outdated plan is noticed.
    stamp: u64,
    created: usize,
    evicted: usize,
    pub(super) audit: Option<Audited>,
    pub(super) pacing: Option<Arc<FramePacing>>,
    pub(super) timer: PassTimer,
    pub(super) costs: Costs,
}

/// Frames for which unused memory is kept.
const KEEP_FRAMES: u64 = 8;

impl TargetCache {
    /// An empty cache that keeps unused memory for 8 frames.
    pub fn new() -> Self {
        Self::with_keep_frames(KEEP_FRAMES)
    }

    /// The texture of a retained resource, as the last frame left it.
    pub fn texture(&self, name: &str) -> Option<&wgpu::Texture> {
        match &self.slots.get(name)?.memory {
            Target::Texture(texture, _) => Some(texture),
            Target::Buffer(_) => None,
        }
    }

    /// The default view of a retained texture.
    pub fn view(&self, name: &str) -> Option<&wgpu::TextureView> {
        match &self.slots.get(name)?.memory {
            Target::Texture(_, view) => Some(view),
            Target::Buffer(_) => None,
        }
    }

    /// The buffer of a retained resource, as the last frame left it.
    pub fn buffer(&self, name: &str) -> Option<&wgpu::Buffer> {
        match &self.slots.get(name)?.memory {
            Target::Buffer(buffer) => Some(buffer),
            Target::Texture(..) => None,
        }
    }

    /// Sets when reports tell the times of passes on the device; [`Timing::Exact`] by default.
    pub fn set_timing(&mut self, timing: Timing) {
        self.timer.timing = timing;
    }

    /// Sets whether frames are audited: every pass runs, whatever the cache holds, and one that binds something else
    /// than it did under the same key fails with [`GraphError::Key`](super::GraphError::Key). For tests and for whoever
    /// writes a pass: a key that misses an input shows as soon as that input changes, even if no pixel does.
    pub fn set_audit(&mut self, audit: bool) {
        self.audit = audit.then(Audited::default);
    }

    /// Whether frames are audited.
    pub fn is_audited(&self) -> bool {
        self.audit.is_some()
    }

    /// Sets what frames are paced by; none: they are submitted as one.
    pub fn set_pacing(&mut self, pacing: Option<Arc<FramePacing>>) {
        self.pacing = pacing;
    }
}

impl Default for TargetCache {
    fn default() -> Self {
        Self::new()
    }
}

impl<P: Clone> TargetCache<P> {
    /// An empty cache that lets go what was not used for so many frames in a row (at least 1).
    pub fn with_keep_frames(frames: u64) -> Self {
        Self {
            slots: BTreeMap::new(),
            pool: Vec::new(),
            frame: 0,
            keep_frames: frames.max(1),
            stamp: next_stamp(),
            created: 0,
            evicted: 0,
            audit: None,
            pacing: None,
            timer: PassTimer::default(),
            costs: Costs::default(),
        }
    }

    /// Forgets the content of a retained resource: what makes it runs again.
    pub fn invalidate(&mut self, name: &str) {
        self.stamp = next_stamp();
        self.unmark(name);
    }

    /// Lets go of everything, as after the loss of the device.
    pub fn clear(&mut self) {
        let timing = self.timer.timing;
        *self = Self::with_keep_frames(self.keep_frames);
        self.timer.timing = timing;
    }

    /// Its contents.
    pub fn figures(&self) -> CacheFigures {
        CacheFigures {
            retained_bytes: self.slots.values().map(|slot| slot.desc.bytes()).sum(),
            pooled_bytes: self.pool.iter().map(|piece| piece.desc.bytes()).sum(),
            retained: self.slots.len(),
            pooled: self.pool.len(),
            created: self.created,
            evicted: self.evicted,
        }
    }

    pub(super) fn slot(&self, name: &str) -> Option<&Slot<P>> {
        self.slots.get(name)
    }

    pub(super) fn stamp(&self) -> u64 {
        self.stamp
    }

    /// Begins a frame: finds or makes memory for all resources, in their order. Imports, and
    /// transients that nobody uses, get none.
    pub(super) fn begin_frame(
        &mut self,
        layout: &Layout,
        make: &mut dyn FnMut(&ResourceDesc, &str) -> P,
    ) -> Vec<Option<P>> {
        self.frame += 1;
        self.stamp = next_stamp();
        (self.created, self.evicted) = (0, 0);
        let shared: Vec<P> = layout.shared.iter().map(|desc| self.take_pooled(desc, make)).collect();
        let place = |resource: &PlannedResource| match resource.place {
            Place::Shared(piece) => piece.map(|piece| shared[piece].clone()),
            Place::Slot { written } => self.take_slot(resource, written, make),
            Place::Imported(_) => None,
        };
        layout.resources.iter().map(place).collect()
    }

    /// Marks the content of a slot as unfinished while a pass writes it.
    pub(super) fn begin_write(&mut self, name: &str) {
        self.unmark(name);
    }

    /// Records what a pass has made: version `number` by `recipe`.
    pub(super) fn end_write(&mut self, name: &str, number: usize, key: Key, recipe: &Recipe) {
        if let Some(slot) = self.slots.get_mut(name) {
            slot.content = key;
            slot.recipes.truncate(number - 1);
            slot.recipes.push(recipe.clone());
        }
    }

    /// Ends a frame: lets go what was not used for too long.
    pub(super) fn end_frame(&mut self) {
        let before = self.slots.len() + self.pool.len();
        let keep = |last_used: u64| self.frame - last_used < self.keep_frames;
        self.slots.retain(|_, slot| keep(slot.last_used));
        self.pool.retain(|piece| keep(piece.last_used));
        self.evicted += before - self.slots.len() - self.pool.len();
    }

    /// Lets go of all that the frame wrote: some of that memory may not even have been made.
    pub(super) fn drop_frame(&mut self, written: &[String]) {
        self.stamp = next_stamp();
        written.iter().for_each(|name| drop(self.slots.remove(name)));
        self.pool.retain(|piece| piece.last_used != self.frame);
    }

    fn unmark(&mut self, name: &str) {
        if let Some(slot) = self.slots.get_mut(name) {
            slot.content = None;
        }
    }

    fn take_pooled(&mut self, desc: &ResourceDesc, make: &mut dyn FnMut(&ResourceDesc, &str) -> P) -> P {
        let frame = self.frame;
        if let Some(piece) = self.pool.iter_mut().find(|piece| piece.last_used != frame && piece.desc == *desc) {
            piece.last_used = frame;
            return piece.memory.clone();
        }
        let memory = make(desc, &format!("shared {desc}"));
        self.created += 1;
        self.pool.push(Pooled { desc: desc.clone(), memory: memory.clone(), last_used: frame });
        memory
    }

    fn take_slot(
        &mut self,
        resource: &PlannedResource,
        written: bool,
        make: &mut dyn FnMut(&ResourceDesc, &str) -> P,
    ) -> Option<P> {
        let PlannedResource { name, desc, .. } = resource;
        if self.slots.get(name).is_some_and(|slot| slot.desc != *desc) {
            self.slots.remove(name);
            self.evicted += 1;
        }
        if written && !self.slots.contains_key(name) {
            let memory = make(desc, name);
            self.created += 1;
            let slot = Slot { desc: desc.clone(), memory, content: None, recipes: Vec::new(), last_used: 0 };
            self.slots.insert(name.clone(), slot);
        }
        let slot = self.slots.get_mut(name)?;
        slot.last_used = self.frame;
        Some(slot.memory.clone())
    }
}

/// Stamps differ between caches too, so that a plan does not run with another cache.
fn next_stamp() -> u64 {
    static NEXT: AtomicU64 = AtomicU64::new(0);
    NEXT.fetch_add(1, Ordering::Relaxed)
}
