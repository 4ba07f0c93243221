//! The raster pipeline that all overlays share, which blends over the display image.

use crate::gpu::RasterKey;
use wgpu::TextureFormat;

/// Format of the display image: sRGB-encoded values in plain numbers.
const FORMAT: TextureFormat = TextureFormat::Rgba8Unorm;
/// Format of an overlay's own depth.
pub(super) const DEPTH: TextureFormat = TextureFormat::Depth32Float;

/// The pipeline of a shader with the entry points `vertex` and `fragment`. Its things hide each other where it has a depth of
/// its own.
pub(super) fn pipeline(shader: &'static str, has_depth: bool) -> RasterKey {
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
        shader,
        vertex: "vertex",
        fragment: Some("fragment"),
        defs: Vec::new(),
        vertex_buffers: Vec::new(),
        primitive: wgpu::PrimitiveState::default(),
        depth: has_depth.then_some(depth),
        targets: vec![Some(target)],
    }
}
