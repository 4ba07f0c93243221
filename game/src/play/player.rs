//! A scene that is playing in a window.

use super::Own;
use super::export::Job;
use super::memory::Memory;
use super::meter::Meter;
use super::paint::Painted;
use super::screen::Screen;
use super::ui::UiSurface;
use super::watch::{Change, SceneWatcher};
use crate::cli::{Common, PlayArgs};
use crate::editor::camera::FlyCamera;
use crate::editor::clock::PlayClock;
use crate::editor::{Editor, Facts, Request, Stage, Tracing, console};
use crate::session::{self, Session};
use anyhow::{Result, bail};
use lightwell::graph::FrameReport;
use lightwell::profile::{FrameRecorder, Profiler};
use lightwell::render::GiMethod;
use lightwell::scene::{SceneCamera, SceneView};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};
use winit::event::WindowEvent;
use winit::event_loop::ActiveEventLoop;
use winit::window::Window;

/// A scene that is playing in a window.
pub struct Player {
    pub(super) window: Arc<Window>,
    pub(super) session: Session,
    pub(super) screen: Screen,
    pub(super) ui: UiSurface,
    pub(super) watcher: SceneWatcher,
    pub(super) editor: Editor,
    pub(super) clock: PlayClock,
    pub(super) camera: FlyCamera,
    pub(super) memory: Memory,
    pub(super) memory_file: Option<PathBuf>,
    pub(super) last_frame: Instant,
    pub(super) profiler: Profiler,
    pub(super) report: FrameReport,
    /// Why the scene's file cannot be loaded anew.
    pub(super) scene_error: Option<String>,
    /// Why the last frame was not drawn.
    pub(super) frame_error: Option<String>,
    /// Something changed that no frame shows yet.
    pub(super) stale: bool,
    /// When the interface wants to run again.
    pub(super) repaint_at: Option<Instant>,
    pub(super) ended: bool,
    pub(super) job: Option<Job>,
    pub(super) meter: Meter,
    /// Version of the history up to which parts are watched.
    pub(super) followed: u64,
}

impl Player {
    /// Opens device and scene for a window.
    ///
    /// # Errors
    /// If the scene cannot be loaded or nothing can draw on the window.
    pub fn open(
        event_loop: &ActiveEventLoop,
        window: Window,
        args: &PlayArgs,
        common: &Common,
        memory: Memory,
        own: &Own,
    ) -> Result<Self> {
        let window = Arc::new(window);
        let (gpu, screen) = Screen::open(event_loop, Arc::clone(&window), &session::gpu_options(common)?)?;
        let ui = UiSurface::new(&gpu, &window, screen.format());
        let session = Session::open_with(gpu, &args.scene, &args.look, common, own.types.clone())?;
        lightwell::files::remove_leftovers(session.path());
        let mut player = Self {
            watcher: SceneWatcher::new(session.path(), &session.files()),
            clock: PlayClock::new(&session.settings()),
            window,
            session,
            screen,
            ui,
            editor: Editor::default(),
            camera: FlyCamera::default(),
            memory,
            memory_file: Memory::file(),
            last_frame: Instant::now(),
            profiler: Profiler::new(),
            report: FrameReport::default(),
            scene_error: None,
            frame_error: None,
            stale: true,
            repaint_at: None,
            ended: false,
            job: None,
            meter: Meter::default(),
            followed: 0,
        };
        player.editor.set_own(own.components.clone());
        player.recall();
        player.opened();
        Ok(player)
    }

    /// Takes an event of the window; false if play shall end.
    ///
    /// # Errors
    /// If the device is lost.
    pub fn event(&mut self, event: &WindowEvent) -> Result<bool> {
        match event {
            WindowEvent::RedrawRequested => self.draw()?,
            WindowEvent::CloseRequested => {
                self.editor.ask(Request::Quit);
                self.stale = true;
            }
            event => {
                self.stale |= self.ui.event(&self.window, event);
                self.stale |= matches!(event, WindowEvent::Resized(_) | WindowEvent::ScaleFactorChanged { .. });
            }
        }
        Ok(!self.ended)
    }

    /// Takes up changed files, and asks for a frame if there is something new to show; says whether there is.
    pub fn poll(&mut self) -> bool {
        // The library logs what it reloads and what is broken; the panels show the latter.
        self.stale |= !self.session.gpu.shaders.poll().is_empty();
        // Edits may have brought models and prefabs.
        if std::mem::replace(&mut self.followed, self.editor.history.version) != self.editor.history.version {
            self.watcher.follow(&self.session.files());
        }
        if let Some(change) = self.watcher.changed() {
            self.stale = true;
            if let Some(request) = self.editor.file_changed(part_name(&change)) {
                self.answer(request);
            }
        }
        if self.repaint_at.is_some_and(|at| at <= Instant::now()) {
            self.repaint_at = None;
            self.stale = true;
        }
        let busy = self.stale || self.clock.playing || self.job.is_some();
        let visible = self.screen.size().is_some();
        if busy && visible {
            self.window.request_redraw();
        }
        busy && visible
    }

