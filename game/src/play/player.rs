//! A scene that is playing in a window.

use super::camera::FlyCamera;
use super::clock::PlayClock;
use super::input::{Action, Input};
use super::overlay::{Overlay, Shown};
use super::screen::Screen;
use super::watch::SceneWatcher;
use crate::cli::{Common, PlayArgs};
use crate::session::{self, Session};
use anyhow::{Context, Result, bail};
use glam::Vec3;
use lightwell::graph::FrameReport;
use lightwell::measure;
use lightwell::profile::{FrameRecorder, Profiler};
use lightwell::render::GiMethod;
use lightwell::scene::SceneView;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;
use winit::event::WindowEvent;
use winit::event_loop::ActiveEventLoop;
use winit::window::Window;

/// A scene that is playing in a window.
pub struct Player {
    window: Arc<Window>,
    session: Session,
    screen: Screen,
    overlay: Overlay,
    watcher: SceneWatcher,
    input: Input,
    clock: PlayClock,
    camera: FlyCamera,
    /// Speed of flight relative to the scene's setting.
    flight_speed: f32,
    last_frame: Instant,
    profiler: Profiler,
    report: FrameReport,
    help: bool,
    notice: Option<String>,
    /// Why the scene's file cannot be loaded anew.
    scene_error: Option<String>,
    /// Why the last frame was not drawn.
    frame_error: Option<String>,
    /// Something changed that no frame shows yet.
    stale: bool,
}

impl Player {
    /// Opens device and scene for a window.
    ///
    /// # Errors
    /// If the scene cannot be loaded or nothing can draw on the window.
    pub fn open(event_loop: &ActiveEventLoop, window: Window, args: &PlayArgs, common: &Common) -> Result<Self> {
        let window = Arc::new(window);
        let (gpu, screen) = Screen::open(event_loop, Arc::clone(&window), &session::gpu_options(common)?)?;
        let overlay = Overlay::new(&gpu, &window, screen.format());
        let session = Session::open(gpu, &args.scene, &args.look, common)?;
        window.set_title(&format!("{} - Lightwell", session.name()));
        Ok(Self {
            watcher: SceneWatcher::new(session.path()),
            clock: PlayClock::new(&session.settings()),
            window,
            session,
            screen,
            overlay,
            input: Input::default(),
            camera: FlyCamera::default(),
            flight_speed: 1.0,
            last_frame: Instant::now(),
            profiler: Profiler::new(),
            report: FrameReport::default(),
            help: false,
            notice: None,
            scene_error: None,
            frame_error: None,
            stale: true,
        })
    }

    /// Takes an event of the window; false if play shall end.
    ///
    /// # Errors
    /// If the device is lost.
    pub fn event(&mut self, event: &WindowEvent) -> Result<bool> {
        if *event == WindowEvent::RedrawRequested {
            self.draw()?;
            return Ok(true);
        }
        let (over_ui, repaint) = self.overlay.event(&self.window, event);
        self.stale |= repaint || matches!(event, WindowEvent::Resized(_) | WindowEvent::ScaleFactorChanged { .. });
        match self.input.take(event, over_ui) {
            Some(Action::Quit) => return Ok(false),
            Some(action) => self.act(action),
            None => {}
        }
        Ok(*event != WindowEvent::CloseRequested)
    }

    fn act(&mut self, action: Action) {
        self.stale = true;
        match action {
            Action::Pause => self.clock.playing = !self.clock.playing,
            Action::Step => self.clock.step(),
            Action::Speed(by) => self.clock.change_speed(by),
            Action::SceneCamera => self.camera.reset(),
            Action::Help => self.help = !self.help,
            Action::Screenshot => {
                let saved = self.save_screenshot();
                self.notice = Some(match saved {
                    Ok(path) => format!("saved {}", path.display()),
                    Err(error) => format!("no screenshot: {error:#}"),
                });
            }
            Action::Quit => {}
        }
    }

    fn save_screenshot(&self) -> Result<PathBuf> {
        let folder = Path::new("out");
        std::fs::create_dir_all(folder).context("cannot make the folder out")?;
        let name = self.session.name();
        let files = (1..10_000).map(|number| folder.join(format!("{name}_screenshot_{number:04}.png")));
        let path = files.into_iter().find(|path| !path.exists()).context("the folder out is full of screenshots")?;
        let (size, rgb) = self.session.display_bytes()?;
        measure::write_png_rgb8(&path, size, &rgb)?;
        say!("saved {}", path.display());
        Ok(path)
    }

    /// Takes up changed files, and asks for a frame if there is something new to show; says whether there is.
    pub fn poll(&mut self) -> bool {
        // The library logs what it reloads and what is broken; the overlay shows the latter.
        self.stale |= !self.session.gpu.shaders.poll().is_empty();
        if self.watcher.changed() {
            self.reload();
        }
        let busy = self.stale || self.clock.playing || self.input.flight() != Vec3::ZERO;
        let visible = self.screen.size().is_some();
        if busy && visible {
            self.window.request_redraw();
        }
        busy && visible
    }

