//! The sky on the device.

use crate::assets::{AssetId, SkyMap};
use crate::gpu::Gpu;
use crate::scene::Scene;

/// The map as `lib/sky.wgsl` reads it; a single black texel where there is none.
pub(in crate::render) struct GpuSky {
    map: Option<AssetId>,
    view: wgpu::TextureView,
}

impl GpuSky {
    pub(in crate::render) fn new(gpu: &Gpu) -> Self {
        let view = upload(gpu, "sky", 2, 1, &[[0.0, 0.0, 0.0, 1.0]; 2]);
        Self { map: None, view }
    }

    /// Uploads the scene's map, unless it is the one that is there.
    pub(in crate::render) fn update(&mut self, gpu: &Gpu, scene: &Scene) {
        let map = scene.sky_map.as_deref();
        if self.map == map.map(|map| map.id) {
            return;
        }
        *self = match map {
            Some(map) => Self { map: Some(map.id), view: table(gpu, map) },
            None => Self::new(gpu),
        };
    }

    /// Whether the sky differs by direction.
    pub(in crate::render) fn is_map(&self) -> bool {
        self.map.is_some()
    }

    pub(in crate::render) fn view(&self) -> &wgpu::TextureView {
        &self.view
    }
}

fn table(gpu: &Gpu, map: &SkyMap) -> wgpu::TextureView {
    upload(gpu, "sky", map.width + 1, map.height, &map.table())
}

fn upload(gpu: &Gpu, label: &str, width: u32, height: u32, texels: &[[f32; 4]]) -> wgpu::TextureView {
    let size = wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba32Float,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    let layout =
        wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(16 * width), rows_per_image: Some(height) };
    gpu.write_texture(texture.as_image_copy(), bytemuck::cast_slice(texels), layout, size);
    texture.create_view(&Default::default())
}
