//! egui on a window: input in, triangles out.

use super::paint::{Painted, UiPainter};
use super::screen::Screen;
use anyhow::Result;
use lightwell::gpu::Gpu;
use winit::event::WindowEvent;
use winit::window::Window;

/// Log of where every widget with a name is, for programs that drive the window from outside: with
/// `RUST_LOG=lightwell::widgets=trace`.
const WIDGETS: &str = "lightwell::widgets";

fn tell_widgets(update: &egui::accesskit::TreeUpdate, scale: f32) {
    for (_, node) in &update.nodes {
        let name = node.label().or(node.value());
        if let Some((name, bounds)) = name.zip(node.bounds()) {
            let [x0, y0, x1, y1] =
                [bounds.x0, bounds.y0, bounds.x1, bounds.y1].map(|edge| (edge * f64::from(scale)).round());
            log::trace!(target: WIDGETS, "{x0} {y0} {x1} {y1} {:?} {name}", node.role());
        }
    }
    let focused = update.nodes.iter().find(|(id, _)| *id == update.focus);
    if let Some(name) = focused.and_then(|(_, node)| node.label().or(node.value())) {
        log::trace!(target: WIDGETS, "focus {name}");
    }
    log::trace!(target: WIDGETS, "frame");
}

/// egui on a window.
pub struct UiSurface {
    /// egui.
    pub context: egui::Context,
    state: egui_winit::State,
    painter: UiPainter,
}

impl UiSurface {
    /// For a window that is drawn in `format`.
    pub fn new(gpu: &Gpu, window: &Window, format: wgpu::TextureFormat, context: egui::Context) -> Self {
        let limit = gpu.limits.max_texture_dimension_2d as usize;
        let scale = Some(window.scale_factor() as f32);
        let state = egui_winit::State::new(context.clone(), egui::ViewportId::ROOT, window, scale, None, Some(limit));
        Self { context, state, painter: UiPainter::new(gpu, format) }
    }

    /// Takes an event; says whether the interface is to be drawn anew.
    pub fn event(&mut self, window: &Window, event: &WindowEvent) -> bool {
        self.state.on_window_event(window, event).repaint
    }

    /// The picture as the last frame left it.
    pub fn image(&self) -> Option<egui::TextureId> {
        self.painter.image()
    }

    /// Shows a texture (rgba8unorm, sRGB-encoded) where the picture is.
    pub fn set_image(&mut self, gpu: &Gpu, texture: Option<&wgpu::Texture>) {
        self.painter.set_image(gpu, texture);
    }

    /// Makes another texture known, see [`UiPainter::set_overlay`].
    pub fn set_overlay(&mut self, gpu: &Gpu, texture: &wgpu::Texture) -> egui::TextureId {
        self.painter.set_overlay(gpu, texture)
    }

    /// Takes note that the contents of that texture changed.
    pub fn touch_overlay(&mut self) {
        self.painter.touch_overlay();
    }

    /// What a pass of egui begins with.
    pub fn input(&mut self, window: &Window) -> egui::RawInput {
        self.state.take_egui_input(window)
    }

    /// What a pass made, over the picture.
    pub fn over_image(&mut self, window: &Window, screen: egui::Rect, output: &mut egui::FullOutput) -> Painted {
        self.state.handle_platform_output(window, std::mem::take(&mut output.platform_output));
        Painted::over(self.image(), screen, output)
    }

    /// Runs the interface once.
    pub fn run(&mut self, window: &Window, contents: impl FnMut(&mut egui::Ui)) -> Painted {
        let input = self.input(window);
        let tells = log::log_enabled!(target: WIDGETS, log::Level::Trace);
        if tells {
            self.context.enable_accesskit();
        }
        let mut output = self.context.run_ui(input, contents);
        if let Some(update) = output.platform_output.accesskit_update.take().filter(|_| tells) {
            tell_widgets(&update, output.pixels_per_point);
        }
        self.state.handle_platform_output(window, std::mem::take(&mut output.platform_output));
        Painted::new(&mut output)
    }

    /// Paints on the window what a pass made; false if there is nothing to paint on just now.
    ///
    /// # Errors
    /// If the surface was lost and cannot be made anew.
    pub fn present(&mut self, gpu: &Gpu, screen: &mut Screen, window: &Window, painted: Painted) -> Result<bool> {
        let Some(frame) = screen.acquire(gpu)? else { return Ok(false) };
        let target = screen.view(&frame);
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("present") });
        self.painter.paint_window(gpu, &mut encoder, &self.context, (&frame.texture, &target), painted);
        gpu.queue.submit([encoder.finish()]);
        window.pre_present_notify();
        gpu.queue.present(frame);
        Ok(true)
    }
}