    fn reload(&mut self) {
        self.stale = true;
        self.scene_error = match self.session.reload() {
            Ok(()) => {
                self.clock.follow(&self.session.settings());
                self.notice = Some("the scene was loaded anew".to_owned());
                None
            }
            Err(error) => {
                log::error!("{error:#}");
                Some(format!("{error:#}"))
            }
        };
    }

    /// Draws and presents a frame.
    fn draw(&mut self) -> Result<()> {
        let elapsed = self.last_frame.elapsed().as_secs_f64();
        self.last_frame = Instant::now();
        self.clock.advance(elapsed);
        let mut frame = FrameRecorder::begin();
        self.draw_frame(&mut frame, elapsed as f32)?;
        self.profiler.push(frame.finish());
        Ok(())
    }

    fn draw_frame(&mut self, frame: &mut FrameRecorder, elapsed: f32) -> Result<()> {
        let Some(size) = self.screen.size() else { return Ok(()) };
        self.stale = false;
        frame.span("update", |_| {
            self.session.set_ticks(self.clock.ticks());
            self.move_camera(elapsed);
        });
        frame.span("render", |_| self.render(size));
        for pass in &self.report.passes {
            if let Some(time) = pass.gpu_ms {
                frame.gpu(&pass.name, time);
            }
        }
        if let Some(reason) = self.session.gpu.device_lost() {
            bail!("the graphics device was lost: {reason}");
        }
        frame.span("present", |_| self.present())
    }

    /// Moves the camera by what was done since the last frame.
    fn move_camera(&mut self, elapsed: f32) {
        self.flight_speed = (self.flight_speed * 1.2f32.powf(self.input.take_wheel())).clamp(0.01, 100.0);
        let (look, orbit) = (self.input.take_look(), self.input.take_orbit());
        let direction = self.input.flight();
        let Ok(camera) = self.session.camera() else { return };
        if look != [0.0; 2] {
            self.camera.look(&camera, look);
        }
        if orbit != [0.0; 2] {
            let distance = self.orbit_distance();
            self.camera.orbit(&camera, orbit, distance);
        }
        if direction != Vec3::ZERO {
            let speed = self.session.settings().move_speed * self.flight_speed;
            self.camera.fly(&camera, direction.normalize() * speed * elapsed.min(0.1));
        }
    }

    /// Distance of the point that is orbited: where the scene's middle lies along the view direction [m].
    fn orbit_distance(&self) -> f32 {
        let Ok(camera) = self.session.camera() else { return 1.0 };
        let view = self.camera.apply(&camera).world_from_view;
        let bounds = self.session.scene().bounds();
        if bounds.is_empty() {
            return 1.0;
        }
        let ahead = (bounds.center() - Vec3::from(view.translation)).dot(-Vec3::from(view.matrix3.z_axis));
        ahead.max(0.05 * (bounds.max - bounds.min).length()).max(0.01)
    }

    fn render(&mut self, size: [u32; 2]) {
        let result = self.session.camera().and_then(|camera| {
            let limit = self.session.gpu.limits.max_texture_dimension_2d;
            let size = size.map(|edge| edge.min(limit));
            let view = SceneView { camera: self.camera.apply(&camera), size, jitter: [0.0; 2] };
            let mut settings = self.session.display_settings();
            if let GiMethod::Reference(reference) = &mut settings.gi {
                // One sample a frame: the image gets better while it is looked at.
                reference.samples_a_frame = 1;
            }
            self.session.render(&view, &settings)
        });
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
    }

    fn present(&mut self) -> Result<()> {
        let gpu = &self.session.gpu;
        let Some(frame) = self.screen.acquire(gpu)? else {
            self.stale = true;
            return Ok(());
        };
        let target = self.screen.view(&frame);
        let size = [frame.texture.width(), frame.texture.height()];
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("present") });
        self.screen.blit(gpu, &mut encoder, self.session.display_texture(), &target)?;
        let errors = self.errors();
        let shown = Shown {
            scene: &self.session.name(),
            state: self.state(),
            profiler: &self.profiler,
            report: &self.report,
            notice: self.notice.as_deref(),
            errors: &errors,
            help: self.help,
        };
        self.stale |= self.overlay.draw(gpu, &self.window, &mut encoder, (&target, size), &shown);
        gpu.queue.submit([encoder.finish()]);
        self.window.pre_present_notify();
        gpu.queue.present(frame);
        Ok(())
    }

    fn state(&self) -> String {
        let time = format!("{:.2} s", self.clock.seconds());
        let speed = if self.clock.speed() == 1.0 { String::new() } else { format!("  x{}", self.clock.speed()) };
        let paused = if self.clock.playing { "" } else { "  paused" };
        let camera = if self.camera.is_free() { "  free camera" } else { "" };
        format!("{time}{speed}{paused}{camera}")
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
