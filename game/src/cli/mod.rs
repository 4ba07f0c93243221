//! The command line.

mod bench;
mod compare;
mod look;
mod parse;
mod quality;
mod render;
mod sheet;
mod stress;
mod test;

pub use bench::{BenchArgs, Bounces, Grows, Sweep};
pub use compare::{CompareArgs, Metric};
pub use look::{DebugArgs, Edges, Gi, LookArgs, Only, Switch, TraceArgs};
pub use parse::parse_assignment;
pub(crate) use parse::parse_size;
pub use quality::{Quality, QualityArgs};
pub use render::RenderArgs;
pub use sheet::SheetArgs;
pub use stress::StressArgs;
pub use test::TestArgs;

use clap::{Args, Parser, Subcommand};
use lightwell::assets::LoadBudget;
use lightwell::files::{ComponentTypes, LoadOptions};
use parse::parse_time;
use std::ffi::OsString;
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

A SCENE is a .scene.ron, .gltf or .glb file, or the name of a scene in the folder `scenes`.
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

/// Options of every command.
#[derive(Args, Clone, Debug, Default)]
pub struct Common {
    /// Folder of third-party models that some scenes use
    #[arg(long, global = true, value_name = "DIR", env = "LIGHTWELL_MODELS")]
    pub models: Option<PathBuf>,
    /// Folder that scenes may name files in, beside their own project and the models; may be given several times, and
    /// as a list of paths in LIGHTWELL_TRUST
    #[arg(long, global = true, value_name = "DIR")]
    pub trust: Vec<PathBuf>,
    /// Limit of what loading a scene may take: bytes, texels, triangles, entities or seconds, such as texels=4e9
    #[arg(long, global = true, value_name = "NAME=N", value_parser = limit)]
    pub budget: Vec<String>,
    /// Part of the name of the graphics adapter to use (`lightwell info` lists them)
    #[arg(long, global = true, value_name = "NAME")]
    pub adapter: Option<String>,
    /// Say more: -v what is done, -vv details
    #[arg(short, long, global = true, action = clap::ArgAction::Count)]
    pub verbose: u8,
}

fn limit(written: &str) -> Result<String, String> {
    LoadBudget::default().set(written).map(|()| written.to_owned())
}

impl Common {
    /// How scenes are loaded, with the components of a game that they may hold.
    pub fn load_options(&self, types: ComponentTypes) -> LoadOptions {
        let listed = std::env::var_os("LIGHTWELL_TRUST");
        let listed = listed.iter().flat_map(std::env::split_paths).filter(|folder| !folder.as_os_str().is_empty());
        let mut budget = LoadBudget::default();
        for written in &self.budget {
            // They were checked when the command line was read.
            let _ = budget.set(written);
        }
        let trusted = self.trust.iter().cloned().chain(listed).collect();
        LoadOptions { models: self.models.clone(), trusted, budget, types }
    }

    /// The arguments that say the same to another process of this program.
    pub fn arguments(&self) -> Vec<OsString> {
        let mut arguments = Vec::new();
        if let Some(models) = &self.models {
            arguments.extend(["--models".into(), models.into()]);
        }
        arguments.extend(self.trust.iter().flat_map(|folder| ["--trust".into(), folder.into()]));
        arguments.extend(self.budget.iter().flat_map(|limit| ["--budget".into(), limit.into()]));
        if let Some(adapter) = &self.adapter {
            arguments.extend(["--adapter".into(), adapter.into()]);
        }
        arguments.extend((0..self.verbose).map(|_| "-v".into()));
        arguments
    }
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
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub size: Option<[u32; 2]>,
    /// How quiet the images without a display are.
    #[command(flatten)]
    pub quality: QualityArgs,
    /// Choices that change the picture.
    #[command(flatten)]
    pub look: LookArgs,
}

/// Arguments of `explain`.
#[derive(Args, Debug)]
pub struct ExplainArgs {
    /// Scene file, or name of a scene in `scenes`
    pub scene: String,
    /// Size of the image in pixels
    #[arg(long, value_name = "WxH", default_value = "512x512", value_parser = parse_size)]
    pub size: [u32; 2],
    /// Time in seconds
    #[arg(long, value_name = "S", default_value = "0", value_parser = parse_time)]
    pub time: f64,
    /// Choices that change the picture.
    #[command(flatten)]
    pub look: LookArgs,
}

#[cfg(test)]
mod tests {
    use super::compare::parse_bound;
    use super::parse::*;
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_definition_is_sound() {
        Cli::command().debug_assert();
    }

    #[test]
    fn values_are_checked() {
        assert_eq!(parse_size("640x480"), Ok([640, 480]));
        assert!(parse_size("640").is_err() && parse_size("0x4").is_err() && parse_size("4x99999").is_err());
        assert_eq!(parse_frames("3..7"), Ok(3..7));
        assert!(parse_frames("7..7").is_err() && parse_frames("7").is_err());
        assert!(parse_time("NaN").is_err() && parse_time("-1").is_err());
        assert_eq!(parse_time("1.5"), Ok(1.5));
        assert!(parse_seconds("0").is_err() && parse_seconds("inf").is_err() && parse_seconds("soon").is_err());
        assert_eq!(parse_seconds("0.5"), Ok(0.5));
        assert_eq!(parse_bound("bias=0.5"), Ok((Metric::Bias, 0.5)));
        assert!(
            parse_bound("luck=1").is_err() && parse_bound("nrmse=-1").is_err() && parse_bound("nrmse=NaN").is_err()
        );
        let assignment = parse_assignment("a.b=(x = 1)");
        assert_eq!(assignment, Ok(("a.b".to_owned(), "(x = 1)".to_owned())));
        assert!(parse_output("a.jpg").is_err() && parse_output("png").is_err() && parse_output("a.PNG").is_ok());
    }
}
