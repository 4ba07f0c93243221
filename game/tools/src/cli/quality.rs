//! How quiet images are to be, for commands that write them into files.

use super::parse::parse_seconds;
use clap::{Args, ValueEnum};

/// How little noise an image may have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Quality {
    /// Estimated error at most 0.04, within 10 s
    Fast,
    /// Estimated error at most 0.02, within 120 s
    Good,
    /// Estimated error at most 0.01, within 1200 s
    Best,
}

/// Choices of how long images are averaged.
#[derive(Args, Clone, Debug, Default)]
pub struct QualityArgs {
    /// PNG: average frames with other random numbers and shifted pixel grids until the estimated error is below a bound
    /// (mean FLIP, 0..1; 99 % of the pixels below five times as much) [default: good for one image, fast for each of
    /// several]
    #[arg(long, value_enum)]
    pub quality: Option<Quality>,
    /// PNG: end the average of an image after so many seconds, but not before two frames; what error is left is then
    /// told, and the bytes depend on the machine's speed [default: as the quality says]
    #[arg(long, value_name = "SECONDS", value_parser = parse_seconds)]
    pub time_limit: Option<f64>,
    /// Draw each averaged image at N shifts of the pixel grid, and gather its indirect light at one of them: edges get
    /// smooth at the price of surfaces and direct light alone [default: 4 where a quality is asked for, else 1]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    pub edges: Option<u32>,
}

impl QualityArgs {
    /// The option that was given, if any was.
    pub fn given(&self) -> Option<&'static str> {
        match self {
            Self { quality: Some(_), .. } => Some("--quality"),
            Self { time_limit: Some(_), .. } => Some("--time-limit"),
            _ => None,
        }
    }
}
