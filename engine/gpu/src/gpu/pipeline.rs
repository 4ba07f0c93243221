//! Pipelines by what they are made of. Bind group layouts come from the shader itself, and resources are bound by
//! the names that they have there.

use super::compose::CompiledShader;
use super::reflect::BindingInfo;
use super::shader_defs::ShaderDef;
use super::shader_error::ShaderError;
use std::collections::HashMap;
use std::sync::{Arc, Mutex};

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
}

/// Pipelines in use. A pipeline whose shader changed on disk is rebuilt; while that fails, the last good one
/// stays, and [`super::ShaderLibrary::errors`] says why.
#[derive(Default)]
pub struct PipelineCache {
    pub(super) compute: Mutex<HashMap<ComputeKey, Entry>>,
    pub(super) raster: Mutex<HashMap<RasterKey, Entry>>,
}

pub(super) struct Entry {
    /// The last attempt.
    pub(super) compiled: Arc<CompiledShader>,
    pub(super) last_good: Option<Arc<Pipeline>>,
    /// Why the device refused what was tried last.
    pub(super) error: Option<ShaderError>,
    /// That of all shaders when it was last looked at.
    pub(super) revision: u64,
}
