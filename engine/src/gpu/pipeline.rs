//! Pipelines by what they are made of. Bind group layouts come from the shader itself, and resources are bound by
//! the names that they have there.

use super::reflect::{self, BindingInfo, EntryPoint};
use super::shader_library::{CompiledShader, Defs};
use super::{Gpu, ShaderDef, ShaderError};
use std::borrow::Cow;
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

/// What a compute pipeline is made of.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct ComputeKey {
    /// File, relative to the shader folder.
    pub shader: &'static str,
    /// Entry point.
    pub entry: &'static str,
    /// Defines.
    pub defs: Vec<(&'static str, ShaderDef)>,
}

impl ComputeKey {
    /// An entry point without defines.
    pub fn new(shader: &'static str, entry: &'static str) -> Self {
        Self { shader, entry, defs: Vec::new() }
    }

    /// The same with one define more.
    pub fn def(mut self, name: &'static str, value: ShaderDef) -> Self {
        self.defs.push((name, value));
        self
    }
}

/// What a raster pipeline is made of.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct RasterKey {
    /// File, relative to the shader folder.
    pub shader: &'static str,
    /// Entry point of the vertex stage.
    pub vertex: &'static str,
    /// Entry point of the fragment stage; none: depth only.
    pub fragment: Option<&'static str>,
    /// Defines.
    pub defs: Vec<(&'static str, ShaderDef)>,
    /// Vertex buffers.
    pub vertex_buffers: Vec<wgpu::VertexBufferLayout<'static>>,
    /// Topology, winding, culling.
    pub primitive: wgpu::PrimitiveState,
    /// Depth test.
    pub depth: Option<wgpu::DepthStencilState>,
    /// Colour targets.
    pub targets: Vec<Option<wgpu::ColorTargetState>>,
}

/// A resource to bind.
#[derive(Clone, Copy, Debug)]
pub enum Binding<'a> {
    /// A texture, sampled or storage.
    Texture(&'a wgpu::TextureView),
    /// A whole buffer.
    Buffer(&'a wgpu::Buffer),
    /// Part of a buffer: offset and size [bytes].
    BufferRange(&'a wgpu::Buffer, u64, u64),
    /// A sampler.
    Sampler(&'a wgpu::Sampler),
}

/// Resources that do not fit what the shader declares.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("shader {shader}, group {group}: {what}")]
pub struct BindError {
    /// The shader's file.
    pub shader: String,
    /// Bind group.
    pub group: u32,
    /// What is wrong and what the shader declares.
    pub what: String,
}

#[derive(Debug)]
enum Raw {
    Compute(wgpu::ComputePipeline),
    Raster(wgpu::RenderPipeline),
}

/// A pipeline with the bindings of its shader.
#[derive(Debug)]
pub struct Pipeline {
    raw: Raw,
    shader: &'static str,
    bindings: Vec<BindingInfo>,
    layouts: Vec<wgpu::BindGroupLayout>,
    workgroup_size: [u32; 3],
}

impl Pipeline {
    /// The compute pipeline, if it is one.
    pub fn compute(&self) -> Option<&wgpu::ComputePipeline> {
        match &self.raw {
            Raw::Compute(pipeline) => Some(pipeline),
            Raw::Raster(_) => None,
        }
    }

    /// The raster pipeline, if it is one.
    pub fn raster(&self) -> Option<&wgpu::RenderPipeline> {
        match &self.raw {
            Raw::Raster(pipeline) => Some(pipeline),
            Raw::Compute(_) => None,
        }
    }

    /// Threads of a workgroup; 1 each for raster pipelines.
    pub fn workgroup_size(&self) -> [u32; 3] {
        self.workgroup_size
    }

    /// Whether the shader binds something of that name in the group.
    pub fn declares(&self, group: u32, name: &str) -> bool {
        self.bindings.iter().any(|b| b.group == group && b.name == name)
    }

    /// Makes the bind group from resources by their WGSL names.
    ///
    /// # Errors
    /// A name that the shader does not use, one that is missing, or a resource of another kind.
    pub fn bind(&self, gpu: &Gpu, group: u32, resources: &[(&str, Binding)]) -> Result<wgpu::BindGroup, BindError> {
        let error = |what: String| BindError { shader: self.shader.into(), group, what };
        let declared: Vec<&BindingInfo> = self.bindings.iter().filter(|b| b.group == group).collect();
        if let Some((name, _)) = resources.iter().find(|(name, _)| declared.iter().all(|b| b.name != *name)) {
            let names: Vec<&str> = declared.iter().map(|b| b.name.as_str()).collect();
            return Err(error(format!("it uses no `{name}`; it uses {}", names.join(", "))));
        }
        let mut entries = Vec::with_capacity(declared.len());
        for info in declared {
            let (_, resource) = resources
                .iter()
                .find(|(name, _)| *name == info.name)
                .ok_or_else(|| error(format!("`{}` is not bound", info.name)))?;
            let resource = resource.fitting(info).map_err(|what| error(format!("`{}` {what}", info.name)))?;
            entries.push(wgpu::BindGroupEntry { binding: info.binding, resource });
        }
        let layout = self.layouts.get(group as usize).ok_or_else(|| error("it has no such group".into()))?;
        Ok(gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some(self.shader),
            layout,
            entries: &entries,
        }))
    }
}

impl<'a> Binding<'a> {
    fn fitting(self, info: &BindingInfo) -> Result<wgpu::BindingResource<'a>, String> {
        use wgpu::BindingType as Type;
        match (self, info.ty) {
            (Binding::Texture(view), Type::Texture { view_dimension, .. } | Type::StorageTexture { view_dimension, .. }) => {
                let _ = view_dimension;
                Ok(wgpu::BindingResource::TextureView(view))
            }
            (Binding::Sampler(sampler), Type::Sampler(_)) => Ok(wgpu::BindingResource::Sampler(sampler)),
            (Binding::Buffer(buffer), Type::Buffer { min_binding_size, .. }) => match min_binding_size {
                Some(least) if buffer.size() < least.get() => {
                    Err(format!("takes {least} bytes; the buffer has {}", buffer.size()))
                }
                _ => Ok(buffer.as_entire_binding()),
            },
            (Binding::BufferRange(buffer, offset, size), Type::Buffer { .. }) => {
                let size = std::num::NonZeroU64::new(size).ok_or("was given an empty range")?;
                Ok(wgpu::BindingResource::Buffer(wgpu::BufferBinding { buffer, offset, size: Some(size) }))
            }
            (given, declared) => Err(format!("is declared as {declared:?}, but was given {}", given.kind())),
        }
    }

    fn kind(self) -> &'static str {
        match self {
            Binding::Texture(_) => "a texture",
            Binding::Buffer(_) | Binding::BufferRange(..) => "a buffer",
            Binding::Sampler(_) => "a sampler",
        }
    }
}

