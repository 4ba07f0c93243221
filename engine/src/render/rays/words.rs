//! Textures of words, which shaders fetch four at a time.

use super::RayError;
use crate::gpu::Gpu;

/// Texels of a row of all these textures.
pub(super) const ROW: u32 = 4096;

/// Four words.
pub(super) type Texel = [u32; 4];

/// A texture of four words a texel. Shaders best read it as a storage texture: there are no levels to choose from, which
/// makes a fetch half as long on software adapters.
pub(super) struct Words {
    texture: wgpu::Texture,
    view: wgpu::TextureView,
}

impl Words {
    /// All zeros.
    pub(super) fn new(gpu: &Gpu, label: &str, rows: u32) -> Self {
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some(label),
            size: wgpu::Extent3d { width: ROW, height: rows, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba32Uint,
            usage: wgpu::TextureUsages::STORAGE_BINDING
                | wgpu::TextureUsages::TEXTURE_BINDING
                | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        Self { view: texture.create_view(&Default::default()), texture }
    }

    /// To be bound.
    pub(super) fn view(&self) -> &wgpu::TextureView {
        &self.view
    }

    /// Writes all of it; makes it anew if it is of another size.
    pub(super) fn upload(
        &mut self,
        gpu: &Gpu,
        label: &str,
        what: &'static str,
        texels: &mut Vec<Texel>,
    ) -> Result<(), RayError> {
        texels.resize(texels.len().next_multiple_of(ROW as usize).max(ROW as usize), Texel::default());
        let rows = texels.len() as u32 / ROW;
        let limit = gpu.limits.max_texture_dimension_2d;
        if rows > limit {
            let mebibytes = |rows: u32| (16 * u64::from(ROW) * u64::from(rows)).div_ceil(1 << 20);
            return Err(RayError::TooLarge { what, needed: mebibytes(rows), limit: mebibytes(limit) });
        }
        if self.texture.height() != rows {
            *self = Self::new(gpu, label, rows);
        }
        gpu.write_texture(
            self.texture.as_image_copy(),
            bytemuck::cast_slice(texels),
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(16 * ROW), rows_per_image: Some(rows) },
            wgpu::Extent3d { width: ROW, height: rows, depth_or_array_layers: 1 },
        );
        Ok(())
    }
}
