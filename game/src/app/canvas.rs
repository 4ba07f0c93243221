//! Images with what is drawn over them, without a window.

use anyhow::Result;
use lightwell::gpu::{Gpu, read_texture};
use lightwell_runtime::window::{Painted, UiPainter};

/// A texture that the image and the texts over it are painted on.
pub struct Canvas {
    texture: wgpu::Texture,
    painter: UiPainter,
}

impl Canvas {
    /// Of a size \[pixels\].
    pub fn new(gpu: &Gpu, [width, height]: [u32; 2]) -> Self {
        let format = wgpu::TextureFormat::Rgba8Unorm;
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("canvas"),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        Self { texture, painter: UiPainter::new(gpu, format) }
    }

    /// Its size \[pixels\].
    pub fn size(&self) -> [u32; 2] {
        [self.texture.width(), self.texture.height()]
    }

    /// The image that texts are drawn over.
    pub fn set_image(&mut self, gpu: &Gpu, texture: Option<&wgpu::Texture>) -> Option<egui::TextureId> {
        self.painter.set_image(gpu, texture);
        self.painter.image()
    }

    /// Paints, and reads the image back: sRGB bytes, three a pixel.
    ///
    /// # Errors
    /// If the device fails.
    pub fn paint(&mut self, gpu: &Gpu, context: &egui::Context, painted: Painted) -> Result<([u32; 2], Vec<u8>)> {
        let size = self.size();
        let target = self.texture.create_view(&wgpu::TextureViewDescriptor::default());
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("canvas") });
        self.painter.paint(gpu, &mut encoder, context, (&target, size), painted);
        gpu.queue.submit([encoder.finish()]);
        let bytes = read_texture(gpu, &self.texture, 0, 0)?;
        Ok((size, bytes.chunks_exact(4).flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect()))
    }
}
