//! A game in a window.

#[cfg(feature = "gamepad")]
use super::pads::Pads;
use super::player::Drawn;
use super::reload::Reloader;
#[cfg(feature = "sound")]
use super::speaker::Speaker;
use super::{App, CustomPassAdder, GameArgs, Hud, sounds};
use anyhow::{Context, Result};
use lightwell::game::{Game, InputScript, Time};
use lightwell::graph::{FrameReport, Timing};
use lightwell::render::UpdateRate;
use lightwell_runtime::frame_budget::{FrameBudget, display_rate};
use lightwell_runtime::session;
use lightwell_runtime::steps::StepClock;
use lightwell_runtime::window::{Area, GatheredInput, Screen, UiSurface};
use std::sync::Arc;
use std::time::Instant;
use winit::application::ApplicationHandler;
use winit::dpi::PhysicalSize;
use winit::event::{DeviceEvent, DeviceId, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoop};
use winit::window::{Window, WindowId};

/// Plays in a window until it is closed, the game ends or its script does.
///
/// # Errors
/// If the game cannot begin, nothing can draw on the window, or the device is lost.
pub(super) fn run(mut app: App, args: &GameArgs, script: Option<InputScript>) -> Result<()> {
    let event_loop = EventLoop::new().context("the display cannot be used; try --headless")?;
    let title = app.name();
    let passes = std::mem::take(&mut app.passes);
    let actions = app.actions_path()?;
    let game = app.start_with(args.scene.as_deref(), &args.sets, &args.common)?;
    let reloader = Reloader::new(&game, actions);
    let begun = Some((game, reloader));
    let mut handler = Handler { begun, passes, title, args, script, open: None, failure: None };
    event_loop.run_app(&mut handler)?;
    handler.failure.map_or(Ok(()), Err)
}

struct Handler<'a> {
    begun: Option<(Game, Reloader)>,
    passes: Vec<CustomPassAdder>,
    title: String,
    args: &'a GameArgs,
    script: Option<InputScript>,
    open: Option<Open>,
    failure: Option<anyhow::Error>,
}

/// A window with the game that plays in it.
struct Open {
    window: Arc<Window>,
    screen: Screen,
    ui: UiSurface,
    drawn: Drawn,
    reloader: Reloader,
    input: GatheredInput,
    #[cfg(feature = "gamepad")]
    pads: Pads,
    #[cfg(feature = "sound")]
    speaker: Speaker,
    script: Option<InputScript>,
    recorded: InputScript,
    scale: f32,
    /// How large frames are drawn in place of `scale`; none: as that says.
    budget: Option<FrameBudget>,
    last: Instant,
    clock: StepClock,
    trouble: Option<String>,
}

impl Handler<'_> {
    fn open(&mut self, event_loop: &ActiveEventLoop) -> Result<Open> {
        let (game, reloader) = self.begun.take().context("the window was closed")?;
        let [width, height] = self.args.size.unwrap_or([1280, 800]);
        let attributes =
            Window::default_attributes().with_title(&self.title).with_inner_size(PhysicalSize::new(width, height));
        let window = Arc::new(event_loop.create_window(attributes).context("no window can be opened")?);
        let (gpu, screen) = Screen::open(event_loop, Arc::clone(&window), &session::gpu_options(&self.args.common))?;
        session::keep_pipelines(&gpu);
        let context = game.world.ecs.resource::<Hud>().context().clone();
        let ui = UiSurface::new(&gpu, &window, screen.format(), context);
        let look = self.args.look().in_window();
        let is_software = gpu.is_software();
        let mut drawn = Drawn::new(game, Arc::new(gpu), look, &self.passes);
        drawn.rendering.renderer.set_timing(Timing::Late);
        let budget = FrameBudget::choose(self.args.fps, self.args.scale, display_rate(&window), is_software);
        Ok(Open {
            window,
            screen,
            ui,
            drawn,
            reloader,
            input: GatheredInput::default(),
            #[cfg(feature = "gamepad")]
            pads: Pads::open(),
            #[cfg(feature = "sound")]
            speaker: Speaker::open(),
            script: self.script.take(),
            recorded: InputScript::default(),
            scale: self.args.scale,
            budget,
            last: Instant::now(),
            clock: StepClock::default(),
            trouble: None,
        })
    }

    fn end(&mut self, event_loop: &ActiveEventLoop, result: Result<()>) {
        let kept = match (&self.args.record, &self.open) {
            (Some(file), Some(open)) => open.recorded.write(file).map_err(Into::into),
            _ => Ok(()),
        };
        self.failure = result.and(kept).err();
        event_loop.exit();
    }
}

