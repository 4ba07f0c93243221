//! Makes pipelines and keeps them.

use super::compose::CompiledShader;
use super::inlined::{InlinedSize, indexed_values};
use super::pipeline::{ComputeKey, Entry, Pipeline, PipelineCache, RasterKey, Raw};
use super::reflect::{self, BindingInfo, EntryPoint};
use super::shader_defs::Defs;
use super::{Gpu, ShaderError};
use std::borrow::Cow;
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

impl PipelineCache {
    /// The pipeline, made if need be.
    ///
    /// # Errors
    /// A shader that has never compiled, or that the device has never taken.
    pub fn compute(&self, gpu: &Gpu, key: &ComputeKey) -> Result<Arc<Pipeline>, ShaderError> {
        gpu.audit.note(key.shader, key);
        let name = || format!("{} {:?}", key.entry, key.defs);
        cached(&self.compute, gpu, key, (key.shader, &key.defs), name, |compiled| build_compute(gpu, key, compiled))
    }

    /// The pipeline, made if need be.
    ///
    /// # Errors
    /// A shader that has never compiled, or that the device has never taken.
    pub fn raster(&self, gpu: &Gpu, key: &RasterKey) -> Result<Arc<Pipeline>, ShaderError> {
        gpu.audit.note(key.shader, key);
        let name = || format!("{} {:?} {:?}", key.vertex, key.fragment, key.defs);
        cached(&self.raster, gpu, key, (key.shader, &key.defs), name, |compiled| build_raster(gpu, key, compiled))
    }

    /// Number of pipelines held.
    pub fn len(&self) -> usize {
        self.compute.lock().unwrap_or_else(PoisonError::into_inner).len()
            + self.raster.lock().unwrap_or_else(PoisonError::into_inner).len()
    }

    /// Whether there is no pipeline yet.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// The pipeline, if it was found right at that revision of the shaders.
fn current<K: Eq + std::hash::Hash>(cache: &Mutex<HashMap<K, Entry>>, key: &K, revision: u64) -> Option<Arc<Pipeline>> {
    let cache = cache.lock().unwrap_or_else(PoisonError::into_inner);
    cache.get(key).filter(|entry| entry.revision == revision)?.last_good.clone()
}

fn cached<K: Clone + Eq + std::hash::Hash>(
    cache: &Mutex<HashMap<K, Entry>>,
    gpu: &Gpu,
    key: &K,
    (shader, defs): (&str, &Defs),
    name: impl FnOnce() -> String,
    build: impl FnOnce(&Arc<CompiledShader>) -> Result<Pipeline, ShaderError>,
) -> Result<Arc<Pipeline>, ShaderError> {
    // Until a shader is reloaded, the last result is valid.
    let revision = gpu.shaders.revision();
    if let Some(pipeline) = current(cache, key, revision) {
        return Ok(pipeline);
    }
    let compiled = gpu.shaders.compile(shader, defs)?;
    let mut cache = cache.lock().unwrap_or_else(PoisonError::into_inner);
    if !cache.get(key).is_some_and(|entry| Arc::ptr_eq(&entry.compiled, &compiled)) {
        let built = build(&compiled);
        gpu.shaders.set_pipeline_error(shader, &name(), built.as_ref().err());
        let before = cache.remove(key).and_then(|entry| entry.last_good);
        let (last_good, error) = match built {
            Ok(pipeline) => (Some(Arc::new(pipeline)), None),
            Err(error) => {
                log::error!("{error}");
                (before, Some(error))
            }
        };
        cache.insert(key.clone(), Entry { compiled, last_good, error, revision });
    }
    if let Some(entry) = cache.get_mut(key) {
        entry.revision = revision;
    }
    match cache.get(key) {
        Some(Entry { last_good: Some(pipeline), .. }) => Ok(Arc::clone(pipeline)),
        Some(Entry { error: Some(error), .. }) => Err(error.clone()),
        _ => Err(ShaderError::of_file(shader, "no pipeline was made")),
    }
}

/// A compiled shader on its way into a pipeline.
struct Parts<'a> {
    shader: &'static str,
    compiled: &'a CompiledShader,
    entries: Vec<EntryPoint>,
}

