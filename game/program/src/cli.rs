//! The command line.

use clap::{Args, Parser, Subcommand};
use lightwell_runtime::cli::{Common, LookArgs, parse_frame_rate, parse_scale, parse_size};
use lightwell_tools::cli::{
    BenchArgs, CompareArgs, ExplainArgs, PackArgs, QualityArgs, RenderArgs, SheetArgs, StressArgs, TestArgs,
};
use std::path::PathBuf;

const EXAMPLES: &str = "\
Examples:
  lightwell play                              the Cornell box, in a window
  lightwell play scenes/sponza.scene.ron --models ~/models
  lightwell render cornell -o still.png --time 1.5
  lightwell render cornell -o 'frames/{}.png' --frames 0..120 --size 960x540
  lightwell render cornell -o dim.exr --set 'Spot light.light.intensity=5' --only indirect
  lightwell compare a.exr reference.exr --max nrmse=0.1 --difference where.png
  lightwell bench cornell --quick -o out/bench
  lightwell explain cornell                   what runs, what is reused, what is skipped, and why
  lightwell test                              the scene tests in tests/scenes
  lightwell sheet ~/models -o out/sheets      a thumbnail of each model below a folder
  lightwell stress -o out/stress              what must hold for every scene
  lightwell pack --example corner             a game as a folder to give away

A SCENE is a .scene.ron, .prefab.ron, .gltf or .glb file, or the name of a scene in the folder `scenes`.
Exit codes: 0 fine; 1 a check failed or the work could not be done; 2 wrong usage.";

/// Lightwell: a mini game engine with real-time global illumination.
#[derive(Debug, Parser)]
#[command(name = "lightwell", version, after_help = EXAMPLES, arg_required_else_help = true)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
    /// Options of every command.
    #[command(flatten)]
    pub common: Common,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Play a scene in a window; without a display, render its animation into files
    Play(PlayArgs),
    /// Render images of a scene into files
    Render(RenderArgs),
    /// Measure how far an image is from a reference
    Compare(CompareArgs),
    /// Measure time against error of the methods of indirect light
    Bench(BenchArgs),
    /// Show which passes a frame runs, reuses or skips, and why
    Explain(ExplainArgs),
    /// Run headless scene tests
    Test(TestArgs),
    /// Draw many models and scenes as labelled thumbnails on sheets
    Sheet(SheetArgs),
    /// Check what must hold for every scene, at extreme scales, lights and places
    Stress(StressArgs),
    /// Make a folder of a game, which runs on machines without its source
    Pack(PackArgs),
    /// Show the graphics adapter, its features and limits
    Info,
}

const PLAY_HELP: &str = "\
The window has panels around the picture to look at the scene and to change it; F1 lists all keys:
  click, drag a handle            select; move, rotate, scale (1 2 3 choose the handle)
  drag left, W A S D, Q E         look around and fly (drag right: orbit); wheel: speed of flight
  Ctrl+Z  Ctrl+Y  Ctrl+S          undo, redo, save
  C  F                            back to the scene's camera, focus on the selection
  Space  .  + -                   pause, one step, faster or slower
  H  F1  F12  Ctrl+Q              hide the panels, help, screenshot, quit

The scene file and the shaders are watched: a change shows at once, and a mistake shows its error while
the last good version keeps running. Edits that are not saved are asked for before they would be lost.
Without a display the animation is rendered into out/NAME/, each image as `render --quality fast` makes it.";

/// Arguments of `play`.
#[derive(Args, Debug)]
#[command(after_help = PLAY_HELP)]
pub struct PlayArgs {
    /// Scene file, or name of a scene in `scenes`
    #[arg(default_value = "cornell")]
    pub scene: String,
    /// Size of the window, or of the images without a display [default: as it was last, or 1280x800; 512x512]
    #[arg(long, value_name = "WxH", value_parser = parse_size, allow_hyphen_values = true)]
    pub size: Option<[u32; 2]>,
    /// Part of the view's size that is drawn, 0.1 to 1: less is faster
    #[arg(long, value_name = "X", default_value_t = 1.0, value_parser = parse_scale)]
    pub scale: f32,
    /// Frames per second to hold: while anything moves, frames are drawn smaller if they come too late, and shown enlarged;
    /// 0: never [default: the display's rate, or 10 with a software driver]
    #[arg(long, value_name = "N", value_parser = parse_frame_rate)]
    pub fps: Option<f32>,
    /// Measure the window and end: when it first shows something, how often it does while the scene plays, how soon it
    /// answers, and how fast it comes to rest. `bench --window` makes a report of it
    #[arg(long, value_name = "FILE.ron")]
    pub measure: Option<PathBuf>,
    /// How quiet the images without a display are.
    #[command(flatten)]
    pub quality: QualityArgs,
    /// Choices that change the image.
    #[command(flatten)]
    pub look: LookArgs,
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_definition_is_sound() {
        Cli::command().debug_assert();
    }
}
