//! `lightwell sheet`: many models, prefabs and scenes as labelled thumbnails, to be looked at side by side.
//!
//! ```text
//! subject (which files) ─ cell (load and draw each, side by side) ─┬─ page (sheet_01.png …)
//!                                                                  └─ report (sheet.txt)
//! ```
//! A file that cannot be loaded or drawn is a cell too, with its message.

mod cell;
mod page;
mod report;
mod subject;

use crate::cli::SheetArgs;
use crate::scene_test::default_workers;
use anyhow::{Context, Result, bail};
use cell::Cell;
use lightwell_runtime::cli::Common;
use lightwell_runtime::progress;
use lightwell_runtime::say;
use std::num::NonZeroU16;

/// Draws the sheets and their report.
///
/// # Errors
/// If there is nothing to draw, or a file cannot be written. What is wrong with a model or scene is in its cell.
pub fn run(args: &SheetArgs, common: &Common) -> Result<()> {
    let subjects = subject::find(&args.paths)?;
    if subjects.is_empty() {
        bail!("there is no .scene.ron, .prefab.ron, .gltf or .glb file in what was given");
    }
    std::fs::create_dir_all(&args.output)
        .with_context(|| format!("cannot make the folder {}", args.output.display()))?;
    let workers = args.jobs.map_or_else(default_workers, |jobs: NonZeroU16| usize::from(jobs.get()));
    let bar = progress::bar(subjects.len() as u64, "drawing");
    let cells: Vec<Cell> = cell::draw_all(&subjects, args, common, workers, &|| bar.inc(1));
    bar.finish_and_clear();
    let pages = page::write(&args.output, args, &subjects, &cells)?;
    let summary = report::write(&args.output.join("sheet.txt"), &subjects, &cells)?;
    say!("{summary}");
    for path in pages {
        say!("{}", path.display());
    }
    say!("{}", args.output.join("sheet.txt").display());
    Ok(())
}
