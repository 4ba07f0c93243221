//! The event loop of interactive play.

use super::player::Player;
use super::{EditedGame, Opening};
use anyhow::{Context, Result};
use lightwell_runtime::cli::Common;
use std::time::{Duration, Instant};
use winit::application::ApplicationHandler;
use winit::dpi::PhysicalSize;
use winit::event::{DeviceEvent, DeviceId, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoop};
use winit::window::{Window, WindowId};

/// Plays in a window until it is closed.
///
/// # Errors
/// If the scene cannot be loaded, nothing can draw on the window, or the device is lost.
pub fn run(event_loop: EventLoop<()>, args: &Opening, common: &Common, own: &EditedGame) -> Result<()> {
    let mut app = App { args, common, own, player: None, failure: None };
    event_loop.run_app(&mut app)?;
    app.failure.map_or(Ok(()), Err)
}

struct App<'a> {
    args: &'a Opening,
    common: &'a Common,
    own: &'a EditedGame,
    player: Option<Player>,
    failure: Option<anyhow::Error>,
}

impl App<'_> {
    fn open(&self, event_loop: &ActiveEventLoop) -> Result<Player> {
        // What is measured does not depend on what the window was like last.
        let file = super::memory::Memory::file().filter(|_| self.args.measure.is_none());
        let memory = file.map(|file| super::memory::Memory::read(&file)).unwrap_or_default();
        let [width, height] = self.args.size.or(memory.window).unwrap_or([1280, 800]);
        let attributes =
            Window::default_attributes().with_title("Lightwell").with_inner_size(PhysicalSize::new(width, height));
        let window = event_loop.create_window(attributes).context("no window can be opened")?;
        Player::open(event_loop, window, self.args, self.common, memory, self.own)
    }

    fn fail(&mut self, event_loop: &ActiveEventLoop, error: anyhow::Error) {
        self.failure = Some(error);
        event_loop.exit();
    }
}

impl ApplicationHandler for App<'_> {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        if self.player.is_none() {
            match self.open(event_loop) {
                Ok(player) => self.player = Some(player),
                Err(error) => self.fail(event_loop, error),
            }
        }
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let Some(player) = &mut self.player else { return };
        match player.event(&event) {
            Ok(true) => {}
            Ok(false) => {
                if self.args.measure.is_none() {
                    player.remember();
                }
                event_loop.exit();
            }
            Err(error) => self.fail(event_loop, error),
        }
    }

    fn device_event(&mut self, _: &ActiveEventLoop, _: DeviceId, event: DeviceEvent) {
        if let Some(player) = &mut self.player {
            player.device_event(&event);
        }
    }

    fn about_to_wait(&mut self, event_loop: &ActiveEventLoop) {
        let wait = self.player.as_mut().map_or(Duration::from_millis(100), Player::poll);
        // A busy frame asks for a redraw, which wakes the loop by itself.
        event_loop.set_control_flow(match wait {
            Duration::ZERO => ControlFlow::Poll,
            wait => ControlFlow::WaitUntil(Instant::now() + wait),
        });
    }

    fn exiting(&mut self, _: &ActiveEventLoop) {
        // Surface and device go before the display connection does.
        self.player = None;
    }
}
