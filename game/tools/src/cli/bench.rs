//! Arguments of `bench`.

use super::parse::parse_time;
use clap::{Args, ValueEnum};
use lightwell_runtime::cli::parse_size;
use std::path::PathBuf;

const BENCH_HELP: &str = "\
Measures for each scene and variant the time of each stage, counts, memory, and the error against path-traced
references, and writes results.json, report.md, plots of time against error, and pictures into DIR. Each finished
measurement is written at once: the same command goes on where an interrupted run stopped.

Examples:
  lightwell bench cornell --quick -o out/bench
  lightwell bench cornell -o out/steps --sweep steps
  lightwell bench cornell -o out/mine --variant 'fine: clpv.cells=(16, 16, 14), clpv.cell_size=Meters(0.15)'
  lightwell bench -o out/all --models ~/models             all scenes whose models are there
  lightwell bench -o out/growth --growth objects,lights    time and memory over their number
  lightwell bench courtyard -o out/host --host             what a frame costs the host alone
  lightwell bench --thesis -o out/thesis --models ~/models tables and figures of the thesis, side by side
  lightwell bench --light-culling -o out/culling           tables and figures of the culling paper, side by side
  lightwell bench --instant-radiosity -o out/report        figures of the report on virtual point lights
  lightwell bench --cliffs -o out/cliffs                   what one small thing of each kind adds to a room's cost
  lightwell bench --noise -o out/noise                     noise of images and windows, at rest, in motion, after changes
  lightwell bench --response -o out/response               how soon a window follows lights, doors, objects, the camera
  lightwell bench --rooms 100 --seed 1 -o out/rooms        errors over random rooms
  lightwell bench cornell -o out/pt --method reference --spp 1,4,16,64,256

A variant is 'NAME: PATH=VALUE, ...' with the paths of --set; beside them there are gi, spp, bounces, and average=on:
flicker is then that of frames that are averaged with those before.
Times and errors of all variants of a scene are taken in turns, so that a machine that drifts favours none.";

