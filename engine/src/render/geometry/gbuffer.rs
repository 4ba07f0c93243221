//! The geometry buffer: what each pixel sees (encoding: `shaders/lib/gbuffer.wgsl`).

use super::static_layers;
use crate::gpu::RasterKey;
use crate::graph::{Graph, Handle, PassBindings, PassContext, PassError, Texture, TextureDesc};
use crate::render::frame::Frame;
use crate::render::scene_gpu::{DrawFilter, MaterialClass, Motion};
use crate::render::surfaces::Surfaces;
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
    let frustum = frame.frustum();
    let (drawn, key) = (frame.clone(), frame.view_key());
    let draw = move |cx: &mut PassContext, targets: &[Handle<Texture>; 5], motion| draw(cx, &drawn, targets, motion);
    let [base_color, normal, emissive, object, depth] = static_layers::declare(
        graph,
        frame,
        &format!("{prefix}gbuffer"),
        targets,
        &[DrawFilter::opaque(&frustum)],
        &key,
        draw,
    );
    GBuffer { base_color, normal, emissive, object, depth, surfaces: Surfaces::Nearest }
}

fn draw(cx: &mut PassContext, frame: &Frame, targets: &[Handle<Texture>; 5], motion: Motion) -> Result<(), PassError> {
    let view = frame.view_uniform(cx.gpu);
    let [color @ .., depth] = targets.map(|handle| cx.view(handle));
    let attachments = color.each_ref().map(|view| {
        Some(wgpu::RenderPassColorAttachment {
            view,
            depth_slice: None,
            resolve_target: None,
            ops: static_layers::ops(motion, wgpu::Color::TRANSPARENT),
        })
    });
    let mut pass = cx
        .render_pass(&wgpu::RenderPassDescriptor {
            label: Some("gbuffer"),
            color_attachments: &attachments,
            depth_stencil_attachment: Some(depth_attachment(&depth, motion)),
            ..Default::default()
        })
        .forget_lifetime();
    let frustum = frame.frustum();
    let filter = DrawFilter::opaque(&frustum).of(motion);
    frame.gpu_scene.draw(cx, &mut pass, &view, &filter, raster_key)
}

fn raster_key(class: MaterialClass) -> RasterKey {
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

/// Cleared to 0, which is infinitely far, unless dynamic objects are drawn over what is there.
pub(in crate::render) fn depth_attachment(
    view: &wgpu::TextureView,
    motion: Motion,
) -> wgpu::RenderPassDepthStencilAttachment<'_> {
    wgpu::RenderPassDepthStencilAttachment { view, depth_ops: Some(static_layers::ops(motion, 0.0)), stencil_ops: None }
}
