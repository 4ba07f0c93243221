//! Arguments of `lightwell sheet`.

use super::parse::parse_time;
use clap::Args;
use lightwell::render::GiMethod;
use lightwell_runtime::cli::{built_in_methods, method_parser, parse_assignment, parse_size};
use std::num::NonZeroU16;
use std::path::PathBuf;

const SHEET_HELP: &str = "\
Examples:
  lightwell sheet scenes -o out/scenes                    every scene of a folder
  lightwell sheet prefabs -o out/prefabs                  every prefab, framed and lit
  lightwell sheet ~/models/khronos -o out/khronos         every model below a folder
  lightwell sheet cornell courtyard my.glb -o out/three --size 400x300 --time 2
  lightwell sheet ~/models/khronos -o out/lit --gi clpv --set clpv.quality=Low --set 'clpv.bounces=Count(1)'

Writes DIR/sheet_01.png and so on, and DIR/sheet.txt with each file's triangles, times, warnings and errors. A file
that cannot be loaded or drawn is a cell with its message.

Exit codes: 0 the sheets were drawn, whatever is in them; 1 they could not be; 2 wrong usage.";

/// Arguments of `sheet`.
#[derive(Args, Debug)]
#[command(after_help = SHEET_HELP)]
pub struct SheetArgs {
    /// Scenes, prefabs and models by file or name, and folders, which are searched with all below them
    #[arg(value_name = "PATH", required = true)]
    pub paths: Vec<PathBuf>,
    /// Folder to write into
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,
    /// Size of a thumbnail in pixels
    #[arg(long, value_name = "WxH", default_value = "240x240", value_parser = parse_size, allow_hyphen_values = true)]
    pub size: [u32; 2],
    /// Thumbnails in a row [default: as many as fit 1800 pixels]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=64))]
    pub columns: Option<u16>,
    /// Time in seconds
    #[arg(long, value_name = "S", default_value = "0", value_parser = parse_time)]
    pub time: f64,
    /// Indirect light [default: what each scene asks for]
    #[arg(long, value_name = "GI", value_parser = method_parser(built_in_methods()))]
    pub gi: Option<GiMethod>,
    /// Change a value of every scene, as for `render`; may be given many times
    #[arg(long = "set", value_name = "PATH=VALUE", value_parser = parse_assignment)]
    pub sets: Vec<(String, String)>,
    /// Number of files drawn side by side [default: by cores and free memory]
    #[arg(short, long, value_name = "N")]
    pub jobs: Option<NonZeroU16>,
}