/// Arguments of `bench`.
#[derive(Args, Clone, Debug)]
#[command(after_help = BENCH_HELP)]
pub struct BenchArgs {
    /// Scenes: files, or names in `scenes` [default: all shipped scenes, and those whose models are there]
    #[arg(value_name = "SCENE")]
    pub scenes: Vec<String>,
    /// Folder for the results
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,
    /// A few minutes: one time, small images, stored references
    #[arg(long)]
    pub quick: bool,
    /// Methods to compare: none, clpv, sweep low|medium|high|ultra, gather medium|high|ultra, filtered paths 1|4 spp,
    /// slc, vpl 64|256|1024|4096, gather|sweep low|sweep high 1 bounce, reference and others, which a wrong name lists
    /// [default: all but those of one bounce; quick: without ultra]
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    pub method: Vec<String>,
    /// A method in other settings; may be given many times
    #[arg(long, value_name = "NAME: PATH=VALUE, ...")]
    pub variant: Vec<String>,
    /// Path tracing: samples a pixel [default: 1,4,16,64,256; quick: 1,4,16]
    #[arg(long, value_name = "N", value_delimiter = ',')]
    pub spp: Vec<u32>,
    /// Sweep a setting of the light volumes, as in the thesis's figures 7.9 and 7.10
    #[arg(long, value_enum)]
    pub sweep: Vec<Sweep>,
    /// How cost grows with what a scene holds, in scenes made for it; without SCENE nothing else is measured
    #[arg(long, value_enum, value_name = "WHAT", value_delimiter = ',')]
    pub growth: Vec<Grows>,
    /// Sizes at which times are taken; plots use the first [default: 512x512,1024x1024; quick: 512x512]
    #[arg(long, value_name = "WxH", value_delimiter = ',', value_parser = parse_size, allow_hyphen_values = true)]
    pub time_size: Vec<[u32; 2]>,
    /// Size at which errors are taken [default: 256x256; quick: 128x128]
    #[arg(long, value_name = "WxH", value_parser = parse_size, allow_hyphen_values = true)]
    pub error_size: Option<[u32; 2]>,
    /// Frames with shifted pixel grids that are averaged for an error [default: 16; --rooms: 8]; with --noise and --response
    /// at most so many for the converged image [default: 1024 and 256; quick: 64]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub aa: Option<u32>,
    /// Frames that are timed [default: 20; quick: 7]; with --noise those of a window at rest [default: 256; quick: 32]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10000))]
    pub frames: Option<u32>,
    /// Frames before those
    #[arg(long, value_name = "N", default_value_t = 2)]
    pub warm_up: u32,
    /// Times in seconds at which errors are taken [default: 0, a third and two thirds of the loop; quick: a third]
    #[arg(long, value_name = "S", value_delimiter = ',', value_parser = parse_time)]
    pub times: Vec<f64>,
    /// Samples a pixel of the references; with --rooms at most, fewer where they leave little noise
    /// [default: 1024; --rooms: 4096; --noise: 256]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=1 << 24))]
    pub reference_spp: Option<u32>,
    /// Indirect bounces of the references, `inf` or a number; the first is the one that plots show [default: inf]
    #[arg(long, value_name = "K", value_delimiter = ',', value_parser = parse_bounces)]
    pub bounces: Vec<Bounces>,
    /// Measure flicker over N frames: change from frame to frame beyond the reference's own; 0 leaves it out
    /// [default: 9; quick: 0]
    #[arg(long, value_name = "N", value_parser = parse_flicker)]
    pub flicker: Option<u32>,
    /// Measure the host alone: frames are recorded for a device that does nothing, still and with 1, 10 and 100 objects
    /// that move; nothing else is measured. Writes host.json and host.md [size: 1920x1080]
    #[arg(long, conflicts_with_all = ["growth", "sweep", "method", "variant"])]
    pub host: bool,
    /// Measure the thesis's tables 7.1, 7.3 and 7.4 and figures 7.2 to 7.10 in its six scenes, and write them beside the
    /// printed ones: thesis.json, thesis.md and pictures. SCENE names some of the six [frames: 30; --aa: 4; --reference-spp:
    /// 256]
    #[arg(long, conflicts_with_all = ["host", "growth", "sweep", "method", "variant", "rooms", "quick", "bless", "times"])]
    pub thesis: bool,
    /// Measure tables 1 and 2 and figures 9 and 10 of the culling paper (Tokuyoshi and Harada 2017), and write them beside the
    /// printed ones: light_culling.json, light_culling.md and pictures. SCENE names some of night_court, sibenik, sponza and
    /// glossy_ring [size: 1920x1080; frames: 30]
    #[arg(
        long,
        conflicts_with_all = [
            "host", "growth", "sweep", "method", "variant", "rooms", "quick", "bless", "times", "thesis", "cliffs", "aa",
            "reference_spp",
        ],
    )]
    pub light_culling: bool,
    /// Measure the figures of the report that instant radiosity follows, in scenes with a preset `report`: intersection tests
    /// against B·N/(1−ρ), draws against (7 + M)·B, pictures of single virtual lights and of particles, and the error over
    /// N. Writes instant_radiosity.json, instant_radiosity.md, plots and pictures [SCENE: vpl_report, cornell;
    /// --error-size: 128x128; --aa: 4; --reference-spp: 1024]
    #[arg(
        long, conflicts_with_all = [
            "host", "growth", "sweep", "method", "variant", "rooms", "quick", "bless", "times", "thesis", "time_size",
            "frames", "flicker", "spp", "bounces", "throughput",
        ],
    )]
    pub instant_radiosity: bool,
    /// Measure what one small thing of each kind (a blended card, glass, an emissive card, fog, ...) adds to the cost of each
    /// pass in a plain room; nothing else is measured. Writes cliffs.json and cliffs.md [size: 64x64]
    #[arg(long, conflicts_with_all = ["scenes", "growth", "sweep", "method", "variant", "host", "rooms", "instant_radiosity"])]
    pub cliffs: bool,
    /// Measure noise against what the method converges to: single images of each quality, windows at rest, in motion and
    /// after changes, near geometric edges and elsewhere, fine and coarse, fireflies, bias, and blocks that jump. Writes
    /// noise.json, noise.md and pictures [SCENE: cornell, bleeding_gloss, meeting_room, courtyard, gallery; --size: 512x512]
    #[arg(
        long, group = "sized", conflicts_with_all = [
            "host", "growth", "sweep", "method", "variant", "bless", "times", "thesis", "light_culling", "instant_radiosity",
            "cliffs", "time_size", "error_size", "spp", "bounces", "flicker", "throughput", "warm_up",
        ],
    )]
    pub noise: bool,
    /// Measure how soon a window follows: a light's step, a door that opens, an object that stops, jumps and flights of the
    /// camera; shadows after long motion, the same view twice, a sealed box. In rooms made for it. Writes response.json,
    /// response.md and pictures [--size: 512x512]
    #[arg(
        long, group = "sized", conflicts_with_all = [
            "scenes", "host", "growth", "sweep", "method", "variant", "bless", "times", "thesis", "light_culling",
            "instant_radiosity", "cliffs", "time_size", "error_size", "spp", "bounces", "flicker", "throughput", "frames",
            "reference_spp", "camera", "warm_up",
        ],
    )]
    pub response: bool,
    /// Measure windows as their users see them, on the display there is (`xvfb-run` gives one): when the first picture comes,
    /// pictures a second while the scene plays, how soon a turn of the camera shows, and how fast a view comes to rest. Writes
    /// window.json and window.md [SCENE: cornell, courtyard; --size: 1280x800]
    #[arg(
        long, group = "sized", conflicts_with_all = [
            "host", "growth", "sweep", "method", "variant", "bless", "times", "thesis", "light_culling", "instant_radiosity",
            "cliffs", "time_size", "error_size", "spp", "bounces", "flicker", "throughput", "frames", "aa", "reference_spp",
            "camera", "warm_up", "quick", "fresh",
        ],
    )]
    pub window: bool,
    /// Name of this run in the report of --host, beside others in DIR; the same name replaces its figures
    #[arg(long, value_name = "NAME", default_value = "now", requires = "host")]
    pub label: String,
    /// Measure errors over N random rooms in place of scenes: the default settings as a single image and as an average, and
    /// the volumes alone, or what --method and --variant name. Writes rooms.json, rooms.md with the distribution of errors,
    /// each room as a scene, and images of the worst
    #[arg(
        long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1_000_000), group = "sized",
        conflicts_with_all = [
            "scenes", "quick", "sweep", "growth", "time_size", "error_size", "frames", "warm_up", "times", "bounces", "flicker",
            "host", "throughput", "camera", "cache", "bless",
        ],
    )]
    pub rooms: Option<u64>,
    /// Seed of the random rooms: another one gives other rooms
    #[arg(long, value_name = "S", default_value_t = 1, requires = "rooms")]
    pub seed: u64,
    /// Image size of --noise and --response [default: 512x512], of the windows [default: 1280x800], and of the random rooms [default: 128x128]
    #[arg(long, value_name = "WxH", value_parser = parse_size, allow_hyphen_values = true, requires = "sized")]
    pub size: Option<[u32; 2]>,
    /// Write the random rooms as scenes and measure nothing
    #[arg(long, requires = "rooms")]
    pub list: bool,
    /// Measure the path tracer's paths a second against a tracer on the host
    #[arg(long)]
    pub throughput: bool,
    /// Camera by name [default: the scene's primary camera]
    #[arg(long, value_name = "NAME")]
    pub camera: Option<String>,
    /// Folder in which references are kept [default: out/references]
    #[arg(long, value_name = "DIR", default_value = "out/references")]
    pub cache: PathBuf,
    /// Store the references of this run in tests/references/bench
    #[arg(long)]
    pub bless: bool,
    /// Replace the results that DIR holds
    #[arg(long)]
    pub fresh: bool,
}