/// Pipelines in use. A pipeline whose shader changed on disk is made anew; while that fails, the last good one
/// stays, and [`super::ShaderLibrary::errors`] says why.
#[derive(Default)]
pub struct PipelineCache {
    compute: Mutex<HashMap<ComputeKey, Entry>>,
    raster: Mutex<HashMap<RasterKey, Entry>>,
}

struct Entry {
    /// Library revision at which the source was last looked at.
    revision: u64,
    source_hash: u64,
    pipeline: Arc<Pipeline>,
}

impl PipelineCache {
    /// The pipeline, made if need be.
    ///
    /// # Errors
    /// A shader that has never compiled.
    pub fn compute(&self, gpu: &Gpu, key: &ComputeKey) -> Result<Arc<Pipeline>, ShaderError> {
        cached(&self.compute, gpu, key, key.shader, || build_compute(gpu, key))
    }

    /// The pipeline, made if need be.
    ///
    /// # Errors
    /// A shader that has never compiled.
    pub fn raster(&self, gpu: &Gpu, key: &RasterKey) -> Result<Arc<Pipeline>, ShaderError> {
        cached(&self.raster, gpu, key, key.shader, || build_raster(gpu, key))
    }

    /// Number of pipelines held.
    pub fn len(&self) -> usize {
        let count = |held: usize| held;
        count(self.compute.lock().unwrap_or_else(PoisonError::into_inner).len())
            + count(self.raster.lock().unwrap_or_else(PoisonError::into_inner).len())
    }

    /// Whether there is no pipeline yet.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

fn cached<K: Clone + Eq + std::hash::Hash>(
    cache: &Mutex<HashMap<K, Entry>>,
    gpu: &Gpu,
    key: &K,
    shader: &str,
    build: impl FnOnce() -> Result<Pipeline, ShaderError>,
) -> Result<Arc<Pipeline>, ShaderError> {
    let revision = gpu.shaders.revision();
    let mut cache = cache.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(entry) = cache.get(key).filter(|entry| entry.revision == revision) {
        return Ok(Arc::clone(&entry.pipeline));
    }
    let source_hash = gpu.shaders.source_hash(shader);
    if let Some(entry) = cache.get_mut(key).filter(|entry| entry.source_hash == source_hash) {
        entry.revision = revision;
        return Ok(Arc::clone(&entry.pipeline));
    }
    match (build(), cache.get_mut(key)) {
        (Ok(pipeline), _) => {
            let pipeline = Arc::new(pipeline);
            cache.insert(key.clone(), Entry { revision, source_hash, pipeline: Arc::clone(&pipeline) });
            Ok(pipeline)
        }
        (Err(_), Some(last_good)) => {
            last_good.revision = revision;
            Ok(Arc::clone(&last_good.pipeline))
        }
        (Err(error), None) => Err(error),
    }
}

/// A compiled shader on its way into a pipeline.
struct Parts {
    shader: &'static str,
    compiled: Arc<CompiledShader>,
    entries: Vec<EntryPoint>,
}

impl Parts {
    fn new(gpu: &Gpu, shader: &'static str, defs: &Defs) -> Result<Self, ShaderError> {
        let compiled = gpu.shaders.compile(shader, defs)?;
        let entries = reflect::entry_points(&compiled).map_err(|what| ShaderError::of_file(shader, what))?;
        Ok(Self { shader, compiled, entries })
    }

