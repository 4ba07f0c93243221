//! Declaring a frame: resources, and the passes that read and write them.

use std::collections::HashSet;
use std::hash::Hash;
use std::sync::atomic::{AtomicU64, Ordering};

use super::cache::Target;
use super::context::PassContext;
use super::desc::{BufferDesc, ResourceDesc, TextureDesc};
use super::error::{GraphError, PassError};
use super::handle::{Buffer, Handle, Kind, PassId, Texture, Version};
use super::key::{Key, hash};

/// The work of a pass.
pub(super) type Work<'a> = Box<dyn FnOnce(&mut PassContext<'_>) -> Result<(), PassError> + 'a>;

/// Where the memory of a resource comes from.
pub(super) enum Storage {
    /// Pooled, for this frame.
    Transient,
    /// Kept in the cache under its name.
    Retained,
    /// The caller's. CPU tests have none.
    Imported { content: Option<u64>, target: Option<Target> },
}

pub(super) struct ResourceNode {
    pub name: String,
    pub desc: ResourceDesc,
    pub storage: Storage,
    /// `writers[n]` is the pass that writes version n + 1.
    pub writers: Vec<usize>,
}

impl ResourceNode {
    /// Whether a version has content: it was written, or is an import.
    pub fn has_content(&self, number: usize) -> bool {
        number > 0 || matches!(self.storage, Storage::Imported { .. })
    }
}

pub(super) struct PassNode<'a> {
    pub name: String,
    pub reads: Vec<Version>,
    /// The versions that it overwrites; it makes the next one of each.
    pub writes: Vec<Version>,
    pub key: Key,
    pub work: Option<Work<'a>>,
}

/// One frame: what there is to do, and on what. It lives for one frame; what is kept over frames
/// lives in the [`TargetCache`](super::TargetCache). `'a` is what the passes borrow.
pub struct Graph<'a> {
    pub(super) id: u64,
    pub(super) seed: u64,
    pub(super) resources: Vec<ResourceNode>,
    pub(super) passes: Vec<PassNode<'a>>,
    pub(super) orders: Vec<(usize, usize)>,
    pub(super) skipped: Vec<(String, String)>,
    pub(super) warnings: Vec<String>,
    /// Names of passes and of skipped ones.
    names: HashSet<String>,
    pub(super) outputs: Vec<Version>,
    /// Mistakes made while declaring; compilation returns the first.
    pub(super) errors: Vec<GraphError>,
}

impl<'a> Graph<'a> {
    /// An empty graph. The `seed` is part of every content key: a hash of what all passes depend
    /// on, such as the revision of the shaders.
    pub fn new(seed: u64) -> Self {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        let id = NEXT.fetch_add(1, Ordering::Relaxed);
        Self {
            id,
            seed,
            resources: Vec::new(),
            passes: Vec::new(),
            orders: Vec::new(),
            skipped: Vec::new(),
            warnings: Vec::new(),
            names: HashSet::new(),
            outputs: Vec::new(),
            errors: Vec::new(),
        }
    }

    /// A texture for this frame only.
    pub fn texture(&mut self, name: impl Into<String>, desc: TextureDesc) -> Handle<Texture> {
        self.declare(name.into(), desc.into(), Storage::Transient)
    }

    /// A buffer for this frame only.
    pub fn buffer(&mut self, name: impl Into<String>, desc: BufferDesc) -> Handle<Buffer> {
        self.declare(name.into(), desc.into(), Storage::Transient)
    }

    /// A texture whose content is kept in the cache under its name, and reused as long as nothing
    /// that it depends on changes.
    pub fn retained_texture(&mut self, name: impl Into<String>, desc: TextureDesc) -> Handle<Texture> {
        self.declare(name.into(), desc.into(), Storage::Retained)
    }

    /// A buffer whose content is kept, as for [`Graph::retained_texture`].
    pub fn retained_buffer(&mut self, name: impl Into<String>, desc: BufferDesc) -> Handle<Buffer> {
        self.declare(name.into(), desc.into(), Storage::Retained)
    }

    /// A texture of the caller's. `content` is a key of what is in it, `None` if that may change
    /// with every frame. If passes write it, the caller gives another key for what they left.
    pub fn import_texture(
        &mut self,
        name: impl Into<String>,
        texture: wgpu::Texture,
        content: Option<u64>,
    ) -> Handle<Texture> {
        let desc = TextureDesc::of(&texture).into();
        let target = Some(Target::of_texture(texture, None));
        self.declare(name.into(), desc, Storage::Imported { content, target })
    }

