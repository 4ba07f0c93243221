//! The command line.

mod bench;
mod sheet;
mod stress;

pub use bench::{BenchArgs, Bounces, Sweep};
pub use sheet::SheetArgs;
pub use stress::StressArgs;

use clap::{Args, Parser, Subcommand, ValueEnum};
use lightwell::render::debug::DebugView;
use serde::Deserialize;
use std::ops::Range;
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
    /// Part of the name of the graphics adapter to use (`lightwell info` lists them)
    #[arg(long, global = true, value_name = "NAME")]
    pub adapter: Option<String>,
    /// Say more: -v what is done, -vv details
    #[arg(short, long, global = true, action = clap::ArgAction::Count)]
    pub verbose: u8,
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
Without a display the animation is rendered into out/NAME/.";

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
    /// Choices that change the picture.
    #[command(flatten)]
    pub look: LookArgs,
}

/// What tells an edge that is smoothed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Edges {
    /// Colours as displayed
    #[default]
    Color,
    /// Depth: outlines of what stands before something
    Depth,
    /// Normals: where surfaces of different directions meet
    Normal,
}

/// Choices that change the picture.
#[derive(Args, Clone, Debug, Default)]
pub struct LookArgs {
    /// Indirect light [default: what the scene asks for]
    #[arg(long, value_enum)]
    pub gi: Option<Gi>,
    /// Part of the picture to show
    #[arg(long, value_enum, default_value_t = Only::Total)]
    pub only: Only,
    /// Leave the edges of display images as they are drawn (measured images always do: EXR, --aa, layers)
    #[arg(long)]
    pub no_mlaa: bool,
    /// What tells the edges that are smoothed
    #[arg(long, value_enum, default_value_t = Edges::Color)]
    pub mlaa_edges: Edges,
    /// Settings of `--gi reference`.
    #[command(flatten)]
    pub trace: TraceArgs,
    /// Draw each light in a pass of its own; without this those without shadows share one
    #[arg(long)]
    pub each_light_alone: bool,
    /// Instant radiosity: show the light of one virtual light alone, by its number from 0
    #[arg(long, value_name = "N")]
    pub virtual_light: Option<u32>,
    /// Instant radiosity: draw the ways of the first N particles of every source over the image
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u32).range(0..=1024))]
    pub particle_paths: u32,
    /// What is drawn over display images.
    #[command(flatten)]
    pub debug: DebugArgs,
    /// Camera by name [default: the scene's primary camera]
    #[arg(long, value_name = "NAME")]
    pub camera: Option<String>,
    /// Change a value of the loaded scene: `ENTITY.COMPONENT.FIELD=VALUE`, `clpv.FIELD=VALUE`, `vpl.FIELD=VALUE`,
    /// `slc.FIELD=VALUE` or `scene.FIELD=VALUE`, with the value as in scene files, or `preset=NAME` for a set of changes
    /// that the scene's
    /// file lists; may be given many times
    #[arg(long = "set", value_name = "PATH=VALUE", value_parser = parse_assignment)]
    pub sets: Vec<(String, String)>,
}

/// What is drawn over display images.
#[derive(Args, Clone, Debug, PartialEq)]
pub struct DebugArgs {
    /// Draw over the image (PNG and window): lights, cameras, cascades, coverage, light, blockers, voxels, bvh,
    /// virtual-lights, directions; several with commas
    #[arg(long = "debug", value_name = "NAME", value_delimiter = ',')]
    pub views: Vec<DebugView>,
    /// Light volume whose cells `light`, `blockers` and `voxels` show; 0 is the finest
    #[arg(long = "debug-cascade", value_name = "N", default_value_t = 0)]
    pub cascade: u32,
    /// Level of the ray hierarchy that `bvh` shows; 0 is the box around everything
    #[arg(long = "debug-level", value_name = "N", default_value_t = 8)]
    pub bvh_level: u32,
}

impl Default for DebugArgs {
    fn default() -> Self {
        Self { views: Vec::new(), cascade: 0, bvh_level: 8 }
    }
}

/// Settings of path tracing.
#[derive(Args, Clone, Debug)]
pub struct TraceArgs {
    /// Path tracing: samples a pixel
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u32).range(1..=1 << 24))]
    pub spp: u32,
    /// Path tracing: indirect bounces [default: unlimited]
    #[arg(long, value_name = "K")]
    pub bounces: Option<u32>,
    /// Path tracing: seed of the random numbers
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub seed: u32,
}

impl Default for TraceArgs {
    fn default() -> Self {
        Self { spp: 64, bounces: None, seed: 0 }
    }
}

const RENDER_HELP: &str = "\
Examples:
  lightwell render cornell -o a.png
  lightwell render cornell -o a.exr --time 1.5 --aa 16 --gi none
  lightwell render cornell -o truth.exr --gi reference --spp 1024 --resume truth.part
  lightwell render cornell -o 'a_{}.png' --frames 0..30 --set clpv.steps=32 --set 'Spot light.light.color=(1, 0.2, 0.1)'

