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

    /// Makes room for so many rows. What was written before is lost if there is another number of them.
    ///
    /// # Errors
    /// If a texture cannot have so many.
    pub(super) fn reserve(&mut self, gpu: &Gpu, label: &str, what: &'static str, rows: usize) -> Result<(), RayError> {
        let limit = gpu.limits.max_texture_dimension_2d;
        if rows > limit as usize {
            let mebibytes = |rows: usize| (16 * u64::from(ROW) * rows as u64).div_ceil(1 << 20);
            return Err(RayError::TooLarge { what, needed: mebibytes(rows), limit: mebibytes(limit as usize) });
        }
        let rows = rows.max(1) as u32;
        if self.texture.height() != rows {
            *self = Self::new(gpu, label, rows);
        }
        Ok(())
    }

    /// Writes texels from one on, row after row, and nothing behind them.
    pub(super) fn write(&self, gpu: &Gpu, first: usize, texels: &[Texel]) {
        let row = ROW as usize;
        let before = (first.next_multiple_of(row) - first).min(texels.len());
        let (begun, rest) = texels.split_at(before);
        let (whole, last) = rest.split_at(rest.len() / row * row);
        self.write_rows(gpu, first, 1, begun);
        self.write_rows(gpu, first + before, whole.len() / row, whole);
        self.write_rows(gpu, first + before + whole.len(), 1, last);
    }

    /// Writes so many rows of equal length, one below the other, from a texel on.
    pub(super) fn write_rows(&self, gpu: &Gpu, first: usize, rows: usize, texels: &[Texel]) {
        if texels.is_empty() {
            return;
        }
        let (width, rows) = ((texels.len() / rows) as u32, rows as u32);
        let [x, y] = [first as u32 % ROW, first as u32 / ROW];
        gpu.write_texture(
            wgpu::TexelCopyTextureInfo { origin: wgpu::Origin3d { x, y, z: 0 }, ..self.texture.as_image_copy() },
            bytemuck::cast_slice(texels),
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(16 * width), rows_per_image: Some(rows) },
            wgpu::Extent3d { width, height: rows, depth_or_array_layers: 1 },
        );
    }
}
