//! Painting what egui makes, on a window or on a texture.

use super::damage;
use egui::TextureId;
use egui::epaint::ClippedShape;
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
    /// Of its targets.
    format: wgpu::TextureFormat,
    image: Option<(wgpu::Texture, egui::TextureId)>,
    overlay: Option<(wgpu::Texture, egui::TextureId)>,
    background: wgpu::Color,
    /// What was painted last on a window, and the textures whose contents changed since.
    last: Option<Last>,
    touched: Vec<TextureId>,
}

/// An interface as it was painted on a window.
struct Last {
    shapes: Vec<ClippedShape>,
    size: [u32; 2],
    scale: f32,
    /// The same as pixels; none: it was painted on the window itself.
    pixels: Option<wgpu::Texture>,
}

impl UiPainter {
    /// For targets of a format.
    pub fn new(gpu: &Gpu, format: wgpu::TextureFormat) -> Self {
        // Dithering doubles the cost on software drivers, for a smoothness that flat panels do not need.
        let options = egui_wgpu::RendererOptions { dithering: false, ..Default::default() };
        let renderer = egui_wgpu::Renderer::new(&gpu.device, format, options);
        let (background, touched) = (wgpu::Color::BLACK, Vec::new());
        Self { renderer, format, image: None, overlay: None, background, last: None, touched }
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
            let shown = self.shown(gpu, texture, known);
            self.touched.push(shown.1);
            self.image = Some(shown);
        }
    }

    /// Makes another texture known, which holds colours times their opacity; gives what it is called.
    pub fn set_overlay(&mut self, gpu: &Gpu, texture: &wgpu::Texture) -> egui::TextureId {
        let known = self.overlay.take();
        let shown = self.shown(gpu, texture, known);
        let id = shown.1;
        self.overlay = Some(shown);
        self.touch_overlay();
        id
    }

    /// Takes note that the contents of that texture changed.
    pub fn touch_overlay(&mut self) {
        self.touched.extend(self.overlay.as_ref().map(|(_, id)| *id));
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
        target: (&wgpu::TextureView, [u32; 2]),
        painted: Painted,
    ) {
        self.take_textures(gpu, &painted.textures);
        let load = wgpu::LoadOp::Clear(self.background);
        self.paint_shapes(gpu, encoder, context, target, (painted.shapes, painted.scale), load);
        self.free_textures(&painted.textures);
    }

    /// Paints what a run made on the image of a window, which can be copied to. Where drivers draw in software, only what
    /// changed since the last time is painted, over a copy of what was painted then.
    pub fn paint_window(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        context: &egui::Context,
        (window, view): (&wgpu::Texture, &wgpu::TextureView),
        painted: Painted,
    ) {
        let size = [window.width(), window.height()];
        // What a game lays over the view lets the picture through: then all is painted.
        let can_copy =
            gpu.is_software() && self.overlay.is_none() && window.usage().contains(wgpu::TextureUsages::COPY_DST);
        let before = self.last.take().filter(|last| last.size == size && last.scale == painted.scale);
        // New letters in the atlas of fonts change nothing that is painted.
        let is_known = painted
            .textures
            .set
            .iter()
            .all(|(id, deltas)| *id == TextureId::default() && deltas.iter().all(|delta| !delta.is_whole()));
        let touched = std::mem::take(&mut self.touched);
        let parts = before
            .as_ref()
            .filter(|_| can_copy && is_known)
            .and_then(|before| damage::between(&before.shapes, &painted.shapes, &touched, (size, painted.scale)));
        let pixels = before.and_then(|before| before.pixels).filter(|_| parts.is_some());
        let last = Last { shapes: painted.shapes.clone(), size, scale: painted.scale, pixels: None };
        let Some(parts) = parts else {
            self.paint(gpu, encoder, context, (view, size), painted);
            self.last = Some(last);
            return;
        };
        self.take_textures(gpu, &painted.textures);
        let (shapes, load) = match &pixels {
            Some(_) => (damage::shapes(&painted.shapes, &parts, egui::Color32::BLACK), wgpu::LoadOp::Load),
            None => (painted.shapes, wgpu::LoadOp::Clear(self.background)),
        };
        let pixels = pixels.unwrap_or_else(|| kept(gpu, window, self.format));
        let target = pixels.create_view(&wgpu::TextureViewDescriptor::default());
        if !shapes.is_empty() {
            self.paint_shapes(gpu, encoder, context, (&target, size), (shapes, painted.scale), load);
        }
        encoder.copy_texture_to_texture(pixels.as_image_copy(), window.as_image_copy(), window.size());
        self.free_textures(&painted.textures);
        self.last = Some(Last { pixels: Some(pixels), ..last });
    }

    fn take_textures(&mut self, gpu: &Gpu, textures: &egui::TexturesDelta) {
        for (id, deltas) in &textures.set {
            for delta in deltas {
                self.renderer.update_texture(&gpu.device, &gpu.queue, *id, delta);
            }
        }
    }

    fn free_textures(&mut self, textures: &egui::TexturesDelta) {
        for id in &textures.free {
            self.renderer.free_texture(id);
        }
    }

    fn paint_shapes(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        context: &egui::Context,
        (target, size): (&wgpu::TextureView, [u32; 2]),
        (shapes, scale): (Vec<ClippedShape>, f32),
        load: wgpu::LoadOp<wgpu::Color>,
    ) {
        let jobs = context.tessellate(shapes, scale);
        let screen = egui_wgpu::ScreenDescriptor { size_in_pixels: size, pixels_per_point: scale };
        let buffers = self.renderer.update_buffers(&gpu.device, &gpu.queue, encoder, &jobs, &screen);
        gpu.queue.submit(buffers);
        let mut pass = encoder
            .begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("interface"),
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: target,
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations { load, store: wgpu::StoreOp::Store },
                })],
                ..Default::default()
            })
            .forget_lifetime();
        self.renderer.render(&mut pass, &jobs, &screen);
    }
}