/// A setting that is swept.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Sweep {
    /// Propagation steps, on the scene's grid
    Steps,
    /// Cells of the grid, over the same room, with the scene's steps
    Grid,
}

/// What grows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Grows {
    /// All of these
    All,
    /// Entities, 10 to 100,000
    Objects,
    /// 10⁴ to 10⁷
    Triangles,
    /// Small lights, 1 to 10,000
    Lights,
    /// Cells of the light volume, 8³ to 128³
    Cells,
    /// Directions of the sweep
    Directions,
    /// Pixels, 128² to 2048²
    Pixels,
    /// Many lights against few, and many meshes against one
    Pairs,
}

impl Grows {
    /// Whether it names that, or all.
    pub fn takes(self, name: &str) -> bool {
        let named = self.to_possible_value().is_some_and(|value| value.get_name() == name);
        self == Self::All || named
    }
}

/// Indirect bounces of a reference; none: unlimited.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bounces(pub Option<u32>);

fn parse_flicker(text: &str) -> Result<u32, String> {
    match text.parse() {
        Ok(frames @ (0 | 3..=10_000)) => Ok(frames),
        _ => Err("give a number of frames, 3 to 10000, or 0 for none".to_owned()),
    }
}

fn parse_bounces(text: &str) -> Result<Bounces, String> {
    match text {
        "inf" => Ok(Bounces(None)),
        _ => text.parse().map(|bounces| Bounces(Some(bounces))).map_err(|_| "give a number or `inf`".to_owned()),
    }
}
