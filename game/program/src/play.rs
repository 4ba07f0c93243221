//! `lightwell play`: a scene in a window, or, without a display, its animation in files.

use crate::cli::PlayArgs;
use anyhow::{Result, bail};
use lightwell_editor::{Display, EditedGame, Opening};
use lightwell_runtime::cli::Common;
use lightwell_runtime::scene_path;
use lightwell_runtime::window::has_display;
use lightwell_tools::commands::animation::{self, Animation};
use std::time::Instant;

/// Plays until the window is closed or all frames are written.
///
/// # Errors
/// If the scene cannot be loaded, no device is found, or a frame fails.
pub fn run(args: &PlayArgs, common: &Common) -> Result<()> {
    let started = Instant::now();
    scene_path::find(&args.scene)?;
    let animation = Animation { scene: &args.scene, size: args.size, quality: &args.quality, look: &args.look };
    if !has_display() {
        if args.measure.is_some() {
            bail!(
                "--measure is about a window, and there is no display: try it under `xvfb-run -s '-screen 0 1280x800x24'`"
            );
        }
        return animation::run(&animation, common, "there is no display");
    }
    match Display::open() {
        Ok(display) => {
            let look = args.look.clone();
            let (scene, size, scale) = (args.scene.clone(), args.size, args.scale);
            let measure = args.measure.clone().map(|file| (file, started));
            let opening = Opening { scene, size, scale, frames_per_second: args.fps, look, measure };
            display.edit(&opening, common, &EditedGame::default())
        }
        Err(error) => animation::run(&animation, common, &format!("the display cannot be used ({error})")),
    }
}