    /// Draws and presents a frame.
    fn draw(&mut self) -> Result<()> {
        let elapsed = self.last_frame.elapsed().as_secs_f64();
        self.last_frame = Instant::now();
        if self.screen.size().is_none() {
            return Ok(());
        }
        self.stale = false;
        self.clock.advance(elapsed);
        let mut frame = FrameRecorder::begin();
        let (painted, requests) = frame.span("interface", |_| self.interface());
        for request in requests {
            let is_save = request == Request::Save;
            self.answer(request);
            // What would lose edits waits for them to be saved, under whatever name.
            if is_save && self.editor.history.is_dirty() {
                break;
            }
        }
        self.continue_export();
        let origin = self.session.scene().origin;
        frame.span("update", |_| self.session.set_ticks(self.clock.ticks()));
        self.camera.rebase((self.session.scene().origin - origin).as_vec3());
        let wanted = if self.editor.view.is_shown { self.editor.view.size } else { [0; 2] };
        if wanted[0] > 0 {
            frame.span("render", |_| self.render(wanted));
        }
        for pass in &self.report.passes {
            if let Some(time) = pass.gpu_ms {
                frame.gpu(&pass.name, time);
            }
        }
        if let Some(reason) = self.session.gpu.device_lost() {
            bail!("the graphics device was lost: {reason}");
        }
        frame.span("present", |_| self.present(painted))?;
        self.profiler.push(frame.finish());
        Ok(())
    }

    /// Runs the panels.
    fn interface(&mut self) -> (Painted, Vec<Request>) {
        let (errors, log, name) = (self.errors(), console::records(), self.session.name());
        let adapter = self.session.gpu.info.name.clone();
        let scene_camera = self.session.camera().ok();
        let image_size = self.session.display_texture().map_or([1; 2], |t| [t.width(), t.height()]);
        let tracing = self.session.tracing().map(|(samples, target)| Tracing { samples, target });
        let image = self.ui.image();
        let parts = self.session.parts();
        let mut stage = Stage {
            world: parts.world,
            files: parts.files,
            look: parts.look,
            display: parts.display,
            comparison: parts.comparison,
            clock: &mut self.clock,
            camera: &mut self.camera,
            facts: Facts {
                name: &name,
                scene: parts.scene,
                report: &self.report,
                profiler: &self.profiler,
                errors: &errors,
                log: &log,
                scene_camera,
                image,
                image_size,
                tracing,
                live_error: self.meter.error,
                adapter: &adapter,
            },
        };
        let mut requests = Vec::new();
        let size_before = self.editor.view.size;
        let painted = self.ui.run(&self.window, |ui| requests.extend(self.editor.show(ui, &mut stage)));
        match painted.repaint {
            Duration::ZERO => self.stale = true,
            Duration::MAX => {}
            later => self.repaint_at = Instant::now().checked_add(later),
        }
        // The picture of the new size comes with the next frame.
        self.stale |= self.editor.view.size != size_before;
        (painted, requests)
    }

    /// The camera that is drawn with.
    pub(super) fn eye(&self) -> Result<SceneCamera> {
        Ok(self.camera.apply(&self.session.camera()?))
    }

    fn render(&mut self, size: [u32; 2]) {
        let result = self.eye().and_then(|camera| {
            let limit = self.session.gpu.limits.max_texture_dimension_2d;
            let view = SceneView { camera, size: size.map(|edge| edge.min(limit)), jitter: [0.0; 2] };
            let mut settings = self.session.display_settings();
            settings.debug.outlined = self.editor.outlined(self.session.world());
            if let GiMethod::Reference(reference) = &mut settings.gi {
                // One sample a frame: the image gets better while it is looked at.
                reference.samples_a_frame = 1;
            }
            let report = self.session.render(&view, &settings)?;
            self.meter.read(&mut self.session, &view)?;
            Ok(report)
        });
        if let Some(later) = self.meter.due() {
            self.repaint_at = Some(self.repaint_at.map_or(later, |at| at.min(later)));
        }
        self.stale |= self.session.is_tracing();
        match result {
            Ok(report) => {
                self.report = report;
                self.frame_error = None;
            }
            Err(error) => {
                let text = format!("{error:#}");
                if self.frame_error.as_ref() != Some(&text) {
                    log::error!("{text}");
                }
                self.frame_error = Some(text);
            }
        }
        self.stale |= self.ui.image().is_none();
        self.ui.set_image(&self.session.gpu, self.session.display_texture());
    }

    fn present(&mut self, painted: Painted) -> Result<()> {
        let gpu = self.session.gpu.clone();
        self.stale |= !self.ui.present(&gpu, &mut self.screen, &self.window, painted)?;
        Ok(())
    }

    fn errors(&self) -> Vec<String> {
        let shaders = self.session.gpu.shaders.errors().into_iter().map(|error| error.to_string());
        let mut errors: Vec<String> = self.scene_error.iter().cloned().chain(shaders).collect();
        // A frame that fails for a broken shader says the same once more.
        if errors.is_empty() {
            errors.extend(self.frame_error.clone());
        }
        errors
    }
}

/// The file that changed, if it is not the scene's own.
fn part_name(change: &Change) -> Option<String> {
    match change {
        Change::Scene => None,
        Change::Part(path) => path.file_name().map(|name| name.to_string_lossy().into_owned()),
    }
}