    fn entry(&self, name: &str) -> Result<&EntryPoint, ShaderError> {
        self.entries.iter().find(|entry| entry.name == name).ok_or_else(|| {
            let names: Vec<&str> = self.entries.iter().map(|e| e.name.as_str()).collect();
            ShaderError::of_file(self.shader, format!("no entry point `{name}`; there are {}", names.join(", ")))
        })
    }

    fn module(&self, gpu: &Gpu) -> wgpu::ShaderModule {
        gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(self.shader),
            source: wgpu::ShaderSource::Naga(Cow::Owned(self.compiled.module.clone())),
        })
    }
}

/// Bindings of several entry points, each once, seen by all stages that use it.
fn merged(entries: &[&EntryPoint]) -> Vec<BindingInfo> {
    let mut merged: Vec<BindingInfo> = Vec::new();
    for binding in entries.iter().flat_map(|entry| &entry.bindings) {
        match merged.iter_mut().find(|b| (b.group, b.binding) == (binding.group, binding.binding)) {
            Some(known) => known.visibility |= binding.visibility,
            None => merged.push(binding.clone()),
        }
    }
    merged.sort_by_key(|binding| (binding.group, binding.binding));
    merged
}

fn layouts(gpu: &Gpu, shader: &str, bindings: &[BindingInfo]) -> Vec<wgpu::BindGroupLayout> {
    let groups = bindings.iter().map(|b| b.group + 1).max().unwrap_or(0);
    let layout = |group| {
        let of_group = bindings.iter().filter(|b| b.group == group);
        let entries: Vec<_> = of_group
            .map(|b| wgpu::BindGroupLayoutEntry { binding: b.binding, visibility: b.visibility, ty: b.ty, count: None })
            .collect();
        gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(shader), entries: &entries })
    };
    (0..groups).map(layout).collect()
}

fn pipeline_layout(gpu: &Gpu, shader: &str, layouts: &[wgpu::BindGroupLayout]) -> wgpu::PipelineLayout {
    let groups: Vec<_> = layouts.iter().map(Some).collect();
    gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(shader),
        bind_group_layouts: &groups,
        ..Default::default()
    })
}

/// Runs device calls inside an error scope: what the driver refuses becomes an error instead of a panic.
fn guarded<T>(gpu: &Gpu, shader: &str, make: impl FnOnce() -> T) -> Result<T, ShaderError> {
    let scope = gpu.device.push_error_scope(wgpu::ErrorFilter::Validation);
    let made = make();
    match pollster::block_on(scope.pop()) {
        None => Ok(made),
        Some(error) => Err(ShaderError::of_file(shader, format!("the device refused it: {error}"))),
    }
}

fn build_compute(gpu: &Gpu, key: &ComputeKey) -> Result<Pipeline, ShaderError> {
    let parts = Parts::new(gpu, key.shader, &key.defs)?;
    let entry = parts.entry(key.entry)?;
    let bindings = merged(&[entry]);
    guarded(gpu, key.shader, || {
        let layouts = layouts(gpu, key.shader, &bindings);
        let raw = gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(key.entry),
            layout: Some(&pipeline_layout(gpu, key.shader, &layouts)),
            module: &parts.module(gpu),
            entry_point: Some(key.entry),
            compilation_options: Default::default(),
            cache: None,
        });
        let workgroup_size = entry.workgroup_size;
        Pipeline { raw: Raw::Compute(raw), shader: key.shader, bindings, layouts, workgroup_size }
    })
}

fn build_raster(gpu: &Gpu, key: &RasterKey) -> Result<Pipeline, ShaderError> {
    let parts = Parts::new(gpu, key.shader, &key.defs)?;
    let mut entries = vec![parts.entry(key.vertex)?];
    if let Some(fragment) = key.fragment {
        entries.push(parts.entry(fragment)?);
    }
    let bindings = merged(&entries);
    guarded(gpu, key.shader, || {
        let layouts = layouts(gpu, key.shader, &bindings);
        let module = parts.module(gpu);
        let buffers: Vec<_> = key.vertex_buffers.iter().cloned().map(Some).collect();
        let raw = gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(key.shader),
            layout: Some(&pipeline_layout(gpu, key.shader, &layouts)),
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some(key.vertex),
                compilation_options: Default::default(),
                buffers: &buffers,
            },
            primitive: key.primitive,
            depth_stencil: key.depth.clone(),
            multisample: Default::default(),
            fragment: key.fragment.map(|entry| wgpu::FragmentState {
                module: &module,
                entry_point: Some(entry),
                compilation_options: Default::default(),
                targets: &key.targets,
            }),
            multiview_mask: None,
            cache: None,
        });
        Pipeline { raw: Raw::Raster(raw), shader: key.shader, bindings, layouts, workgroup_size: [1; 3] }
    })
}
