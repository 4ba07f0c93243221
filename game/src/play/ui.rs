//! egui on a window: input in, triangles out.

use lightwell::gpu::Gpu;
use std::time::Duration;
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
    log::trace!(target: WIDGETS, "frame");
}

/// egui on a window.
pub struct UiSurface {
    /// egui.
    pub context: egui::Context,
    state: egui_winit::State,
    renderer: egui_wgpu::Renderer,
    image: Option<(wgpu::Texture, egui::TextureId)>,
}

/// What a run of the interface made, to be painted.
pub struct Painted {
    shapes: Vec<egui::epaint::ClippedShape>,
    textures: egui::TexturesDelta,
    scale: f32,
    /// After which time it wants to run again.
    pub repaint: Duration,
}

impl UiSurface {
    /// For a window that is drawn in `format`.
    pub fn new(gpu: &Gpu, window: &Window, format: wgpu::TextureFormat) -> Self {
        let context = egui::Context::default();
        crate::editor::set_fonts(&context);
        let limit = gpu.limits.max_texture_dimension_2d as usize;
        let scale = Some(window.scale_factor() as f32);
        let state = egui_winit::State::new(context.clone(), egui::ViewportId::ROOT, window, scale, None, Some(limit));
        // Dithering doubles the cost on software drivers, for a smoothness that flat panels do not need.
        let options = egui_wgpu::RendererOptions { dithering: false, ..Default::default() };
        let renderer = egui_wgpu::Renderer::new(&gpu.device, format, options);
        Self { context, state, renderer, image: None }
    }

    /// Takes an event; says whether the interface is to be drawn anew.
    pub fn event(&mut self, window: &Window, event: &WindowEvent) -> bool {
        self.state.on_window_event(window, event).repaint
    }

    /// The picture as the last frame left it.
    pub fn image(&self) -> Option<egui::TextureId> {
        self.image.as_ref().map(|(_, id)| *id)
    }

    /// Shows a texture (rgba8unorm, sRGB-encoded) where the picture is.
    pub fn set_image(&mut self, gpu: &Gpu, texture: Option<&wgpu::Texture>) {
        let Some(texture) = texture else { return };
        if self.image.as_ref().is_some_and(|(known, _)| known == texture) {
            return;
        }
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        let filter = wgpu::FilterMode::Linear;
        let id = match self.image.take() {
            Some((_, id)) => {
                self.renderer.update_egui_texture_from_wgpu_texture(&gpu.device, &view, filter, id);
                id
            }
            None => self.renderer.register_native_texture(&gpu.device, &view, filter),
        };
        self.image = Some((texture.clone(), id));
    }

    /// Runs the interface once.
    pub fn run(&mut self, window: &Window, contents: impl FnMut(&mut egui::Ui)) -> Painted {
        let input = self.state.take_egui_input(window);
        let tells = log::log_enabled!(target: WIDGETS, log::Level::Trace);
        if tells {
            self.context.enable_accesskit();
        }
        let mut output = self.context.run_ui(input, contents);
        if let Some(update) = output.platform_output.accesskit_update.take().filter(|_| tells) {
            tell_widgets(&update, output.pixels_per_point);
        }
        self.state.handle_platform_output(window, output.platform_output);
        let repaint = output.viewport_output.values().map(|v| v.repaint_delay).min().unwrap_or(Duration::MAX);
        Painted { shapes: output.shapes, textures: output.textures_delta, scale: output.pixels_per_point, repaint }
    }

    /// Paints what a run made.
    pub fn paint(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        (target, size): (&wgpu::TextureView, [u32; 2]),
        painted: Painted,
    ) {
        let jobs = self.context.tessellate(painted.shapes, painted.scale);
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
                    ops: wgpu::Operations {
                        load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                        store: wgpu::StoreOp::Store,
                    },
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
