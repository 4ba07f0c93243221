//! The geometry buffer: what each pixel sees (encoding: `shaders/lib/gbuffer.wgsl`).

use super::static_layers::{self, LayerView};
use crate::gpu::RasterKey;
use crate::graph::{Graph, Handle, PassBindings, Texture, TextureDesc};
use crate::render::frame::Frame;
use crate::render::scene_gpu::{DrawFilter, MaterialClass};
use crate::render::surfaces::Surfaces;
use std::rc::Rc;
use wgpu::TextureFormat;

pub(super) const USAGE: wgpu::TextureUsages =
    wgpu::TextureUsages::RENDER_ATTACHMENT.union(wgpu::TextureUsages::TEXTURE_BINDING);

/// Colour targets in the order of the fragment shader's outputs: 32 bytes a texel, the portable limit.
pub(super) const COLOR_TARGETS: [(&str, TextureFormat); 4] = [
    ("gbuffer base color", TextureFormat::Rgba16Uint),
    ("gbuffer normal", TextureFormat::Rgba16Uint),
    ("gbuffer emissive", TextureFormat::Rg32Uint),
    ("gbuffer object", TextureFormat::Rg32Uint),
];

/// Depth format of the camera's view.
pub const DEPTH_FORMAT: TextureFormat = TextureFormat::Depth32Float;

/// Handles of the G-buffer's targets.
#[derive(Clone, Copy, Debug)]
pub struct GBuffer {
    /// Linear base colour and metallic.
    pub base_color: Handle<Texture>,
    /// Octahedral world normal, roughness, F90.
    pub normal: Handle<Texture>,
    /// Emitted radiance, shared exponent.
    pub emissive: Handle<Texture>,
    /// Object id, 0 where there is nothing, and √F0.
    pub object: Handle<Texture>,
    /// Reversed depth, 0 where there is nothing.
    pub depth: Handle<Texture>,
    /// Which surfaces of the pixels it holds.
    pub surfaces: Surfaces,
}

impl GBuffer {
    /// Binds what passes need that reflect light: `base_color`, `normal`, `object` and `depth`.
    pub(in crate::render) fn bind(&self, pass: &mut PassBindings) {
        pass.read("base_color", self.base_color);
        pass.read("normal", self.normal);
        pass.read("object", self.object);
        pass.read("depth", self.depth);
    }
}

/// Declares the pass that draws the scene into the G-buffer.
pub fn declare<'a>(graph: &mut Graph<'a>, frame: &Frame<'a>) -> GBuffer {
    declare_as(graph, frame, "")
}

/// The same of another view beside the frame's own: its names begin with `prefix`.
pub(in crate::render) fn declare_as<'a>(graph: &mut Graph<'a>, frame: &Frame<'a>, prefix: &str) -> GBuffer {
    let [width, height] = frame.view.size;
    let [base_color, normal, emissive, object] = COLOR_TARGETS;
    let targets = [base_color, normal, emissive, object, ("gbuffer depth", DEPTH_FORMAT)]
        .map(|(name, format)| (format!("{prefix}{name}"), TextureDesc::d2(width, height, format, USAGE)));
    let (frustum, uniform) = (frame.frustum(), frame.view_values());
    let view = LayerView { layer: None, frustum, uniform, pipeline: Rc::new(pipeline) };
    let name = format!("{prefix}gbuffer");
    let [base_color, normal, emissive, object, depth] =
        static_layers::declare(graph, frame, &name, targets, DrawFilter::opaque, &[view]);
    GBuffer { base_color, normal, emissive, object, depth, surfaces: Surfaces::Nearest }
}

fn pipeline(class: MaterialClass) -> RasterKey {
    RasterKey {
        shader: "geometry/gbuffer.wgsl",
        vertex: "vertex",
        fragment: Some("fragment"),
        defs: class.defs_of_view(),
        vertex_buffers: class.vertex_buffers(),
        primitive: class.primitive_state(),
        depth: Some(depth_state()),
        targets: COLOR_TARGETS.iter().map(|&(_, format)| Some(format.into())).collect(),
    }
}

/// Depth test of every raster pass: reversed, the first of equals stays.
pub(in crate::render) fn depth_state() -> wgpu::DepthStencilState {
    wgpu::DepthStencilState {
        format: DEPTH_FORMAT,
        depth_write_enabled: Some(true),
        depth_compare: Some(wgpu::CompareFunction::Greater),
        stencil: Default::default(),
        bias: Default::default(),
    }
}
