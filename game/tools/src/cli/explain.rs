//! The command line of `explain`.

use super::parse::parse_time;
use clap::Args;
use lightwell_runtime::cli::{LookArgs, parse_size};

/// Arguments of `explain`.
#[derive(Args, Debug)]
pub struct ExplainArgs {
    /// Scene file, or name of a scene in `scenes`
    pub scene: String,
    /// Size of the image in pixels
    #[arg(long, value_name = "WxH", default_value = "512x512", value_parser = parse_size, allow_hyphen_values = true)]
    pub size: [u32; 2],
    /// Time in seconds
    #[arg(long, value_name = "S", default_value = "0", value_parser = parse_time)]
    pub time: f64,
    /// List the targets of the first frame, for --debug-target
    #[arg(long)]
    pub targets: bool,
    /// Choices that change the image.
    #[command(flatten)]
    pub look: LookArgs,
}
