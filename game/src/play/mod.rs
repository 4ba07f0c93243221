//! `lightwell play`: a scene in a window, or, without a display, its animation in files.

mod export;
mod headless;
mod memory;
mod meter;
mod player;
mod screen;
mod ui;
mod watch;
mod window;

use crate::cli::{Common, PlayArgs};
use crate::scene_path;
use anyhow::Result;
use winit::event_loop::EventLoop;

/// Plays until the window is closed or all frames are written.
///
/// # Errors
/// If the scene cannot be loaded, no device is found, or a frame fails.
pub fn run(args: &PlayArgs, common: &Common) -> Result<()> {
    scene_path::find(&args.scene)?;
    if !has_display() {
        return headless::run(args, common, "there is no display");
    }
    match EventLoop::new() {
        Ok(event_loop) => window::run(event_loop, args, common),
        Err(error) => headless::run(args, common, &format!("the display cannot be used ({error})")),
    }
}

/// Whether a window can be hoped for. Other systems than Linux and its kin always have a display.
fn has_display() -> bool {
    let set = |name| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    cfg!(any(windows, target_os = "macos")) || set("DISPLAY") || set("WAYLAND_DISPLAY") || set("WAYLAND_SOCKET")
}
