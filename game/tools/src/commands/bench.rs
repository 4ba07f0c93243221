//! `lightwell bench`: time against error.

use crate::bench;
use crate::cli::BenchArgs;
use anyhow::Result;
use lightwell_runtime::cli::Common;
use lightwell_runtime::say;

/// Runs the measurements that are missing, and writes results, report, plots and images.
///
/// # Errors
/// If a scene cannot be loaded or drawn, or a file not be written.
pub fn run(args: &BenchArgs, common: &Common) -> Result<()> {
    let report = bench::run(args, common)?;
    say!("{}", report.display());
    Ok(())
}
