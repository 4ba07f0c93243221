//! The arguments of each tool.

mod bench;
mod compare;
mod explain;
mod pack;
mod parse;
mod quality;
mod render;
mod sheet;
mod stress;
mod test;

pub use bench::{BenchArgs, Bounces, Grows, Sweep};
pub use compare::{CompareArgs, Metric};
pub use explain::ExplainArgs;
pub use pack::PackArgs;
pub use quality::{Quality, QualityArgs};
pub use render::RenderArgs;
pub use sheet::SheetArgs;
pub use stress::StressArgs;
pub use test::TestArgs;

/// The command line of `bench` alone.
#[cfg(test)]
#[derive(clap::Parser)]
pub struct BenchLine {
    /// The arguments.
    #[command(flatten)]
    pub args: BenchArgs,
}
