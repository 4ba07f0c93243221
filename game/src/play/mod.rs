//! `lightwell play`: a scene in a window, or, without a display, its animation in files.

mod answers;
mod artist;
pub(crate) mod export;
mod headless;
mod memory;
mod meter;
pub(crate) mod paint;
mod picture;
mod player;
mod remembered;
pub(crate) mod screen;
pub(crate) mod ui;
pub(crate) mod watch;
mod window;

use crate::cli::{Common, PlayArgs};
use crate::editor::OwnComponent;
use crate::scene_path;
use anyhow::{Context, Result};
use lightwell::files::ComponentTypes;
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
        Ok(event_loop) => window::run(event_loop, args, common, Own::default()),
        Err(error) => headless::run(args, common, &format!("the display cannot be used ({error})")),
    }
}

/// Components of a game, for files and for the inspector.
#[derive(Default)]
pub(crate) struct Own {
    pub types: ComponentTypes,
    pub components: Vec<OwnComponent>,
}

/// Opens a game's scene in the editor.
///
/// # Errors
/// As [`run`], and if there is no display.
pub(crate) fn edit(
    args: &PlayArgs,
    common: &Common,
    types: ComponentTypes,
    components: Vec<OwnComponent>,
) -> Result<()> {
    scene_path::find(&args.scene)?;
    let event_loop = EventLoop::new().context("the editor needs a display")?;
    window::run(event_loop, args, common, Own { types, components })
}

/// Whether a window can be hoped for. Other systems than Linux and its kin always have a display.
pub(crate) fn has_display() -> bool {
    let set = |name| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    cfg!(any(windows, target_os = "macos")) || set("DISPLAY") || set("WAYLAND_DISPLAY") || set("WAYLAND_SOCKET")
}
