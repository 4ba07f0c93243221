//! A black texture, bound where a frame lacks an input.

use crate::gpu::Gpu;

/// One texel of exact zero, so that a frame with a skipped term runs the same shader as one without.
pub(super) fn zero_texture(gpu: &Gpu, layers: u32) -> wgpu::TextureView {
    let format = if layers == 1 { wgpu::TextureFormat::Rgba32Float } else { wgpu::TextureFormat::R32Float };
    let make = || {
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("zero"),
            size: wgpu::Extent3d { width: 1, height: 1, depth_or_array_layers: layers },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        });
        texture.create_view(&Default::default())
    };
    gpu.stand_in("zero", layers, make)
}
