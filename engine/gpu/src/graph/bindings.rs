//! Bindings of passes by name: each input is named once, and its part of the content key follows from that.

use super::builder::PassBuilder;
use super::context::PassContext;
use super::handle::{Buffer, Handle, Kind, Texture};
use super::key::hash;
use crate::gpu::{BindError, Binding, Gpu, Pipeline, ShaderDef, constants_bytes, uniform_bytes};
use bytemuck::Pod;
use encase::ShaderType;
use encase::internal::WriteInto;
use std::hash::Hash;
use wgpu::BufferUsages;

/// Resources outside the graph that many shaders bind together, as their group 1.
pub trait SharedGroup {
    /// Changes with the content of what is bound.
    fn key(&self) -> u64;

    /// Binds them to a pipeline.
    ///
    /// # Errors
    /// If they do not fit what the shader declares.
    fn bind(&self, gpu: &Gpu, pipeline: &Pipeline) -> Result<wgpu::BindGroup, BindError>;
}

/// A buffer or texture outside the graph, with a key of its content.
#[derive(Clone, Copy, Debug)]
pub struct Tracked<'a> {
    resource: Outside<'a>,
    key: u64,
}

#[derive(Clone, Copy, Debug)]
enum Outside<'a> {
    Buffer(&'a wgpu::Buffer),
    Texture(&'a wgpu::TextureView),
}

impl<'a> Tracked<'a> {
    /// A buffer whose content is the same as long as `revision` is.
    pub fn buffer(buffer: &'a wgpu::Buffer, revision: &impl Hash) -> Self {
        Self { resource: Outside::Buffer(buffer), key: hash(revision) }
    }

    /// A texture whose content is the same as long as `revision` is.
    pub fn texture(view: &'a wgpu::TextureView, revision: &impl Hash) -> Self {
        Self { resource: Outside::Texture(view), key: hash(revision) }
    }
}

/// An input that a shader binds under a name.
enum Input<'a> {
    Texture(Handle<Texture>),
    Layers(Handle<Texture>),
    Buffer(Handle<Buffer>),
    Values(BufferUsages, Vec<u8>),
    Later(BufferUsages, Box<dyn FnOnce() -> Vec<u8> + 'a>),
    Outside(Outside<'a>),
    Sampler(wgpu::SamplerDescriptor<'static>),
    StandIn(fn(&Gpu) -> wgpu::TextureView),
    Part(Handle<Texture>, Box<wgpu::TextureViewDescriptor<'static>>),
}

/// Inputs by the names that shaders have for them.
pub(super) type Inputs<'a> = Vec<(&'static str, BoundLater<'a>)>;

/// An input whose resource exists once the pass runs.
pub(super) struct BoundLater<'a>(Input<'a>);

/// The bindings of a pass that is being declared. All of them go into its content key: resources of the graph with their
/// versions, uniforms with their bytes, the rest with the revisions that it comes with. The names are those of the shader's
/// group 0.
pub struct PassBindings<'g, 'a> {
    pub(super) pass: PassBuilder<'g, 'a>,
    pub(super) inputs: Inputs<'a>,
    pub(super) defines: Vec<(&'static str, ShaderDef)>,
    pub(super) shared: Option<Box<dyn SharedGroup + 'a>>,
    pub(super) refusal: Option<&'static str>,
}

impl<'g, 'a> PassBindings<'g, 'a> {
    pub(super) fn new(pass: PassBuilder<'g, 'a>) -> Self {
        Self { pass, inputs: Vec::new(), defines: Vec::new(), shared: None, refusal: None }
    }

    /// Defines a name for the shader.
    pub fn define(&mut self, name: &'static str, value: ShaderDef) {
        self.defines.push((name, value));
    }

    /// Defines a name as a flag, if it is set.
    pub fn flag(&mut self, name: &'static str, is_set: bool) {
        if is_set {
            self.define(name, ShaderDef::Flag(true));
        }
    }

    /// Reads a version of a texture or buffer. A version that the pass writes itself may be bound once more, to another step
    /// or under another name.
    pub fn read<K: Kind>(&mut self, name: &'static str, handle: Handle<K>) {
        self.read_unless_written(handle);
        self.bind_resource(name, handle, input(handle));
    }

    /// Reads a version of a texture, all layers of it, whose view is an array also where there is one layer.
    pub fn read_layers(&mut self, name: &'static str, handle: Handle<Texture>) {
        self.read_unless_written(handle);
        self.bind_resource(name, handle, Input::Layers(handle));
    }

    /// Reads a version that draws bind by themselves.
    pub fn read_in_draws<K: Kind>(&mut self, handle: Handle<K>) {
        self.pass.read(handle);
    }

    /// Reads a version of a texture, a part of it.
    pub fn read_part(
        &mut self,
        name: &'static str,
        handle: Handle<Texture>,
        part: wgpu::TextureViewDescriptor<'static>,
    ) {
        self.read_unless_written(handle);
        self.pass.key(&format!("{part:?}"));
        self.bind_resource(name, handle, Input::Part(handle, Box::new(part)));
    }

    /// Writes a texture or buffer and returns its next version, as [`PassBuilder::write`].
    #[must_use = "later passes read the version that this returns; assign to `_` if there is none"]
    pub fn write<K: Kind>(&mut self, name: &'static str, handle: Handle<K>) -> Handle<K> {
        let written = self.pass.write(handle);
        self.bind_resource(name, written, input(written));
        written
    }

    /// As [`PassBindings::write`], of all layers of a texture, whose view is an array also where there is one layer.
    #[must_use = "later passes read the version that this returns; assign to `_` if there is none"]
    pub fn write_layers(&mut self, name: &'static str, handle: Handle<Texture>) -> Handle<Texture> {
        let written = self.pass.write(handle);
        self.bind_resource(name, written, Input::Layers(written));
        written
    }

    /// As [`PassBindings::write`], of a resource that steps bind under names of their own, by
    /// [`read`](PassBindings::read).
    #[must_use = "steps bind the version that this returns"]
    pub fn write_in_steps<K: Kind>(&mut self, handle: Handle<K>) -> Handle<K> {
        self.pass.write(handle)
    }

    /// Binds a uniform with that value.
    pub fn uniform<T: ShaderType + WriteInto>(&mut self, name: &'static str, value: &T) {
        self.bind_values(name, BufferUsages::UNIFORM, uniform_bytes(name, value));
    }

    /// As [`PassBindings::uniform`], of a value that is known when the pass runs: the same as long as `revision` is, or what
    /// the pass reads.
    pub fn uniform_of<T: ShaderType + WriteInto>(
        &mut self,
        name: &'static str,
        revision: &impl Hash,
        value: impl FnOnce() -> T + 'a,
    ) {
        self.pass.key(&(name, hash(revision)));
        self.bind(name, Input::Later(BufferUsages::UNIFORM, Box::new(move || uniform_bytes(name, &value()))));
    }

    /// Binds a storage buffer that holds those values, for the shader to read.
    pub fn values<T: Pod>(&mut self, name: &'static str, values: &[T]) {
        self.bind_values(name, BufferUsages::STORAGE, bytemuck::cast_slice(values).to_vec());
    }

    /// As [`PassBindings::values`] of what takes long to put together: the same as long as `revision` is.
    pub fn values_of<T: Pod>(
        &mut self,
        name: &'static str,
        revision: &impl Hash,
        values: impl FnOnce() -> Vec<T> + 'a,
    ) {
        self.pass.key(&(name, hash(revision)));
        let bytes = move || bytemuck::cast_slice(&values()).to_vec();
        self.bind(name, Input::Later(BufferUsages::STORAGE, Box::new(bytes)));
    }

    /// Binds a storage buffer that holds those structs in the layout of WGSL, for the shader to read.
    pub fn constants<T>(&mut self, name: &'static str, values: &[T])
    where
        for<'v> &'v [T]: ShaderType + WriteInto,
    {
        self.bind_values(name, BufferUsages::STORAGE, constants_bytes(name, values));
    }

    /// Binds a buffer or texture outside the graph.
    pub fn tracked(&mut self, name: &'static str, tracked: Tracked<'a>) {
        self.pass.key(&(name, tracked.key));
        self.bind(name, Input::Outside(tracked.resource));
    }

    /// Binds a sampler.
    pub fn sampler(&mut self, name: &'static str, descriptor: wgpu::SamplerDescriptor<'static>) {
        self.pass.key(&(name, format!("{descriptor:?}")));
        self.bind(name, Input::Sampler(descriptor));
    }

    /// Binds a texture that is always the same, such as one that stands in where there is none.
    pub fn stand_in(&mut self, name: &'static str, view: fn(&Gpu) -> wgpu::TextureView) {
        self.bind(name, Input::StandIn(view));
    }

    /// Binds the shader's group 1, that of all steps. Raster passes have none.
    pub fn share(&mut self, group: impl SharedGroup + 'a) {
        self.pass.key(&group.key());
        self.shared = Some(Box::new(group));
    }

    /// States what the output depends on besides what the pass binds: state that outlives the frame, such as what the targets
    /// hold already of which the pass overwrites a part.
    pub fn depends_on(&mut self, state: &impl Hash) {
        self.pass.key(&("state", hash(state)));
    }

    /// Lets the pass fail when it is to run, and says why.
    pub fn refuse(&mut self, why: &'static str) {
        self.refusal = Some(why);
    }

    pub(super) fn read_unless_written<K: Kind>(&mut self, handle: Handle<K>) {
        if !self.pass.is_written(handle) {
            self.pass.read(handle);
        }
    }

    fn bind(&mut self, name: &'static str, input: Input<'a>) {
        self.inputs.push((name, BoundLater(input)));
    }

    fn bind_values(&mut self, name: &'static str, usage: BufferUsages, bytes: Vec<u8>) {
        self.pass.key(&(name, &bytes));
        self.bind(name, Input::Values(usage, bytes));
    }

    /// The key of a pass holds the versions that it reads; here it takes in under which name.
    fn bind_resource<K: Kind>(&mut self, name: &'static str, handle: Handle<K>, input: Input<'a>) {
        let key = (name, self.pass.resource_name(handle).map(str::to_owned));
        self.pass.key(&key);
        self.bind(name, input);
    }
}

fn input<'a, K: Kind>(handle: Handle<K>) -> Input<'a> {
    if K::IS_TEXTURE { Input::Texture(handle.cast()) } else { Input::Buffer(handle.cast()) }
}

/// A resource that is bound, alive as long as it takes.
pub(super) enum Bound {
    View(wgpu::TextureView),
    Buffer(wgpu::Buffer),
    Sampler(wgpu::Sampler),
}

impl Bound {
    pub(super) fn uniform(gpu: &Gpu, name: &str, bytes: Vec<u8>) -> Self {
        Self::Buffer(gpu.kept(name, bytes, BufferUsages::UNIFORM))
    }

    pub(super) fn binding(&self) -> Binding<'_> {
        match self {
            Self::View(view) => Binding::Texture(view),
            Self::Buffer(buffer) => Binding::Buffer(buffer),
            Self::Sampler(sampler) => Binding::Sampler(sampler),
        }
    }
}

/// The resources of inputs in a running pass.
pub(super) fn bound(cx: &PassContext, inputs: Inputs) -> Vec<(&'static str, Bound)> {
    inputs.into_iter().map(|(name, BoundLater(input))| (name, input.bound(cx, name))).collect()
}

/// The entries of a bind group.
pub(super) fn bindings<'b>(bound: &'b [(&'static str, Bound)]) -> Vec<(&'static str, Binding<'b>)> {
    bound.iter().map(|(name, bound)| (*name, bound.binding())).collect()
}

impl Input<'_> {
    fn bound(self, cx: &PassContext, name: &str) -> Bound {
        let gpu = cx.gpu;
        match self {
            Self::Texture(handle) => Bound::View(cx.view(handle)),
            Self::Layers(handle) => {
                let texture = cx.texture(handle);
                let layers = 0..texture.depth_or_array_layers();
                Bound::View(gpu.view_of_layers(texture, wgpu::TextureViewDimension::D2Array, layers))
            }
            Self::Buffer(handle) => Bound::Buffer(cx.buffer(handle).clone()),
            Self::Values(usage, bytes) => Bound::Buffer(gpu.kept(name, bytes, usage)),
            Self::Later(usage, bytes) => Bound::Buffer(gpu.kept(name, bytes(), usage)),
            Self::Outside(Outside::Buffer(buffer)) => Bound::Buffer(buffer.clone()),
            Self::Outside(Outside::Texture(view)) => Bound::View(view.clone()),
            Self::Sampler(descriptor) => Bound::Sampler(gpu.sampler(&descriptor)),
            Self::StandIn(view) => Bound::View(view(gpu)),
            Self::Part(handle, part) => Bound::View(cx.texture(handle).create_view(&part)),
        }
    }
}