The ending of OUT chooses the format: .exr holds float32 linear radiance, .png what a screen would show
(exposed and tone mapped). The same command gives the same bytes on the same adapter.";

/// Arguments of `render`.
#[derive(Args, Debug)]
#[command(after_help = RENDER_HELP)]
pub struct RenderArgs {
    /// Scene file, or name of a scene in `scenes`
    pub scene: String,
    /// File to write; with --frames its `{}` becomes the frame's number (else `_0001` is put before the ending)
    #[arg(short, long, value_name = "OUT.{png,exr}", value_parser = parse_output)]
    pub output: PathBuf,
    /// Size of the image in pixels
    #[arg(long, value_name = "WxH", default_value = "512x512", value_parser = parse_size)]
    pub size: [u32; 2],
    /// Time in seconds [default: 0]
    #[arg(long, value_name = "S", value_parser = parse_time, conflicts_with = "frames")]
    pub time: Option<f64>,
    /// Frames of the scene's clock, from A up to but without B
    #[arg(long, value_name = "A..B", value_parser = parse_frames)]
    pub frames: Option<Range<u64>>,
    /// Choices that change the picture.
    #[command(flatten)]
    pub look: LookArgs,
    /// Path tracing: keep the half-done image in FILE, and go on from there if the work is interrupted
    #[arg(long, value_name = "FILE", conflicts_with = "frames")]
    pub resume: Option<PathBuf>,
    /// Average N frames with shifted pixel grids, as a box filter over the pixel (path tracing does so by itself)
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=65536))]
    pub aa: u32,
}

/// Method of indirect light.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, ValueEnum)]
pub enum Gi {
    /// Direct light alone
    None,
    /// Cascaded light propagation volumes: the scene's, or one that fits it if it has none
    Clpv,
    /// Instant radiosity: virtual point lights, as the scene sets them or by default
    Vpl,
    /// Stochastic light culling: one bounce from virtual lights, by the scene's `slc` component or by default
    Slc,
    /// Path tracing, the reference: slow, and right but for noise
    Reference,
}

/// Part of the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Only {
    /// Direct and indirect light
    #[default]
    Total,
    /// Light that comes straight from lights
    Direct,
    /// Light that other surfaces pass on
    Indirect,
    /// Base colour
    Albedo,
    /// Normals in world space
    Normal,
    /// Distance along the view direction
    Depth,
}

impl Only {
    /// Whether it shows light, rather than what the surfaces are.
    pub fn is_light(self) -> bool {
        matches!(self, Self::Total | Self::Direct | Self::Indirect)
    }
}

const COMPARE_HELP: &str = "\
Metrics, on linear RGB over all pixels, without any gain fitting (a: the image, r: the reference):
  rmse   sqrt(mean((a - r)^2))
  nrmse  rmse / mean(r)
  bias   mean(a) / mean(r) - 1
  p95    95th percentile of |a - r|, over mean(r)
  flip   mean of the perceptual difference FLIP, tone mapped at an exposure chosen from the reference
Where mean(r) = 0 the image must be exactly zero.

Examples:
  lightwell compare a.exr reference.exr --max nrmse=0.1,bias=0.02 --difference where.png
  lightwell compare a.exr reference.exr --figure beside.png
  lightwell compare a.exr reference.exr --halves even.exr odd.exr     (the reference is the mean of both)";

/// Arguments of `compare`.
#[derive(Args, Debug)]
#[command(after_help = COMPARE_HELP)]
pub struct CompareArgs {
    /// Image: .exr, .png or .jpg
    #[arg(value_name = "A")]
    pub image: PathBuf,
    /// Reference
    #[arg(value_name = "B")]
    pub reference: PathBuf,
    /// Metrics to print
    #[arg(long, value_enum, value_delimiter = ',', default_value = "nrmse,rmse,bias,p95,flip")]
    pub metric: Vec<Metric>,
    /// Write a picture of the signed difference: red too bright, blue too dark, full colour at mean(r)
    #[arg(long, value_name = "OUT.{png,exr}", value_parser = parse_output)]
    pub difference: Option<PathBuf>,
    /// Write image, reference and difference side by side, the first two exposed and tone mapped alike
    #[arg(long, value_name = "OUT.{png,exr}", value_parser = parse_output)]
    pub figure: Option<PathBuf>,
    /// Two independent halves of the reference: nrmse and rmse are then free of its noise, which is printed too
    #[arg(long, num_args = 2, value_names = ["R1", "R2"])]
    pub halves: Vec<PathBuf>,
    /// Largest value allowed (of bias: in size); past it the exit code is 1. May be given many times
    #[arg(long, value_name = "METRIC=X", value_delimiter = ',', value_parser = parse_bound)]
    pub max: Vec<(Metric, f64)>,
}