    /// A buffer of the caller's, as for [`Graph::import_texture`].
    pub fn import_buffer(
        &mut self,
        name: impl Into<String>,
        buffer: wgpu::Buffer,
        content: Option<u64>,
    ) -> Handle<Buffer> {
        let desc = BufferDesc::of(&buffer).into();
        let target = Some(Target::Buffer(buffer));
        self.declare(name.into(), desc, Storage::Imported { content, target })
    }

    /// Starts the declaration of a pass. Its name is its debug label and its timer.
    pub fn pass(&mut self, name: impl Into<String>) -> PassBuilder<'_, 'a> {
        let name = name.into();
        self.check_pass_name(&name);
        self.passes.push(PassNode { name, reads: Vec::new(), writes: Vec::new(), key: None, work: None });
        let index = self.passes.len() - 1;
        PassBuilder { graph: self, index }
    }

    /// Says that a pass was left out, and why, for the report.
    pub fn skip(&mut self, name: impl Into<String>, reason: impl Into<String>) {
        let name = name.into();
        self.check_pass_name(&name);
        self.skipped.push((name, reason.into()));
    }

    /// Says that something which the scene asks for does not show in the frame: which entity's, why, and what to do. For
    /// [`FrameReport::warnings`](super::FrameReport::warnings).
    pub fn warn(&mut self, warning: impl Into<String>) {
        self.warnings.push(warning.into());
    }

    /// The warnings so far.
    pub fn take_warnings(&mut self) -> Vec<String> {
        std::mem::take(&mut self.warnings)
    }

    /// Lets `before` run before `after`, if both run.
    pub fn order(&mut self, before: PassId, after: PassId) {
        if before.graph != self.id || after.graph != self.id {
            return self.errors.push(GraphError::ForeignHandle { place: "`order`".into() });
        }
        self.orders.push((before.index, after.index));
    }

    /// Wants a version at the end of the frame. A graph without outputs does nothing.
    pub fn output<K: Kind>(&mut self, handle: Handle<K>) {
        if handle.graph != self.id {
            return self.errors.push(GraphError::ForeignHandle { place: "`output`".into() });
        }
        let resource = &self.resources[handle.at.resource];
        if !resource.has_content(handle.at.number) {
            let resource = resource.name.clone();
            return self.errors.push(GraphError::OutputNeverWritten { resource });
        }
        self.outputs.push(handle.at);
    }

    /// The description of a texture, with the usages that the graph adds; `None` for a handle of
    /// another graph.
    pub fn texture_desc(&self, handle: Handle<Texture>) -> Option<&TextureDesc> {
        if handle.graph != self.id {
            return None;
        }
        match &self.resources[handle.at.resource].desc {
            ResourceDesc::Texture(desc) => Some(desc),
            ResourceDesc::Buffer(_) => None,
        }
    }

    /// Size of a buffer \[bytes\]; 0 for a handle of another graph.
    pub fn buffer_bytes(&self, handle: Handle<Buffer>) -> u64 {
        match self.resources.get(handle.at.resource).filter(|_| handle.graph == self.id).map(|resource| &resource.desc)
        {
            Some(ResourceDesc::Buffer(desc)) => desc.size,
            _ => 0,
        }
    }

    /// The last version so far of what bears this name; none if there is no such resource with content. For tools,
    /// which look at what other passes made.
    pub fn latest<K: Kind>(&self, name: &str) -> Option<Handle<K>> {
        let index = self.resources.iter().position(|resource| resource.name == name)?;
        let resource = &self.resources[index];
        let number = resource.writers.len();
        let fits = resource.has_content(number) && K::IS_TEXTURE == matches!(resource.desc, ResourceDesc::Texture(_));
        fits.then(|| Handle::new(self.id, Version { resource: index, number }))
    }

    pub(super) fn declare<K: Kind>(&mut self, name: String, desc: ResourceDesc, storage: Storage) -> Handle<K> {
        if self.resources.iter().any(|resource| resource.name == name) {
            self.errors.push(GraphError::DuplicateResource { resource: name.clone() });
        }
        if let Some(fault) = desc.fault() {
            self.errors.push(GraphError::BadDesc { resource: name.clone(), fault });
        }
        let desc = match storage {
            Storage::Transient => desc.with_graph_usages(false),
            Storage::Retained => desc.with_graph_usages(true),
            Storage::Imported { .. } => desc,
        };
        self.resources.push(ResourceNode { name, desc, storage, writers: Vec::new() });
        Handle::new(self.id, Version { resource: self.resources.len() - 1, number: 0 })
    }