impl<'a> Parts<'a> {
    fn new(shader: &'static str, compiled: &'a CompiledShader) -> Result<Self, ShaderError> {
        let entries = reflect::entry_points(compiled).map_err(|what| ShaderError::of_file(shader, what))?;
        Ok(Self { shader, compiled, entries })
    }

    fn entry(&self, name: &str, stage: wgpu::ShaderStages) -> Result<&EntryPoint, ShaderError> {
        self.entries.iter().find(|entry| entry.name == name && entry.stage == stage).ok_or_else(|| {
            let names: Vec<&str> = self.entries.iter().map(|e| e.name.as_str()).collect();
            ShaderError::of_file(
                self.shader,
                format!("no entry point `{name}` for {stage:?}; there are {}", names.join(", ")),
            )
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
            Some(known) => known.join(binding),
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

fn guarded<T>(gpu: &Gpu, shader: &str, make: impl FnOnce() -> T) -> Result<T, ShaderError> {
    gpu.checked(make).map_err(|refused| ShaderError::of_file(shader, format!("the device refused it: {refused}")))
}

/// Where the driver looks a pipeline up before it compiles it.
fn driver_cache(gpu: &Gpu) -> Option<&wgpu::PipelineCache> {
    let file = gpu.pipeline_file.get()?;
    file.grow();
    Some(&file.cache)
}

/// Counts a pipeline that is made of these entry points.
fn count_pipeline(gpu: &Gpu, shader: &str, compiled: &CompiledShader, entries: &[&EntryPoint]) {
    let sizes: Vec<InlinedSize> = entries.iter().map(|entry| InlinedSize::of(&compiled.module, &entry.name)).collect();
    sizes.iter().for_each(|size| log::debug!("{shader}: {size}"));
    indexed_values(compiled)
        .iter()
        .for_each(|what| log::debug!("{shader}: {what}, which is slow to compile and to run"));
    gpu.count(|counts| {
        counts.pipelines += 1;
        counts.operations += sizes.iter().map(|size| size.operations).sum::<u64>();
    });
}

fn build_compute(gpu: &Gpu, key: &ComputeKey, compiled: &CompiledShader) -> Result<Pipeline, ShaderError> {
    let parts = Parts::new(key.shader, compiled)?;
    let entry = parts.entry(key.entry, wgpu::ShaderStages::COMPUTE)?;
    count_pipeline(gpu, key.shader, compiled, &[entry]);
    let bindings = merged(&[entry]);
    let unused = reflect::unused(&compiled.module, &bindings);
    guarded(gpu, key.shader, || {
        let layouts = layouts(gpu, key.shader, &bindings);
        let raw = gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(key.entry),
            layout: Some(&pipeline_layout(gpu, key.shader, &layouts)),
            module: &parts.module(gpu),
            entry_point: Some(key.entry),
            compilation_options: Default::default(),
            cache: driver_cache(gpu),
        });
        let workgroup_size = entry.workgroup_size;
        Pipeline { raw: Raw::Compute(raw), shader: key.shader, bindings, unused, layouts, workgroup_size }
    })
}

fn build_raster(gpu: &Gpu, key: &RasterKey, compiled: &CompiledShader) -> Result<Pipeline, ShaderError> {
    let parts = Parts::new(key.shader, compiled)?;
    let mut entries = vec![parts.entry(key.vertex, wgpu::ShaderStages::VERTEX)?];
    if let Some(fragment) = key.fragment {
        entries.push(parts.entry(fragment, wgpu::ShaderStages::FRAGMENT)?);
    }
    count_pipeline(gpu, key.shader, compiled, &entries);
    let bindings = merged(&entries);
    let unused = reflect::unused(&compiled.module, &bindings);
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
            cache: driver_cache(gpu),
        });
        Pipeline { raw: Raw::Raster(raw), shader: key.shader, bindings, unused, layouts, workgroup_size: [1; 3] }
    })
}
