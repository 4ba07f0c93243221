//! The command line of a game.

use clap::Parser;
use lightwell::game::InputScript;
use lightwell::render::GiMethod;
use lightwell_runtime::cli::{
    Common, LookArgs, built_in_methods, method_parser, parse_assignment, parse_frame_rate, parse_scale, parse_size,
};
use std::path::PathBuf;

/// What a game is asked for.
#[derive(Debug, Parser)]
#[command(version = None)]
pub struct GameArgs {
    /// Begin with another scene
    #[arg(long, value_name = "SCENE")]
    pub scene: Option<String>,
    /// Open the scene in the editor instead of playing it (needs the feature `editor` of lightwell-game)
    #[arg(long, conflicts_with_all = ["headless", "record", "script"])]
    pub edit: bool,
    /// Play without a window, and write images (as without a display)
    #[arg(long)]
    pub headless: bool,
    /// Take the input from a script
    #[arg(long, value_name = "FILE")]
    pub script: Option<PathBuf>,
    /// Keep the input as a script
    #[arg(long, value_name = "FILE", conflicts_with = "headless")]
    pub record: Option<PathBuf>,
    /// Print the files that the game loads, the first scene first; with --script also those that it loads while the script
    /// plays
    #[arg(long, conflicts_with_all = ["edit", "headless", "record"])]
    pub list_files: bool,
    /// With --list-files: another file that the game loads, with what it names
    #[arg(long, value_name = "FILE", requires = "list_files")]
    pub also: Vec<PathBuf>,
    /// Without a window: number of steps, at most ten million [default: the script's, or two seconds]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(..=InputScript::MOST_STEPS))]
    pub steps: Option<u64>,
    /// Without a window: folder for the images [default: out/NAME]
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Without a window: steps from image to image
    #[arg(long, value_name = "N", default_value_t = 15, value_parser = clap::value_parser!(u64).range(1..))]
    pub every: u64,
    /// Size of the window or of the images [default: 1280x800; 512x320]
    #[arg(long, value_name = "WxH", value_parser = parse_size, allow_hyphen_values = true)]
    pub size: Option<[u32; 2]>,
    /// Part of the window's size that is drawn, 0.1 to 1: less is faster
    #[arg(long, value_name = "X", default_value_t = 1.0, value_parser = parse_scale)]
    pub scale: f32,
    /// Frames per second to hold: frames are drawn smaller while they come too late, and shown enlarged; 0: never
    /// [default: the display's rate, or 10 with a software driver]
    #[arg(long, value_name = "N", value_parser = parse_frame_rate)]
    pub fps: Option<f32>,
    /// Indirect light [default: what the scene asks for]
    #[arg(long, value_name = "GI", value_parser = method_parser(built_in_methods()))]
    pub gi: Option<GiMethod>,
    /// Change a value of the scene that it begins with: `ENTITY.COMPONENT.FIELD=VALUE`, with the game's own components
    /// too, `clpv.FIELD=VALUE`, `scene.FIELD=VALUE`, or `preset=NAME`; may be given many times
    #[arg(long = "set", value_name = "PATH=VALUE", value_parser = parse_assignment)]
    pub sets: Vec<(String, String)>,
    /// Options of every program.
    #[command(flatten)]
    pub common: Common,
}

impl GameArgs {
    /// Settings of the image.
    pub(super) fn look(&self) -> LookArgs {
        LookArgs { gi: self.gi, sets: self.sets.clone(), ..LookArgs::default() }
    }
}
