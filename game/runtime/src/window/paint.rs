//! Painting what egui makes, on a window or on a texture.

use lightwell::gpu::Gpu;
use std::time::Duration;

/// What a run of the interface made, to be painted.
pub struct Painted {
    pub(super) shapes: Vec<egui::epaint::ClippedShape>,
    pub(super) textures: egui::TexturesDelta,
    pub(super) scale: f32,
    /// After which time it wants to run again.
    pub repaint: Duration,
}

impl Painted {
    /// What egui gave out.
    pub fn new(output: &mut egui::FullOutput) -> Self {
        let repaint = output.viewport_output.values().map(|v| v.repaint_delay).min().unwrap_or(Duration::MAX);
        Self {
            shapes: std::mem::take(&mut output.shapes),
            textures: std::mem::take(&mut output.textures_delta),
            scale: output.pixels_per_point,
            repaint,
        }
    }

    /// The same over a picture that fills the screen.
    pub fn over(image: Option<egui::TextureId>, screen: egui::Rect, output: &mut egui::FullOutput) -> Self {
        let mut painted = Self::new(output);
        if let Some(image) = image {
            let whole = egui::Rect::from_min_max(egui::pos2(0.0, 0.0), egui::pos2(1.0, 1.0));
            let shape = egui::Shape::image(image, screen, whole, egui::Color32::WHITE);
            painted.shapes.insert(
                0,
                egui::epaint::ClippedShape {
                    clip_rect: screen,
                    shape,
                    transform_after_tessellation: Default::default(),
                },
            );
        }
        painted
    }
}

/// Paints with the device.
pub struct UiPainter {
    renderer: egui_wgpu::Renderer,
    image: Option<(wgpu::Texture, egui::TextureId)>,
    overlay: Option<(wgpu::Texture, egui::TextureId)>,
    background: wgpu::Color,
}

impl UiPainter {
    /// For targets of a format.
    pub fn new(gpu: &Gpu, format: wgpu::TextureFormat) -> Self {
        // Dithering doubles the cost on software drivers, for a smoothness that flat panels do not need.
        let options = egui_wgpu::RendererOptions { dithering: false, ..Default::default() };
        let renderer = egui_wgpu::Renderer::new(&gpu.device, format, options);
        Self { renderer, image: None, overlay: None, background: wgpu::Color::BLACK }
    }

    /// The same, over nothing: what is not painted stays transparent.
    pub fn transparent(gpu: &Gpu, format: wgpu::TextureFormat) -> Self {
        Self { background: wgpu::Color::TRANSPARENT, ..Self::new(gpu, format) }
    }

    /// The picture as the last frame left it.
    pub fn image(&self) -> Option<egui::TextureId> {
        self.image.as_ref().map(|(_, id)| *id)
    }

    /// Shows a texture (rgba8unorm, sRGB-encoded) where the picture is.
    pub fn set_image(&mut self, gpu: &Gpu, texture: Option<&wgpu::Texture>) {
        if let Some(texture) = texture {
            let known = self.image.take();
            self.image = Some(self.shown(gpu, texture, known));
        }
    }

    /// Makes another texture known, which holds colours times their opacity; gives what it is called.
    pub fn set_overlay(&mut self, gpu: &Gpu, texture: &wgpu::Texture) -> egui::TextureId {
        let known = self.overlay.take();
        let shown = self.shown(gpu, texture, known);
        let id = shown.1;
        self.overlay = Some(shown);
        id
    }

    /// A texture with its name, which stays that of the one before.
    fn shown(
        &mut self,
        gpu: &Gpu,
        texture: &wgpu::Texture,
        known: Option<(wgpu::Texture, egui::TextureId)>,
    ) -> (wgpu::Texture, egui::TextureId) {
        let filter = wgpu::FilterMode::Linear;
        let view = || texture.create_view(&wgpu::TextureViewDescriptor::default());
        let id = match known {
            Some((before, id)) if before == *texture => id,
            Some((_, id)) => {
                self.renderer.update_egui_texture_from_wgpu_texture(&gpu.device, &view(), filter, id);
                id
            }
            None => self.renderer.register_native_texture(&gpu.device, &view(), filter),
        };
        (texture.clone(), id)
    }

    /// Paints what a run made.
    pub fn paint(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        context: &egui::Context,
        (target, size): (&wgpu::TextureView, [u32; 2]),
        painted: Painted,
    ) {
        let jobs = context.tessellate(painted.shapes, painted.scale);
        for (id, deltas) in &painted.textures.set {
            for delta in deltas {
                self.renderer.update_texture(&gpu.device, &gpu.queue, *id, delta);
            }
        }
        let screen = egui_wgpu::ScreenDescriptor { size_in_pixels: size, pixels_per_point: painted.scale };
        let buffers = self.renderer.update_buffers(&gpu.device, &gpu.queue, encoder, &jobs, &screen);
        gpu.queue.submit(buffers);
        let mut pass = encoder
            .begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("interface"),
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: target,
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations { load: wgpu::LoadOp::Clear(self.background), store: wgpu::StoreOp::Store },
                })],
                ..Default::default()
            })
            .forget_lifetime();
        self.renderer.render(&mut pass, &jobs, &screen);
        drop(pass);
        for id in &painted.textures.free {
            self.renderer.free_texture(id);
        }
    }
}
