//! `bench --response`: how soon a window follows what changes, in rooms made for it, with the cases of the nearest rival.
//!
//! ```text
//! cases (rooms, and what changes in them) ─ measure (frames after it, converged picture) ─ response.json, response.md, pictures
//! ```

mod cases;
mod figures;
mod measure;
mod report;
#[cfg(test)]
mod tests;

use super::report::markdown;
use super::{fixture, machine, results};
use crate::cli::BenchArgs;
use anyhow::{Context, Result};
use cases::CASES;
use figures::Results;
use lightwell_runtime::cli::Common;
use lightwell_runtime::progress;
use measure::Rig;
use std::path::{Path, PathBuf};

/// Size of the images, if not said [pixels].
const SIZE: [u32; 2] = [512; 2];
/// Frames after a change that are judged.
const AFTER: [u32; 4] = [1, 3, 8, 32];

/// How everything is measured.
#[derive(Clone, Debug)]
struct Course {
    size: [u32; 2],
    /// Frames of a window before a sudden change.
    lead: u32,
    /// Frames after a change.
    after: u32,
    /// Images in the converged picture.
    images: u32,
}

impl Course {
    fn of(args: &BenchArgs) -> Self {
        let by_length = |full: u32, quick: u32| if args.quick { quick } else { full };
        Self {
            size: args.size.unwrap_or(SIZE),
            lead: by_length(64, 8),
            after: by_length(64, AFTER[AFTER.len() - 1]),
            images: args.aa.unwrap_or(by_length(256, 64)),
        }
    }

    fn in_words(&self) -> String {
        format!(
            "Images of {} pixels, {} frames before a sudden change and {} after it, converged pictures of {} images",
            markdown::size(self.size),
            self.lead,
            self.after,
            self.images
        )
    }
}

/// Takes the measurements that are missing in the folder, and writes `response.json`, `response.md` and pictures; gives the
/// report's path.
///
/// # Errors
/// If a room cannot be drawn, or a file not be written.
pub(super) fn run(args: &BenchArgs, common: &Common) -> Result<PathBuf> {
    let course = Course::of(args);
    let gpu = fixture::open_gpu(common)?;
    let header = machine::header(&gpu, course.in_words())?;
    std::fs::create_dir_all(&args.output).with_context(|| format!("cannot make {}", args.output.display()))?;
    let file = args.output.join("response.json");
    let old = results::take_up(&file, &header, args.fresh, |old: &mut Results| &mut old.header)?;
    let mut results = old.unwrap_or_else(|| Results { header, ..Results::default() });
    let words = course.in_words();
    let rig = Rig { gpu: &gpu, common, folder: &args.output };
    let bar = progress::bar(CASES.len() as u64 + 2, "bench --response");
    for case in &CASES {
        let is_there = |picture: &str| args.output.join(picture).is_file();
        let same = |old: &figures::CaseFigures| old.name == case.name && old.course == words && is_there(&old.picture);
        if !results.cases.iter().any(same) {
            bar.set_message(case.name);
            let measured = rig.case(case, &course).with_context(|| case.name)?;
            match results.cases.iter_mut().find(|old| old.name == case.name) {
                Some(old) => *old = measured,
                None => results.cases.push(measured),
            }
            save(&args.output, &results)?;
        }
        bar.inc(1);
    }
    if results.same_view.as_ref().is_none_or(|same| same.course != words) {
        bar.set_message("same view twice");
        results.same_view = Some(rig.same_view(&course).context("the same view twice")?);
        save(&args.output, &results)?;
    }
    bar.inc(1);
    if results.sealed.as_ref().is_none_or(|sealed| sealed.course != words) {
        bar.set_message("sealed box");
        results.sealed = Some(rig.sealed(&course).context("the sealed box")?);
    }
    bar.finish_and_clear();
    save(&args.output, &results)
}

/// Writes results and report; gives the latter's path.
fn save(folder: &Path, results: &Results) -> Result<PathBuf> {
    results::write_whole(&folder.join("response.json"), serde_json::to_string_pretty(results)?.as_bytes())?;
    let report = folder.join("response.md");
    results::write_whole(&report, report::text(results).as_bytes())?;
    Ok(report)
}