    /// All versions that a pass needs: what it reads, then what it modifies in place.
    pub(super) fn inputs(&self, pass: usize) -> impl Iterator<Item = Version> {
        let pass = &self.passes[pass];
        let modified = pass.writes.iter().filter(|at| self.resources[at.resource].has_content(at.number));
        pass.reads.iter().chain(modified).copied()
    }

    /// The pass that wrote a version, if any.
    pub(super) fn writer(&self, version: Version) -> Option<usize> {
        let writers = &self.resources[version.resource].writers;
        writers.get(version.number.checked_sub(1)?).copied()
    }

    /// The pass that overwrites a version, if any.
    pub(super) fn overwriter(&self, version: Version) -> Option<usize> {
        self.resources[version.resource].writers.get(version.number).copied()
    }

    fn check_pass_name(&mut self, name: &str) {
        if !self.names.insert(name.to_owned()) {
            self.errors.push(GraphError::DuplicatePass { pass: name.into() });
        }
    }
}

/// A pass being declared.
pub struct PassBuilder<'g, 'a> {
    graph: &'g mut Graph<'a>,
    index: usize,
}

impl<'a> PassBuilder<'_, 'a> {
    /// The pass, for [`Graph::order`].
    pub fn id(&self) -> PassId {
        PassId { graph: self.graph.id, index: self.index }
    }

    /// Its name.
    pub(super) fn name(&self) -> &str {
        &self.graph.passes[self.index].name
    }

    /// Reads a version, which must have been written. The pass runs after the one that wrote it, and again where that content
    /// changes. A version that is read twice counts once.
    pub fn read<K: Kind>(&mut self, handle: Handle<K>) {
        if self.is_foreign(handle) {
            return;
        }
        let resource = &self.graph.resources[handle.at.resource];
        if !resource.has_content(handle.at.number) {
            let resource = resource.name.clone();
            let pass = self.node().name.clone();
            return self.graph.errors.push(GraphError::ReadBeforeWrite { pass, resource });
        }
        if !self.node().reads.contains(&handle.at) {
            self.node().reads.push(handle.at);
        }
    }

    /// Writes a resource and returns its next version. If the version given has content, the pass
    /// modifies it in place: its content is kept, and the new one depends on it.
    #[must_use = "later passes read the version that this returns; assign to `_` if there is none"]
    pub fn write<K: Kind>(&mut self, handle: Handle<K>) -> Handle<K> {
        if self.is_foreign(handle) {
            return handle;
        }
        let next = Handle::new(self.graph.id, handle.at.next());
        if let Some(first) = self.graph.overwriter(handle.at) {
            let error = GraphError::DoubleWrite {
                resource: self.graph.resources[handle.at.resource].name.clone(),
                first: self.graph.passes[first].name.clone(),
                second: self.node().name.clone(),
            };
            self.graph.errors.push(error);
            return next;
        }
        self.graph.resources[handle.at.resource].writers.push(self.index);
        self.node().writes.push(handle.at);
        next
    }

    /// States what the output depends on besides what the pass reads; may be called several times.
    /// A pass that never calls it is volatile: it runs in every frame, and so does all that
    /// depends on it. A pass that depends on nothing else states `&()`.
    pub fn key(&mut self, value: &impl Hash) {
        let chained = hash(&(self.node().key, hash(value)));
        self.node().key = Some(chained);
    }

    /// Gives the pass its work and ends its declaration.
    pub fn execute(mut self, work: impl FnOnce(&mut PassContext<'_>) -> Result<(), PassError> + 'a) -> PassId {
        self.node().work = Some(Box::new(work));
        self.id()
    }

    /// Whether the pass itself makes that version.
    pub(super) fn is_written<K: Kind>(&self, handle: Handle<K>) -> bool {
        let pass = &self.graph.passes[self.index];
        handle.graph == self.graph.id && pass.writes.iter().any(|write| write.next() == handle.at)
    }

    /// Name of a resource of this graph.
    pub(super) fn resource_name<K: Kind>(&self, handle: Handle<K>) -> Option<&str> {
        let resource = self.graph.resources.get(handle.at.resource).filter(|_| handle.graph == self.graph.id);
        resource.map(|resource| resource.name.as_str())
    }

    fn node(&mut self) -> &mut PassNode<'a> {
        &mut self.graph.passes[self.index]
    }

    fn is_foreign<K: Kind>(&mut self, handle: Handle<K>) -> bool {
        let foreign = handle.graph != self.graph.id;
        if foreign {
            let place = format!("pass `{}`", self.node().name);
            self.graph.errors.push(GraphError::ForeignHandle { place });
        }
        foreign
    }
}
