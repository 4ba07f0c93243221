//! The overlay of interactive play: frame time, passes, errors, help.

use egui::{Color32, RichText, Sense, Stroke, Vec2};
use lightwell::gpu::Gpu;
use lightwell::graph::{FrameReport, PassState};
use lightwell::profile::Profiler;
use winit::event::WindowEvent;
use winit::window::Window;

/// Controls, as the help shows them.
const CONTROLS: [(&str, &str); 10] = [
    ("drag left", "look around"),
    ("drag right", "orbit"),
    ("W A S D, Q E", "fly, down and up"),
    ("wheel", "speed of flight"),
    ("C", "back to the scene's camera"),
    ("Space", "pause"),
    (".", "one step"),
    ("+  -", "faster, slower"),
    ("F12", "screenshot"),
    ("F1, Esc", "this help, quit"),
];

/// What the overlay shows.
pub struct Shown<'a> {
    /// Name of the scene.
    pub scene: &'a str,
    /// State of play in words.
    pub state: String,
    /// Times of the last frames.
    pub profiler: &'a Profiler,
    /// The last frame.
    pub report: &'a FrameReport,
    /// What went well, such as a screenshot.
    pub notice: Option<&'a str>,
    /// What is wrong just now.
    pub errors: &'a [String],
    /// Whether help is wanted.
    pub help: bool,
}

/// egui on a window.
pub struct Overlay {
    context: egui::Context,
    state: egui_winit::State,
    renderer: egui_wgpu::Renderer,
}

impl Overlay {
    /// An overlay for a window that is drawn in `format`.
    pub fn new(gpu: &Gpu, window: &Window, format: wgpu::TextureFormat) -> Self {
        let context = egui::Context::default();
        let limit = gpu.limits.max_texture_dimension_2d as usize;
        let scale = Some(window.scale_factor() as f32);
        let state = egui_winit::State::new(context.clone(), egui::ViewportId::ROOT, window, scale, None, Some(limit));
        // Dithering doubles the cost on software drivers, for a smoothness that flat panels do not need.
        let options = egui_wgpu::RendererOptions { dithering: false, ..Default::default() };
        Self { renderer: egui_wgpu::Renderer::new(&gpu.device, format, options), context, state }
    }

    /// Takes an event; says whether it is the overlay's alone, and whether it wants to be drawn anew.
    pub fn event(&mut self, window: &Window, event: &WindowEvent) -> (bool, bool) {
        let response = self.state.on_window_event(window, event);
        (response.consumed, response.repaint)
    }

    /// Draws the overlay over the target; says whether it moves by itself and wants another frame.
    pub fn draw(
        &mut self,
        gpu: &Gpu,
        window: &Window,
        encoder: &mut wgpu::CommandEncoder,
        (target, size): (&wgpu::TextureView, [u32; 2]),
        shown: &Shown,
    ) -> bool {
        let input = self.state.take_egui_input(window);
        let output = self.context.run_ui(input, |ui| contents(ui.ctx(), shown));
        self.state.handle_platform_output(window, output.platform_output);
        let scale = output.pixels_per_point;
        let jobs = self.context.tessellate(output.shapes, scale);
        for (id, deltas) in &output.textures_delta.set {
            for delta in deltas {
                self.renderer.update_texture(&gpu.device, &gpu.queue, *id, delta);
            }
        }
        let screen = egui_wgpu::ScreenDescriptor { size_in_pixels: size, pixels_per_point: scale };
        let buffers = self.renderer.update_buffers(&gpu.device, &gpu.queue, encoder, &jobs, &screen);
        gpu.queue.submit(buffers);
        let mut pass = encoder
            .begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("overlay"),
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: target,
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations { load: wgpu::LoadOp::Load, store: wgpu::StoreOp::Store },
                })],
                ..Default::default()
            })
            .forget_lifetime();
        self.renderer.render(&mut pass, &jobs, &screen);
        drop(pass);
        for id in &output.textures_delta.free {
            self.renderer.free_texture(id);
        }
        output.viewport_output.values().any(|viewport| viewport.repaint_delay.is_zero())
    }
}

fn contents(context: &egui::Context, shown: &Shown) {
    egui::Window::new(format!("Lightwell: {}", shown.scene))
        .id(egui::Id::unique("frame"))
        .default_pos([8.0, 8.0])
        .resizable(false)
        .show(context, |ui| {
            frame_times(ui, shown.profiler);
            ui.label(&shown.state);
            if let Some(notice) = shown.notice {
                ui.label(notice);
            }
            ui.collapsing("Passes", |ui| passes(ui, shown.report));
            ui.label(RichText::new("F1: help").weak());
        });
    if shown.help {
        egui::Window::new("Help").anchor(egui::Align2::RIGHT_TOP, [-8.0, 8.0]).resizable(false).show(context, |ui| {
            egui::Grid::new("controls").show(ui, |ui| {
                for (key, meaning) in CONTROLS {
                    ui.strong(key);
                    ui.label(meaning);
                    ui.end_row();
                }
            });
        });
    }
    if !shown.errors.is_empty() {
        egui::Window::new(RichText::new("Errors; the last good version is running").color(ERROR))
            .id(egui::Id::unique("errors"))
            .anchor(egui::Align2::LEFT_BOTTOM, [8.0, -8.0])
            .resizable(false)
            .default_width((context.content_rect().width() - 32.0).clamp(100.0, 860.0))
            .show(context, |ui| {
                for error in shown.errors {
                    ui.label(RichText::new(error).monospace().color(ERROR));
                }
            });
    }
}

const ERROR: Color32 = Color32::from_rgb(255, 120, 100);

/// The time of the last frames as a number and as a curve from zero to the longest.
fn frame_times(ui: &mut egui::Ui, profiler: &Profiler) {
    const SIZE: Vec2 = Vec2::new(220.0, 36.0);
    let Some(statistics) = profiler.frame_statistics() else { return };
    let text = format!("{:.1} ms  (median; longest {:.1})", statistics.median, statistics.max);
    ui.monospace(text);
    let (response, painter) = ui.allocate_painter(SIZE, Sense::hover());
    let area = response.rect;
    painter.rect_filled(area, 2.0, Color32::from_black_alpha(96));
    let top = statistics.max.max(1e-3);
    let skipped = profiler.frames().len().saturating_sub(SIZE.x as usize);
    let points = profiler.frames().skip(skipped).enumerate().map(|(i, frame)| {
        let height = (frame.duration / top) as f32 * (area.height() - 2.0);
        egui::pos2(area.left() + i as f32, area.bottom() - 1.0 - height)
    });
    painter.line(points.collect(), Stroke::new(1.0, Color32::from_rgb(120, 200, 255)));
}

fn passes(ui: &mut egui::Ui, report: &FrameReport) {
    egui::Grid::new("passes").striped(true).show(ui, |ui| {
        for pass in &report.passes {
            let strong = pass.state == PassState::Ran;
            let text = |text: String| if strong { RichText::new(text) } else { RichText::new(text).weak() };
            ui.label(text(pass.name.clone())).on_hover_text(&pass.why);
            ui.label(text(pass.state.to_string()));
            ui.label(text(pass.gpu_ms.map_or(String::new(), |ms| format!("{ms:.2} ms"))));
            ui.end_row();
        }
    });
}