/// A texture for what was painted on a window.
fn kept(gpu: &Gpu, window: &wgpu::Texture, format: wgpu::TextureFormat) -> wgpu::Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("interface"),
        size: window.size(),
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use egui::{Color32, Pos2, Rect, Shape, Vec2, pos2};
    use lightwell::gpu::{GpuOptions, read_texture};

    const SIZE: [u32; 2] = [160, 96];
    const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

    fn texture(gpu: &Gpu, [width, height]: [u32; 2]) -> wgpu::Texture {
        gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("window"),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: FORMAT,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT
                | wgpu::TextureUsages::TEXTURE_BINDING
                | wgpu::TextureUsages::COPY_SRC
                | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        })
    }

    fn fill(gpu: &Gpu, texture: &wgpu::Texture, seed: u8) {
        let count = 4 * texture.width() * texture.height();
        let byte = |i: u32| if i % 4 == 3 { 255 } else { (i as u8).wrapping_mul(37).wrapping_add(seed) };
        let bytes: Vec<u8> = (0..count).map(byte).collect();
        let layout =
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(4 * texture.width()), rows_per_image: None };
        gpu.queue.write_texture(texture.as_image_copy(), &bytes, layout, texture.size());
    }

    fn rect(at: [f32; 4]) -> Rect {
        Rect::from_min_size(pos2(at[0], at[1]), Vec2::new(at[2], at[3]))
    }

    /// Panels around a picture, with a mark that moves, one that comes and goes, and soft edges over the picture.
    fn interface(picture: TextureId, step: usize) -> Vec<ClippedShape> {
        let screen = rect([0.0, 0.0, 160.0, 96.0]);
        let whole = Rect::from_min_max(Pos2::ZERO, pos2(1.0, 1.0));
        let at = 8.3 * step as f32;
        let mut shapes = vec![
            Shape::rect_filled(screen, 0.0, Color32::from_gray(27)),
            Shape::image(picture, rect([60.0, 20.0, 40.0, 30.0]), whole, Color32::WHITE),
            Shape::circle_filled(pos2(70.5 + at, 40.2), 9.7, Color32::from_rgba_unmultiplied(200, 90, 20, 120)),
            Shape::line_segment([pos2(58.0, 18.0), pos2(102.0, 52.0)], (1.3, Color32::LIGHT_BLUE)),
            Shape::rect_filled(rect([4.0 + at, 70.0, 11.5, 7.3]), 2.0, Color32::GREEN),
        ];
        if step % 2 == 1 {
            shapes.insert(4, Shape::circle_filled(pos2(140.0, 12.0), 6.0, Color32::RED));
        }
        shapes.into_iter().map(|shape| ClippedShape::new(screen, shape)).collect()
    }

    #[test]
    fn a_window_of_which_only_what_changed_is_painted_has_the_same_pixels() {
        let gpu = Gpu::headless(&GpuOptions::default()).unwrap();
        let context = egui::Context::default();
        let _ = context.run_ui(egui::RawInput::default(), |_| {});
        for scale in [1.0, 1.5] {
            let size = SIZE.map(|edge| (edge as f32 * scale) as u32);
            let picture = texture(&gpu, [16, 12]);
            let mut painters = [UiPainter::new(&gpu, FORMAT), UiPainter::new(&gpu, FORMAT)];
            let windows = [texture(&gpu, size), texture(&gpu, size)];
            let mut kept = 0;
            for step in 0..7 {
                // In every other frame the picture is another one.
                if step % 2 == 0 {
                    fill(&gpu, &picture, 11 * step as u8);
                    painters.iter_mut().for_each(|painter| painter.set_image(&gpu, Some(&picture)));
                }
                for (painter, window) in painters.iter_mut().zip(&windows) {
                    let shapes = interface(painter.image().unwrap(), step);
                    let textures = egui::TexturesDelta::default();
                    let painted = Painted { shapes, textures, scale, repaint: Duration::MAX };
                    let view = window.create_view(&wgpu::TextureViewDescriptor::default());
                    let mut encoder = gpu.device.create_command_encoder(&Default::default());
                    painter.paint_window(&gpu, &mut encoder, &context, (window, &view), painted);
                    gpu.queue.submit([encoder.finish()]);
                }
                kept += usize::from(painters[0].last.as_ref().is_some_and(|last| last.pixels.is_some()));
                // The other one paints everything each time.
                painters[1].last = None;
                let [found, wanted] = windows.each_ref().map(|window| read_texture(&gpu, window, 0, 0).unwrap());
                assert!(found == wanted, "frame {step} at scale {scale}");
            }
            assert_eq!(kept > 3, gpu.is_software(), "software paints parts");
        }
    }
}
