//! The command line of `render`.

use super::QualityArgs;
use super::parse::{parse_frames, parse_output, parse_time};
use clap::Args;
use lightwell_runtime::cli::{LookArgs, parse_size};
use std::ops::Range;
use std::path::PathBuf;

const RENDER_HELP: &str = "\
Examples:
  lightwell render cornell -o a.png
  lightwell render cornell -o a.png --quality best --time-limit 300
  lightwell render cornell -o a.exr --time 1.5 --aa 16 --gi none
  lightwell render cornell -o truth.exr --gi reference --spp 1024 --resume truth.part
  lightwell render cornell -o 'a_{}.png' --frames 0..30 --set clpv.quality=Medium --set 'Spot light.light.color=(1, 0.2, 0.1)'

The ending of OUT chooses the format: .exr holds float32 linear radiance, .png what a screen would show
(exposed and tone mapped).

A .png of light is averaged until it is quiet: see --quality. --aa 1 writes a single frame. An .exr is a single frame, or
as many as --aa says; so is a .png of surfaces (--only albedo, normal, depth), with --debug, or with --average on. Path
tracing takes its samples from --spp.

The same command gives the same bytes on the same adapter, unless a time limit ends an average: that is told.";

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
    #[arg(long, value_name = "WxH", default_value = "512x512", value_parser = parse_size, allow_hyphen_values = true)]
    pub size: [u32; 2],
    /// Time in seconds [default: 0]
    #[arg(long, value_name = "S", value_parser = parse_time, conflicts_with = "frames")]
    pub time: Option<f64>,
    /// Frames of the scene's clock, from A up to but without B
    #[arg(long, value_name = "A..B", value_parser = parse_frames)]
    pub frames: Option<Range<u64>>,
    /// Choices that change the image.
    #[command(flatten)]
    pub look: LookArgs,
    /// Path tracing: keep the half-done image in FILE, and go on from there if the work is interrupted
    #[arg(long, value_name = "FILE", conflicts_with = "frames")]
    pub resume: Option<PathBuf>,
    /// Average exactly N frames with shifted pixel grids, as a box filter over the pixel (path tracing does so by itself)
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=65536),
        conflicts_with_all = ["quality", "time_limit"])]
    pub aa: Option<u32>,
    /// How quiet the image is.
    #[command(flatten)]
    pub quality: QualityArgs,
}