impl ApplicationHandler for Handler<'_> {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        if self.open.is_none() {
            match self.open(event_loop) {
                Ok(open) => self.open = Some(open),
                Err(error) => self.end(event_loop, Err(error)),
            }
        }
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let Some(open) = &mut self.open else { return };
        match event {
            WindowEvent::CloseRequested => self.end(event_loop, Ok(())),
            WindowEvent::RedrawRequested => match open.draw() {
                Ok(true) => {}
                Ok(false) => self.end(event_loop, Ok(())),
                Err(error) => self.end(event_loop, Err(error)),
            },
            event => open.event(&event),
        }
    }

    fn device_event(&mut self, _: &ActiveEventLoop, _: DeviceId, event: DeviceEvent) {
        if let Some(open) = &mut self.open {
            open.input.device(&event);
        }
    }

    fn about_to_wait(&mut self, event_loop: &ActiveEventLoop) {
        event_loop.set_control_flow(ControlFlow::Poll);
        if let Some(open) = self.open.as_ref().filter(|open| open.screen.size().is_some()) {
            open.window.request_redraw();
        }
    }

    fn exiting(&mut self, _: &ActiveEventLoop) {
        // Surface and device go before the display connection does.
        self.open = None;
    }
}

impl Open {
    fn event(&mut self, event: &WindowEvent) {
        let _ = self.ui.event(&self.window, event);
        self.input.window(event, Area::of_window(self.screen.size().unwrap_or([1, 1])));
    }

    /// Lets time pass, draws and presents; false if the game has ended.
    fn draw(&mut self) -> Result<bool> {
        let elapsed = self.last.elapsed().as_secs_f64();
        self.last = Instant::now();
        let Some(size) = self.screen.size() else { return Ok(true) };
        self.drawn.rendering.gpu.shaders.poll();
        self.reload();
        self.input.size(size);
        // What is played from a script is to be the same each time, whatever the device takes.
        match self.script {
            Some(_) => self.drawn.take_light()?,
            None => self.drawn.take_late_light()?,
        }
        if !self.steps(elapsed) {
            return Ok(false);
        }
        let input = self.ui.input(&self.window);
        let screen = input.screen_rect.unwrap_or(egui::Rect::ZERO);
        let (result, mut output) = self.drawn.frame(elapsed as f32, Some(input));
        self.tell(result.map_err(Into::into));
        let begun = Instant::now();
        let result = self.drawn.render(self.frame_size(size), self.update());
        if let Ok(report) = &result {
            self.note_time(report, elapsed, begun.elapsed().as_secs_f64());
        }
        if let Some(reason) = self.drawn.rendering.gpu.device_lost() {
            anyhow::bail!("the graphics device was lost: {reason}");
        }
        self.tell(result.map(drop));
        self.sound();
        self.ui.set_image(&self.drawn.rendering.gpu, self.drawn.rendering.display_texture());
        let painted = self.ui.over_image(&self.window, screen, &mut output);
        self.ui.present(&self.drawn.rendering.gpu, &mut self.screen, &self.window, painted)?;
        Ok(!self.drawn.game.has_ended())
    }

    /// Tells the budget the time between two frames and what of it this one took, on the host or on the device \[s\].
    fn note_time(&mut self, report: &FrameReport, between: f64, host: f64) {
        let Some(budget) = &mut self.budget else { return };
        let device: f64 = report.passes.iter().filter_map(|pass| pass.gpu_ms).sum();
        if budget.note(between as f32, host.max(1e-3 * device) as f32) {
            log::info!("{}", budget.status());
        }
    }

    /// How often the next frame brings the light between surfaces up to date.
    fn update(&self) -> UpdateRate {
        self.budget.as_ref().map(FrameBudget::update).unwrap_or_default()
    }

    fn frame_size(&self, window: [u32; 2]) -> [u32; 2] {
        match &self.budget {
            Some(budget) => budget.size(window),
            None => window.map(|edge| (edge as f32 * self.scale).ceil() as u32),
        }
    }

    /// Takes up files that changed. What was wrong before may be mended now.
    fn reload(&mut self) {
        match self.reloader.poll(&mut self.drawn.game) {
            Some(Ok(())) => {
                self.drawn.game.world.ecs.resource_mut::<Hud>().set_trouble(None);
                self.trouble = None;
                self.drawn.follow();
            }
            Some(Err(error)) => self.tell(Err(error)),
            None => {}
        }
    }

    /// The steps that are due; false if the script is through.
    fn steps(&mut self, elapsed: f64) -> bool {
        let due = self.clock.due(elapsed, self.drawn.game.world.ecs.resource::<Time>().rate);
        #[cfg(feature = "gamepad")]
        self.input.add(self.pads.events());
        for _ in 0..due {
            let events = match &self.script {
                Some(script) if self.recorded.steps >= script.steps => return false,
                Some(script) => script.at(self.recorded.steps + 1),
                None => self.input.take(),
            };
            self.recorded.record(&events);
            let result = self.drawn.step(&events);
            self.tell(result.map_err(Into::into));
            if self.drawn.game.has_ended() {
                break;
            }
        }
        true
    }

    /// Shows and logs an error; the game continues as far as it can.
    fn tell(&mut self, result: Result<()>) {
        let Err(error) = result else { return };
        let text = format!("{error:#}");
        if self.trouble.as_ref() != Some(&text) {
            log::error!("{text}");
            self.drawn.game.world.ecs.resource_mut::<Hud>().set_trouble(Some(text.clone()));
            self.trouble = Some(text);
        }
    }

    fn sound(&mut self) {
        let result = sounds::play_all(
            &mut self.drawn.game,
            #[cfg(feature = "sound")]
            &self.speaker,
        );
        self.tell(result);
    }
}
