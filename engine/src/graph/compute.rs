//! Compute passes that name each input once: the content key, the bind group, the workgroups and the counts follow from it.

use super::builder::{Graph, PassBuilder};
use super::context::{Groups, PassContext};
use super::error::PassError;
use super::handle::{Buffer, Handle, Kind, PassId, Texture};
use super::key::hash;
use super::report::Counts;
use crate::gpu::{BindError, Binding, ComputeKey, Gpu, Pipeline, ShaderDef, constants_bytes, uniform_bytes};
use bytemuck::Pod;
use encase::ShaderType;
use encase::internal::WriteInto;
use std::hash::Hash;

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

/// A resource or value that a shader binds under a name.
enum Input<'a> {
    Texture(Handle<Texture>),
    Layers(Handle<Texture>),
    Buffer(Handle<Buffer>),
    Uniform(Vec<u8>),
    Constants(Vec<u8>),
    Later(Box<dyn FnOnce() -> Vec<u8> + 'a>),
    Outside(Outside<'a>),
    Sampler(wgpu::SamplerDescriptor<'static>),
    StandIn(fn(&Gpu) -> wgpu::TextureView),
}

/// A compute pass of one dispatch that is being declared. All that it binds goes into its content key: resources of the graph
/// with their versions, uniforms with their bytes, the rest with the revisions that it comes with. The names are those of
/// the shader's group 0.
pub struct ComputeBuilder<'g, 'a> {
    pass: PassBuilder<'g, 'a>,
    shader: ComputeKey,
    inputs: Vec<(&'static str, Input<'a>)>,
    shared: Option<Box<dyn SharedGroup + 'a>>,
    counts: Counts,
}

impl<'a> Graph<'a> {
    /// Starts the declaration of a compute pass of one dispatch. Its name is its debug label and its timer.
    pub fn compute(&mut self, name: impl Into<String>, shader: ComputeKey) -> ComputeBuilder<'_, 'a> {
        let pass = self.pass(name);
        ComputeBuilder { pass, shader, inputs: Vec::new(), shared: None, counts: Counts::default() }
    }
}

impl<'a> ComputeBuilder<'_, 'a> {
    /// Defines a name for the shader.
    pub fn define(&mut self, name: &'static str, value: ShaderDef) {
        self.shader.defs.push((name, value));
    }

    /// Reads a version of a texture or buffer.
    pub fn read<K: Kind>(&mut self, name: &'static str, handle: Handle<K>) {
        self.pass.read(handle);
        self.bind_resource(name, handle, input(handle));
    }

    /// Reads a version of a texture, all layers of it, whose view is an array also where there is one layer.
    pub fn read_layers(&mut self, name: &'static str, handle: Handle<Texture>) {
        self.pass.read(handle);
        self.bind_resource(name, handle, Input::Layers(handle));
    }

    /// Writes a texture or buffer and returns its next version, as [`PassBuilder::write`].
    #[must_use = "later passes read the version that this returns; assign to `_` if there is none"]
    pub fn write<K: Kind>(&mut self, name: &'static str, handle: Handle<K>) -> Handle<K> {
        let written = self.pass.write(handle);
        self.bind_resource(name, written, input(written));
        written
    }

    /// Binds a uniform with that value.
    pub fn uniform<T: ShaderType + WriteInto>(&mut self, name: &'static str, value: &T) {
        let bytes = uniform_bytes(name, value);
        self.pass.key(&(name, &bytes));
        self.bind(name, Input::Uniform(bytes));
    }

    /// Binds a storage buffer that holds those values, for the shader to read.
    pub fn values<T: Pod>(&mut self, name: &'static str, values: &[T]) {
        let bytes = bytemuck::cast_slice(values).to_vec();
        self.pass.key(&(name, &bytes));
        self.bind(name, Input::Constants(bytes));
    }

    /// Like [`ComputeBuilder::values`], for values that are expensive to build: equal revisions mean equal values.
    pub fn values_of<T: Pod>(
        &mut self,
        name: &'static str,
        revision: &impl Hash,
        values: impl FnOnce() -> Vec<T> + 'a,
    ) {
        self.pass.key(&(name, hash(revision)));
        self.bind(name, Input::Later(Box::new(move || bytemuck::cast_slice(&values()).to_vec())));
    }

    /// Binds a storage buffer that holds those structs in the layout of WGSL, for the shader to read.
    pub fn constants<T>(&mut self, name: &'static str, values: &[T])
    where
        for<'v> &'v [T]: ShaderType + WriteInto,
    {
        let bytes = constants_bytes(name, values);
        self.pass.key(&(name, &bytes));
        self.bind(name, Input::Constants(bytes));
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

    /// Binds the shader's group 1.
    pub fn share(&mut self, group: impl SharedGroup + 'a) {
        self.pass.key(&group.key());
        self.shared = Some(Box::new(group));
    }

    /// Adds to what the pass counts besides texels and dispatches.
    pub fn count(&mut self, counts: Counts) {
        self.counts += counts;
    }

    /// Ends the declaration: a thread for each texel of an image, which are counted.
    pub fn dispatch_over(mut self, [width, height]: [u32; 2]) -> PassId {
        self.counts.texels += u64::from(width) * u64::from(height);
        self.dispatch(Threads::Image([width, height, 1]))
    }

    /// Ends the declaration: a thread for each cell of a volume.
    pub fn dispatch_over_volume(self, size: [u32; 3]) -> PassId {
        self.dispatch(Threads::Image(size))
    }

    /// Ends the declaration: a thread for each of so many items, in rows of workgroups where one row would be over the limits
    /// of devices. The shader is to leave those past the last.
    pub fn dispatch_items(self, items: u32) -> PassId {
        self.dispatch(Threads::Items(items))
    }

    /// Ends the declaration: so many workgroups.
    pub fn dispatch_groups(self, groups: [u32; 3]) -> PassId {
        self.dispatch(Threads::Groups(groups))
    }

    /// Ends the declaration: a thread for each texel of an image, in as many submits of whole rows as their work takes.
    /// `uniform` is what the shader binds under that name for some rows.
    pub fn dispatch_rows<T: ShaderType + WriteInto>(
        mut self,
        [width, height]: [u32; 2],
        work: RowWork,
        name: &'static str,
        uniform: impl Fn(Rows) -> T + 'a,
    ) -> PassId {
        self.pass.key(&(name, uniform_bytes(name, &uniform(Rows { first: 0, count: height }))));
        self.counts.texels += u64::from(width) * u64::from(height);
        self.execute(Threads::Image([width, height, 1]), move |cx, run| {
            for rows in work.pieces(cx, height) {
                cx.work(u64::from(rows.count) * work.units, work.on_software)?;
                let uniform = Bound::Buffer(cx.gpu.uniform(name, &uniform(rows)));
                run.dispatch(cx, Some((name, uniform.binding())), Threads::Image([width, rows.count, 1]))?;
            }
            Ok(())
        })
    }

    fn bind(&mut self, name: &'static str, input: Input<'a>) {
        self.inputs.push((name, input));
    }

    /// The key of a pass holds the versions that it reads; here it takes in under which name.
    fn bind_resource<K: Kind>(&mut self, name: &'static str, handle: Handle<K>, input: Input<'a>) {
        let key = (name, self.pass.resource_name(handle).map(str::to_owned));
        self.pass.key(&key);
        self.bind(name, input);
    }

    fn dispatch(self, threads: Threads) -> PassId {
        self.execute(threads, move |cx, run| run.dispatch(cx, None, threads))
    }

    fn execute(
        mut self,
        threads: Threads,
        work: impl FnOnce(&mut PassContext<'_>, &Run<'_, '_>) -> Result<(), PassError> + 'a,
    ) -> PassId {
        self.pass.key(&(&self.shader, threads));
        let Self { pass, shader, inputs, shared, counts } = self;
        pass.execute(move |cx| {
            *cx.counts() += counts;
            let bound: Vec<_> = inputs.into_iter().map(|(name, input)| (name, input.bound(cx, name))).collect();
            let bindings = bound.iter().map(|(name, bound)| (*name, bound.binding())).collect();
            work(cx, &Run { shader: &shader, bindings, shared: shared.as_deref() })
        })
    }
}

/// A shader with what its dispatches have in common.
struct Run<'r, 'a> {
    shader: &'r ComputeKey,
    bindings: Vec<(&'static str, Binding<'r>)>,
    shared: Option<&'r (dyn SharedGroup + 'a)>,
}

impl Run<'_, '_> {
    fn dispatch(&self, cx: &mut PassContext, own: Option<(&str, Binding)>, threads: Threads) -> Result<(), PassError> {
        let bindings: Vec<_> = self.bindings.iter().copied().chain(own).collect();
        let groups = |workgroup| Groups::Count(threads.groups(workgroup));
        match self.shared {
            Some(shared) => {
                let bind = |gpu: &Gpu, pipeline: &Pipeline| shared.bind(gpu, pipeline);
                cx.dispatch_threads(self.shader, &bindings, Some(&bind), groups)
            }
            None => cx.dispatch_threads(self.shader, &bindings, None, groups),
        }
    }
}

/// Some rows of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rows {
    /// The first of them.
    pub first: u32,
    /// How many there are.
    pub count: u32,
}

/// How much work a row of an image is, so that no submit takes too long.
#[derive(Clone, Copy, Debug)]
pub struct RowWork {
    /// Units of work, such as rays, of a row.
    pub units: u64,
    /// Units that a submit of a software driver may hold, see [`PassContext::work_a_submit`].
    pub on_software: u64,
}

/// Rows of a workgroup: pieces of images are whole ones.
const ROWS_OF_A_GROUP: u32 = 8;

impl RowWork {
    fn pieces(self, cx: &PassContext, height: u32) -> impl Iterator<Item = Rows> + use<> {
        let groups = cx.work_a_submit(self.on_software) / self.units.max(1) / u64::from(ROWS_OF_A_GROUP);
        let step = groups.clamp(1, 1 << 16) as u32 * ROWS_OF_A_GROUP;
        let rows = move |first| Rows { first, count: (height - first).min(step) };
        (0..height).step_by(step as usize).map(rows)
    }
}

fn input<'a, K: Kind>(handle: Handle<K>) -> Input<'a> {
    if K::IS_TEXTURE { Input::Texture(handle.cast()) } else { Input::Buffer(handle.cast()) }
}

/// How many threads a shader is to have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Threads {
    Image([u32; 3]),
    Items(u32),
    Groups([u32; 3]),
}

/// Workgroups of one row of them.
const MOST_OF_A_ROW: u32 = 32_768;

impl Threads {
    fn groups(self, workgroup: [u32; 3]) -> [u32; 3] {
        match self {
            Self::Groups(groups) => groups,
            Self::Image(size) => std::array::from_fn(|axis| size[axis].div_ceil(workgroup[axis].max(1))),
            Self::Items(items) => {
                let groups = items.div_ceil(workgroup.iter().product::<u32>().max(1)).max(1);
                let row = groups.min(MOST_OF_A_ROW);
                [row, groups.div_ceil(row), 1]
            }
        }
    }
}

/// A bound resource, kept alive until the pass is recorded.
enum Bound {
    View(wgpu::TextureView),
    Buffer(wgpu::Buffer),
    Sampler(wgpu::Sampler),
}

impl Bound {
    fn binding(&self) -> Binding<'_> {
        match self {
            Self::View(view) => Binding::Texture(view),
            Self::Buffer(buffer) => Binding::Buffer(buffer),
            Self::Sampler(sampler) => Binding::Sampler(sampler),
        }
    }
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
            Self::Uniform(bytes) => Bound::Buffer(gpu.kept(name, bytes, wgpu::BufferUsages::UNIFORM)),
            Self::Constants(bytes) => Bound::Buffer(gpu.kept(name, bytes, wgpu::BufferUsages::STORAGE)),
            Self::Later(bytes) => Bound::Buffer(gpu.kept(name, bytes(), wgpu::BufferUsages::STORAGE)),
            Self::Outside(Outside::Buffer(buffer)) => Bound::Buffer(buffer.clone()),
            Self::Outside(Outside::Texture(view)) => Bound::View(view.clone()),
            Self::Sampler(descriptor) => Bound::Sampler(gpu.sampler(&descriptor)),
            Self::StandIn(view) => Bound::View(view(gpu)),
        }
    }
}
