//! A scene that is playing in a window.

use super::export::Job;
use super::game::Play;
use super::measurement::Measurement;
use super::memory::Memory;
use super::meter::Meter;
use super::picture::{Picture, SOON};
use super::playing::{NewGame, plain};
use super::render_thread::RenderThread;
use super::{EditedGame, Opening};
use crate::comparison::Comparison;
use crate::editor::camera::FlyCamera;
use crate::editor::clock::PlayClock;
use crate::editor::{Editor, Facts, Request, Stage, Tracing, Working, console, set_fonts};
use anyhow::{Result, bail};
use lightwell::graph::FrameReport;
use lightwell::profile::{FrameRecorder, Profiler};
use lightwell::world::GameWorld;
use lightwell_runtime::cli::Common;
use lightwell_runtime::frame_budget::{FrameBudget, display_rate};
use lightwell_runtime::session::{self, Session};
use lightwell_runtime::watch::{Change, SceneWatcher};
use lightwell_runtime::window::{GatheredInput, Painted, Screen, UiSurface};
use std::path::PathBuf;
use std::rc::Rc;
use std::sync::Arc;
use std::time::{Duration, Instant};
use winit::event::WindowEvent;
use winit::event_loop::ActiveEventLoop;
use winit::window::Window;

/// How often files are looked at while nothing moves.
const IDLE: Duration = Duration::from_millis(100);
/// How often is looked whether a picture is finished.
const GLANCE: Duration = Duration::from_millis(5);

