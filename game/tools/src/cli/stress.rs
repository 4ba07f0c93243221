//! Arguments of `lightwell stress`.

use clap::Args;
use std::path::PathBuf;

const STRESS_HELP: &str = "\
Examples:
  lightwell stress -o out/stress                  one row of the matrix for each method: a few minutes
  lightwell stress --full -o out/stress           every pair of method, scale, light, turn, place and grid; long runs
  lightwell stress --full --method sweep,vpl -o out/stress

A room is drawn by every light method at scales of 1e-3 to 1e3, under lights of 1e-6 to 1e6, turned, and far from the
origin, and what must hold for every scene is checked: no light without lamps, twice the light twice the image, the
same image mirrored, moved, or drawn again, and more. Broken scenes must give an image or an error. The animated
scenes are played for thousands of frames: no memory may grow, and the first frame must be the same at the end.
Writes DIR/stress.txt and DIR/stress.png, and the scenes of what is beyond its bound.

Exit codes: 0 all within bounds; 1 something is not, or the work could not be done; 2 wrong usage.";

/// Arguments of `stress`.
#[derive(Args, Debug)]
#[command(after_help = STRESS_HELP)]
pub struct StressArgs {
    /// Folder to write into
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,
    /// The whole matrix
    #[arg(long)]
    pub full: bool,
    /// Frames of each long run with --full; all but the two box scenes take a seventh to a twentieth, two loops or more
    #[arg(long, value_name = "N", default_value_t = 10_000)]
    pub frames: u32,
    /// Methods by name: direct, diffusion, sweep, half sweep, gather, vpl, slc, reference [default: all]
    #[arg(long = "method", value_name = "NAME,...", value_delimiter = ',',
        value_parser = ["direct", "diffusion", "sweep", "half sweep", "gather", "vpl", "slc", "reference"])]
    pub methods: Vec<String>,
    /// The long run of one scene alone, told in lines: what `--full` calls for each
    #[arg(long, value_name = "SCENE", hide = true)]
    pub endure: Option<String>,
}

impl StressArgs {
    /// Whether a method is wanted.
    pub fn takes(&self, method: &str) -> bool {
        self.methods.is_empty() || self.methods.iter().any(|wanted| wanted == method)
    }
}
