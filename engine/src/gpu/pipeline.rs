//! Pipelines by what they are made of. Bind group layouts come from the shader itself, and resources are bound by
//! the names that they have there.

use super::reflect::BindingInfo;
use super::reuse::{BindKey, BoundResource};
use super::{Gpu, ShaderDef};

/// The key of a compute pipeline.
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

    /// Adds a define.
    pub fn def(mut self, name: &'static str, value: ShaderDef) -> Self {
        self.defs.push((name, value));
        self
    }
}

/// The key of a raster pipeline.
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
    /// Part of a buffer: offset and size \[bytes\].
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
    /// The fault, and what the shader declares.
    pub what: String,
}

#[derive(Debug)]
pub(super) enum Raw {
    Compute(wgpu::ComputePipeline),
    Raster(wgpu::RenderPipeline),
}

/// A pipeline with the bindings of its shader.
#[derive(Debug)]
pub struct Pipeline {
    pub(super) raw: Raw,
    pub(super) shader: &'static str,
    /// The bindings that the entry points use.
    pub(super) bindings: Vec<BindingInfo>,
    /// Group and name of what the shader declares but these entry points do not use.
    pub(super) unused: Vec<(u32, String)>,
    pub(super) layouts: Vec<wgpu::BindGroupLayout>,
    pub(super) workgroup_size: [u32; 3],
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

    /// Whether the pipeline uses something of that name in the group.
    pub fn declares(&self, group: u32, name: &str) -> bool {
        self.bindings.iter().any(|b| b.group == group && b.name == name)
    }

    /// The bind group of resources by their WGSL names: the same one as long as frames bind the same resources. A resource that the shader declares but does not use
    /// (any more) is left out, so that an edit of the shader needs none of the program.
    ///
    /// # Errors
    /// A name that the shader does not declare, one that is missing, or a resource that does not fit.
    pub fn bind(&self, gpu: &Gpu, group: u32, resources: &[(&str, Binding)]) -> Result<wgpu::BindGroup, BindError> {
        let error = |what: String| BindError { shader: self.shader.into(), group, what };
        let used: Vec<&BindingInfo> = self.bindings.iter().filter(|b| b.group == group).collect();
        if let Some((name, _)) = resources.iter().find(|(name, _)| !self.knows(group, name)) {
            let names: Vec<&str> = used.iter().map(|b| b.name.as_str()).collect();
            return Err(error(format!("it declares no `{name}`; it uses {}", names.join(", "))));
        }
        let mut entries = Vec::with_capacity(used.len());
        for info in used {
            let (_, resource) = resources
                .iter()
                .find(|(name, _)| *name == info.name)
                .ok_or_else(|| error(format!("`{}` is not bound", info.name)))?;
            let resource = resource.fitting(info).map_err(|what| error(format!("`{}` {what}", info.name)))?;
            entries.push(wgpu::BindGroupEntry { binding: info.binding, resource });
        }
        let layout = self.layouts.get(group as usize).ok_or_else(|| error("it has no such group".into()))?;
        let descriptor = wgpu::BindGroupDescriptor { label: Some(self.shader), layout, entries: &entries };
        let bound = |entry: &wgpu::BindGroupEntry| Some((entry.binding, BoundResource::of(&entry.resource)?));
        let resources = entries.iter().map(bound).collect::<Option<_>>();
        let resources = resources.ok_or_else(|| error("it binds an array of resources".into()))?;
        // Formats, dimensions, usages and limits are left for the device to compare.
        gpu.kept_bind_group(BindKey { layout: layout.clone(), resources }, &descriptor)
            .map_err(|refused| error(self.named(group, refused)))
    }

    fn knows(&self, group: u32, name: &str) -> bool {
        self.declares(group, name) || self.unused.iter().any(|(g, unused)| *g == group && unused == name)
    }

    /// The device speaks of binding numbers: adds their names.
    fn named(&self, group: u32, refused: String) -> String {
        let of_group = self.bindings.iter().filter(|b| b.group == group);
        let names: Vec<String> = of_group.map(|b| format!("{} is `{}`", b.binding, b.name)).collect();
        format!("the device refused it: {refused} (binding {})", names.join(", "))
    }
}

impl<'a> Binding<'a> {
    fn fitting(self, info: &BindingInfo) -> Result<wgpu::BindingResource<'a>, String> {
        use wgpu::BindingType as Type;
        match (self, info.ty) {
            (Binding::Texture(view), Type::Texture { .. } | Type::StorageTexture { .. }) => {
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
                if offset.checked_add(size.get()).is_none_or(|end| end > buffer.size()) {
                    return Err(format!("was given {size} bytes from {offset} on; the buffer has {}", buffer.size()));
                }
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
