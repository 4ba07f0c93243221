//! `lightwell play`: a scene in a window, or, without a display, its animation in files.

use crate::cli::PlayArgs;
use anyhow::Result;
use lightwell_editor::{Display, EditedGame, Opening};
use lightwell_runtime::cli::Common;
use lightwell_runtime::scene_path;
use lightwell_runtime::window::has_display;
use lightwell_tools::commands::animation::{self, Animation};

/// Plays until the window is closed or all frames are written.
///
/// # Errors
/// If the scene cannot be loaded, no device is found, or a frame fails.
pub fn run(args: &PlayArgs, common: &Common) -> Result<()> {
    scene_path::find(&args.scene)?;
    let animation = Animation { scene: &args.scene, size: args.size, quality: &args.quality, look: &args.look };
    if !has_display() {
        return animation::run(&animation, common, "there is no display");
    }
    match Display::open() {
        Ok(display) => {
            let look = args.look.clone();
            let (scene, size, scale) = (args.scene.clone(), args.size, args.scale);
            let opening = Opening { scene, size, scale, frames_per_second: args.fps, look };
            display.edit(&opening, common, &EditedGame::default())
        }
        Err(error) => animation::run(&animation, common, &format!("the display cannot be used ({error})")),
    }
}