/// An error metric.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Metric {
    /// Relative root mean square error
    Nrmse,
    /// Root mean square error
    Rmse,
    /// Relative error of the mean
    Bias,
    /// 95th percentile of the relative error
    P95,
    /// Perceptual difference
    Flip,
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

const TEST_HELP: &str = "\
A scene test is a file NAME.test.ron: a scene, times, camera, size and settings, and what must hold: golden images,
errors against references, what passes do, counts, equal bits in a second run. No pixel may ever be NaN.

Examples:
  lightwell test                                all tests in tests/scenes
  lightwell test --filter cornell               those with `cornell` in their name
  lightwell test my.test.ron --bless            write its golden images: look at them before they are committed
  lightwell test -o failures --jobs 1           pictures of what fails into failures/, one test at a time

Exit codes: 0 all that ran passed; 1 a test failed or there are none; 2 wrong usage.";

/// Arguments of `test`.
#[derive(Args, Debug)]
#[command(after_help = TEST_HELP)]
pub struct TestArgs {
    /// Scene tests, or folders of them [default: tests/scenes]
    #[arg(value_name = "PATH")]
    pub paths: Vec<PathBuf>,
    /// Run only tests with TEXT in their name; may be given many times
    #[arg(short, long, value_name = "TEXT")]
    pub filter: Vec<String>,
    /// List the tests and run none
    #[arg(long)]
    pub list: bool,
    /// Write the golden images that are missing or do not match
    #[arg(long, conflicts_with = "list")]
    pub bless: bool,
    /// Folder for pictures of what fails
    #[arg(short, long, value_name = "DIR", default_value = "out/tests")]
    pub output: PathBuf,
    /// Number of tests that run side by side [default: by cores and free memory]
    #[arg(short, long, value_name = "N")]
    pub jobs: Option<std::num::NonZeroU16>,
}

pub(crate) fn parse_size(text: &str) -> Result<[u32; 2], String> {
    let parse = || {
        let (width, height) = text.split_once(['x', 'X'])?;
        Some([width.trim().parse().ok()?, height.trim().parse().ok()?])
    };
    match parse() {
        Some(size @ [1..=16384, 1..=16384]) => Ok(size),
        Some(_) => Err("width and height must be 1 to 16384 pixels".to_owned()),
        None => Err("write it as WIDTHxHEIGHT, for instance 512x512".to_owned()),
    }
}

fn parse_frames(text: &str) -> Result<Range<u64>, String> {
    let parse = || {
        let (from, to) = text.split_once("..")?;
        Some(from.trim().parse().ok()?..to.trim().parse().ok()?)
    };
    let range: Range<u64> = parse().ok_or("write it as A..B, for instance 0..30")?;
    if range.is_empty() {
        return Err(format!("there is no frame from {} up to but without {}", range.start, range.end));
    }
    Ok(range)
}

fn parse_time(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(time) if time.is_finite() && time >= 0.0 => Ok(time),
        _ => Err("give seconds, zero or more".to_owned()),
    }
}

fn parse_output(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    let ending = path.extension().map(|e| e.to_string_lossy().to_lowercase());
    match ending.as_deref() {
        Some("png" | "exr") => Ok(path),
        _ => Err("the name must end in .png or .exr".to_owned()),
    }
}

/// A path and its value, from `PATH=VALUE`.
///
/// # Errors
/// If there is no `=`, or nothing on one side of it.
pub fn parse_assignment(text: &str) -> Result<(String, String), String> {
    let (path, value) = text.split_once('=').ok_or("write it as PATH=VALUE, for instance clpv.steps=32")?;
    let (path, value) = (path.trim(), value.trim());
    if path.is_empty() || value.is_empty() {
        return Err("neither PATH nor VALUE may be empty".to_owned());
    }
    Ok((path.to_owned(), value.to_owned()))
}

fn parse_bound(text: &str) -> Result<(Metric, f64), String> {
    let (name, bound) = text.split_once('=').ok_or("write it as METRIC=X, for instance nrmse=0.1")?;
    let metric = Metric::from_str(name.trim(), true)
        .map_err(|_| format!("there is no metric `{}`; there are nrmse, rmse, bias, p95 and flip", name.trim()))?;
    match bound.trim().parse::<f64>() {
        Ok(bound) if bound >= 0.0 => Ok((metric, bound)),
        _ => Err(format!("`{}` is no bound; give a number, zero or more", bound.trim())),
    }
}

#[cfg(test)]
mod tests {
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
        assert_eq!(parse_bound("bias=0.5"), Ok((Metric::Bias, 0.5)));
        assert!(
            parse_bound("luck=1").is_err() && parse_bound("nrmse=-1").is_err() && parse_bound("nrmse=NaN").is_err()
        );
        let assignment = parse_assignment("a.b=(x = 1)");
        assert_eq!(assignment, Ok(("a.b".to_owned(), "(x = 1)".to_owned())));
        assert!(parse_output("a.jpg").is_err() && parse_output("png").is_err() && parse_output("a.PNG").is_ok());
    }
}
