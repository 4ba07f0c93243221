//! Long runs in processes of their own, several at once: a frame of 48×48 pixels keeps no processor busy, and what a
//! process holds at its end is what that one run has left behind.
//!
//! The program calls itself with `--endure SCENE`; that process writes a line for each frame, and at last one with what
//! the run came to.

use super::endurance::{Endured, endure};
use crate::cli::StressArgs;
use anyhow::{Context, Result, bail};
use lightwell_runtime::cli::Common;
use lightwell_runtime::progress::Bar;
use lightwell_runtime::session::open_gpu;
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Command, ExitCode, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// The line that stands for a frame.
const FRAME: &str = ".";

/// One run, here, told in lines on the output stream.
///
/// # Errors
/// If it cannot be drawn, or nobody reads the lines.
pub fn run_here(scene: &str, args: &StressArgs, common: &Common) -> Result<ExitCode> {
    let gpu = Arc::new(open_gpu(common)?);
    let out = std::io::stdout();
    // A reader that went away shows when the last line is written.
    let frame = || _ = writeln!(&out, "{FRAME}");
    let run = endure(gpu, scene, args.frames, common, &frame)?;
    writeln!(&out, "{}", serde_json::to_string(&run)?)?;
    Ok(ExitCode::SUCCESS)
}

/// All runs, as many at once as there are processors; in their order.
///
/// # Errors
/// The first run that cannot be drawn; the others are run to their end.
pub fn run_all(runs: &[(&str, u32)], common: &Common, bar: &Bar) -> Result<Vec<Endured>> {
    let program = std::env::current_exe().context("cannot find this program to call it")?;
    let next = AtomicUsize::new(0);
    let ended = Mutex::new(Vec::with_capacity(runs.len()));
    let work = || {
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            let Some(&(scene, frames)) = runs.get(index) else { return };
            let run = call(&program, scene, frames, common, bar).with_context(|| format!("the long run of {scene}"));
            ended.lock().unwrap_or_else(PoisonError::into_inner).push((index, run));
        }
    };
    let processors = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| (0..processors.min(runs.len())).for_each(|_| drop(scope.spawn(work))));
    let mut ended = ended.into_inner().unwrap_or_else(PoisonError::into_inner);
    ended.sort_by_key(|(index, _)| *index);
    ended.into_iter().map(|(_, run)| run).collect()
}

/// One run in a process of its own.
fn call(program: &Path, scene: &str, frames: u32, common: &Common, bar: &Bar) -> Result<Endured> {
    let mut command = Command::new(program);
    // It writes no file: any folder will do.
    command.args(["stress", "--endure", scene, "--frames", &frames.to_string(), "-o", "."]).args(common.arguments());
    let mut process = command.stdin(Stdio::null()).stdout(Stdio::piped()).spawn()?;
    let mut outcome = None;
    if let Some(out) = process.stdout.take() {
        for line in BufReader::new(out).lines() {
            match line?.as_str() {
                FRAME => bar.inc(1),
                line => outcome = Some(serde_json::from_str(line).with_context(|| format!("not a run: {line}"))?),
            }
        }
    }
    let status = process.wait()?;
    match outcome {
        Some(run) if status.success() => Ok(run),
        _ => bail!("its process ended early: {status}"),
    }
}
