//! The raster pass that all overlays share, which blends over the display image.

use crate::gpu::{Binding, RasterKey, ShaderDef};
use crate::graph::{PassContext, PassError};
use wgpu::TextureFormat;

/// Format of the display image: sRGB-encoded values in plain numbers.
const FORMAT: TextureFormat = TextureFormat::Rgba8Unorm;
/// Format of an overlay's own depth.
pub(super) const DEPTH: TextureFormat = TextureFormat::Depth32Float;

/// A draw of an overlay.
pub(super) struct Draw<'a> {
    /// Shader file, with the entry points `vertex` and `fragment`.
    pub shader: &'static str,
    /// Its defines.
    pub defs: Vec<(&'static str, ShaderDef)>,
    /// Bindings of group 0.
    pub bindings: &'a [(&'a str, Binding<'a>)],
    /// The display image.
    pub target: &'a wgpu::TextureView,
    /// Depth of the overlay's own things among themselves, cleared first.
    pub depth: Option<&'a wgpu::TextureView>,
    /// Vertices of an instance.
    pub vertices: u32,
    /// Instances.
    pub instances: u32,
}

/// Blends triangles over the display image.
pub(super) fn draw(cx: &mut PassContext, draw: &Draw) -> Result<(), PassError> {
    let gpu = cx.gpu;
    let pipeline = gpu.pipelines.raster(gpu, &raster_key(draw))?;
    let group = pipeline.bind(gpu, 0, draw.bindings)?;
    let raster =
        pipeline.raster().ok_or_else(|| PassError::message(format!("{} makes no raster pipeline", draw.shader)))?;
    let mut pass = cx.render_pass(&wgpu::RenderPassDescriptor {
        label: Some(draw.shader),
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view: draw.target,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations { load: wgpu::LoadOp::Load, store: wgpu::StoreOp::Store },
        })],
        depth_stencil_attachment: draw.depth.map(|view| wgpu::RenderPassDepthStencilAttachment {
            view,
            depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(0.0), store: wgpu::StoreOp::Discard }),
            stencil_ops: None,
        }),
        ..Default::default()
    });
    pass.set_pipeline(raster);
    pass.set_bind_group(0, &group, &[]);
    pass.draw(0..draw.vertices, 0..draw.instances);
    drop(pass);
    cx.counts().draws += 1;
    cx.counts().triangles += u64::from(draw.vertices / 3) * u64::from(draw.instances);
    Ok(())
}

fn raster_key(draw: &Draw) -> RasterKey {
    let depth = wgpu::DepthStencilState {
        format: DEPTH,
        depth_write_enabled: Some(true),
        depth_compare: Some(wgpu::CompareFunction::Greater),
        stencil: Default::default(),
        bias: Default::default(),
    };
    let target = wgpu::ColorTargetState {
        format: FORMAT,
        blend: Some(wgpu::BlendState::ALPHA_BLENDING),
        write_mask: wgpu::ColorWrites::COLOR,
    };
    RasterKey {
        shader: draw.shader,
        vertex: "vertex",
        fragment: Some("fragment"),
        defs: draw.defs.clone(),
        vertex_buffers: Vec::new(),
        primitive: wgpu::PrimitiveState::default(),
        depth: draw.depth.map(|_| depth),
        targets: vec![Some(target)],
    }
}