/// A scene that is playing in a window.
pub struct Player {
    pub(super) window: Arc<Window>,
    pub(super) session: Session,
    pub(super) screen: Screen,
    pub(super) ui: UiSurface,
    pub(super) watcher: SceneWatcher,
    pub(super) editor: Editor,
    pub(super) clock: PlayClock,
    /// The reference beside the picture.
    pub(super) comparison: Comparison,
    pub(super) camera: FlyCamera,
    /// Part of the view's size that is drawn.
    pub(super) scale: f32,
    /// How large frames are drawn; none: as large as they are shown.
    pub(super) budget: Option<FrameBudget>,
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
    /// Makes a game for each play, and the one that plays.
    pub(super) new_game: NewGame,
    pub(super) play: Option<Play>,
    /// What the player of the game does, and where the pointer is \[pixels\].
    pub(super) input: GatheredInput,
    pub(super) cursor: [f32; 2],
    pub(super) render_thread: RenderThread,
    pub(super) picture: Picture,
    /// What can be answered once no picture is being drawn.
    pub(super) waiting: Vec<Request>,
    recorder: Option<FrameRecorder>,
    pub(super) meter: Meter,
    pub(super) measurement: Option<Measurement>,
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
        args: &Opening,
        common: &Common,
        memory: Memory,
        own: &EditedGame,
    ) -> Result<Self> {
        let window = Arc::new(window);
        let (gpu, screen) = Screen::open(event_loop, Arc::clone(&window), &session::gpu_options(common))?;
        session::keep_pipelines(&gpu);
        let context = egui::Context::default();
        set_fonts(&context);
        let ui = UiSurface::new(&gpu, &window, screen.format(), context);
        let look = args.look.in_window();
        let mut session = Session::open_with(gpu, &args.scene, &look, common, own.types.clone(), &own.methods)?;
        let options = session.parts().files.options.clone();
        let new_game = own.new_game.clone().unwrap_or_else(|| Rc::new(move || Ok(plain(&options))));
        lightwell::files::remove_leftovers(session.path());
        let render_thread = RenderThread::new(&session.gpu);
        let (display, is_software) = (display_rate(&window), session.gpu.is_software());
        let budget = FrameBudget::choose(args.frames_per_second, 1.0, display, is_software);
        let mut player = Self {
            watcher: SceneWatcher::new(session.path(), &session.watched_files()),
            clock: PlayClock::new(&session.settings()),
            comparison: Comparison::default(),
            window,
            session,
            screen,
            ui,
            editor: Editor::default(),
            camera: FlyCamera::default(),
            scale: args.scale,
            budget,
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
            new_game,
            play: None,
            input: GatheredInput::default(),
            cursor: [0.0; 2],
            render_thread,
            picture: Picture::default(),
            waiting: Vec::new(),
            recorder: None,
            meter: Meter::default(),
            measurement: args.measure.clone().map(|(file, started)| Measurement::new(file, started)),
            followed: 0,
        };
        player.editor.set_own(own.shown.clone());
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
                self.forward(event);
                self.stale |= self.ui.event(&self.window, event);
                self.stale |= matches!(event, WindowEvent::Resized(_) | WindowEvent::ScaleFactorChanged { .. });
            }
        }
        Ok(!self.ended)
    }

    /// Takes up changed files, and asks for a frame if there is something new to show; says how long it may sleep.
    pub fn poll(&mut self) -> Duration {
        // The library logs what it reloads and what is broken; the panels show the latter.
        self.stale |= !self.session.gpu.shaders.poll().is_empty();
        // Edits may have brought models and prefabs.
        if std::mem::replace(&mut self.followed, self.editor.history.version) != self.editor.history.version {
            self.watcher.follow(&self.session.watched_files());
        }
        // A game plays on: what changed is taken up when it has ended.
        if let Some(change) = self.play.is_none().then(|| self.watcher.changed()).flatten() {
            self.stale = true;
            if let Some(request) = self.editor.file_changed(part_name(&change)) {
                self.answer(request);
            }
        }
        if self.repaint_at.is_some_and(|at| at <= Instant::now()) {
            self.repaint_at = None;
            self.stale = true;
        }
        self.stale |= self.measurement.as_ref().is_some_and(Measurement::is_waiting);
        let goes_on = self.render_thread.is_idle() && (self.plays() || self.job.is_some());
        let busy = self.stale || goes_on || self.render_thread.is_finished();
        let visible = self.screen.size().is_some();
        if busy && visible {
            self.window.request_redraw();
        }
        match (busy && visible, self.render_thread.is_idle()) {
            (true, _) => Duration::ZERO,
            (false, false) => GLANCE,
            (false, true) => IDLE,
        }
    }

    /// Whether time passes in what is shown.
    fn plays(&self) -> bool {
        self.job.is_none() && (self.clock.playing && self.play.is_none() || self.game_runs())
    }

    /// Shows a frame of the interface, with the picture as far as it is finished.
    fn draw(&mut self) -> Result<()> {
        if self.screen.size().is_none() {
            return Ok(());
        }
        // A picture that the interface outruns is one frame of the profile all the same.
        let mut frame = self.recorder.take().unwrap_or_else(FrameRecorder::begin);
        let mut is_new = self.take_picture(&mut frame, Duration::ZERO)?;
        // This frame of the interface shows it.
        self.stale = false;
        self.go_on_measuring()?;
        // Where pictures take long, time waits for them.
        let mut elapsed = self.render_thread.is_idle().then(|| {
            let elapsed = self.last_frame.elapsed().as_secs_f64();
            self.last_frame = Instant::now();
            elapsed
        });
        if is_new && self.plays() {
            // The device has the next picture to draw while the interface is made.
            frame.span("update", |_| self.update(elapsed.take()));
            self.begin_next();
        }
        let (painted, requests) = frame.span("interface", |_| self.interface());
        for request in requests {
            let is_save = request == Request::Save;
            self.answer(request);
            // What would lose edits waits for them to be saved, under whatever name.
            if is_save && self.editor.is_dirty() {
                break;
            }
        }
        if self.job.is_none() {
            frame.span("update", |_| self.update(elapsed));
        }
        is_new |= self.next_picture(&mut frame, if is_new { Duration::ZERO } else { SOON })?;
        if let Some(reason) = self.session.gpu.device_lost() {
            bail!("the graphics device was lost: {reason}");
        }
        frame.span("present", |_| self.present(painted))?;
        match (is_new, self.render_thread.is_idle()) {
            (true, is_idle) => {
                self.profiler.push(frame.finish());
                self.recorder = (!is_idle).then(FrameRecorder::begin);
            }
            (false, false) => self.recorder = Some(frame),
            (false, true) => {}
        }
        Ok(())
    }

    /// Brings the world to the time that is shown, so many seconds after the last one; none: to the same.
    fn update(&mut self, elapsed: Option<f64>) {
        self.settle_input();
        if self.play.is_some() {
            return self.pass_time(elapsed);
        }
        self.clock.advance(elapsed.unwrap_or(0.0));
        let origin = self.session.scene().origin;
        self.session.set_ticks(self.clock.ticks());
        self.camera.rebase((self.session.scene().origin - origin).as_vec3());
    }

    /// Runs the panels.
    fn interface(&mut self) -> (Painted, Vec<Request>) {
        let mut requests = Vec::new();
        let size_before = self.editor.view.size;
        let painted = self.with_stage(false, |Desk { editor, ui, window }, stage| {
            ui.run(window, |ui| requests.extend(editor.show(ui, stage)))
        });
        self.session.beside = self.comparison.beside(&self.session.rendering.look.trace);
        match painted.repaint {
            Duration::ZERO => self.stale = true,
            Duration::MAX => {}
            later => self.repaint_at = Instant::now().checked_add(later),
        }
        // The picture of the new size comes with the next frame.
        self.stale |= self.editor.view.size != size_before;
        (painted, requests)
    }

    /// Does something with what the editor works on: the world of the game that plays, or the edited one.
    pub(super) fn with_stage<T>(&mut self, edited: bool, work: impl FnOnce(Desk, &mut Stage) -> T) -> T {
        let (errors, log, name) = (self.errors(), console::records(), self.session.name());
        let trouble = self.play.as_ref().and_then(|play| play.playing.trouble()).map(str::to_owned);
        let adapter = self.session.gpu.info.name.clone();
        let scene_camera = self.session.camera().ok();
        let tracing = self.picture.tracing.map(|(samples, target)| Tracing { samples, target });
        let working = Working {
            picture: self.render_thread.progress(),
            export: self.job.as_ref().map(super::export::Job::progress),
        };
        let image = self.ui.image();
        let budget = self.said_of_size();
        let parts = self.session.parts();
        let (world, files, playing) = match self.play.as_mut().filter(|_| !edited) {
            None => (parts.world, parts.files, None),
            Some(play) => {
                let facts = play.facts(trouble.as_deref(), (&*parts.world, parts.files.path));
                let (world, files) = play.playing.parts();
                (world, files, Some(facts))
            }
        };
        let mut stage = Stage {
            world,
            files,
            look: parts.look,
            display: parts.display,
            comparison: &mut self.comparison,
            clock: &mut self.clock,
            camera: &mut self.camera,
            facts: Facts {
                name: &name,
                scene: parts.scene,
                methods: parts.methods,
                report: &self.report,
                profiler: &self.profiler,
                errors: &errors,
                log: &log,
                scene_camera,
                image,
                image_size: self.picture.size().unwrap_or(self.editor.view.size.map(|edge| edge.max(1))),
                tracing,
                live_error: self.meter.error,
                adapter: &adapter,
                budget,
                working,
                playing,
            },
        };
        work(Desk { editor: &mut self.editor, ui: &mut self.ui, window: &self.window }, &mut stage)
    }

    /// The world that is shown: that of the game that plays, or the edited one.
    pub(super) fn world(&self) -> &GameWorld {
        self.play.as_ref().map_or(self.session.world(), |play| &play.playing.game().world)
    }

    fn present(&mut self, painted: Painted) -> Result<()> {
        let gpu = self.session.gpu.clone();
        self.stale |= !self.ui.present(&gpu, &mut self.screen, &self.window, painted)?;
        Ok(())
    }

    fn errors(&self) -> Vec<String> {
        let shaders = self.session.gpu.shaders.errors().into_iter().map(|error| error.to_string());
        let mut errors: Vec<String> = self.scene_error.iter().cloned().chain(shaders).collect();
        errors.extend(self.play.as_ref().and_then(|play| play.playing.trouble()).map(str::to_owned));
        // A frame that fails for a broken shader says the same once more.
        if errors.is_empty() {
            errors.extend(self.frame_error.clone());
        }
        errors
    }
}

/// What the window works with, apart from the stage.
pub(super) struct Desk<'a> {
    pub editor: &'a mut Editor,
    pub ui: &'a mut UiSurface,
    pub window: &'a Window,
}

/// The file that changed, if it is not the scene's own.
fn part_name(change: &Change) -> Option<String> {
    match change {
        Change::Scene => None,
        Change::Part(path) => path.file_name().map(|name| name.to_string_lossy().into_owned()),
    }
}
