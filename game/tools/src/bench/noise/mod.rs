//! `bench --noise`: the noise of single images and of windows, at rest, in motion and after changes, against what the method
//! converges to.
//!
//! ```text
//! change (what is done before) ─ measure (images, converged image, path tracer) ─ measures (grain, blotches, ...)
//!                                                └─ noise.json ─ report ─ noise.md, pictures
//! ```

mod change;
mod converged;
mod figures;
mod measure;
mod measures;
mod pictures;
mod report;
#[cfg(test)]
mod tests;

pub(super) use change::turned;
pub(super) use converged::{Converged, direct};
pub(super) use measures::{difference, local_means, percentile};

use super::report::markdown;
use super::{fixture, machine, results};
use crate::cli::BenchArgs;
use anyhow::{Context, Result};
use figures::{Results, SceneFigures};
use lightwell_runtime::cli::Common;
use lightwell_runtime::progress;
use measure::Subject;
use std::path::PathBuf;

/// Scenes, unless others are asked for.
const SCENES: [&str; 5] = ["cornell", "bleeding_gloss", "meeting_room", "courtyard", "gallery"];
/// Size of the images, if not said [pixels].
const SIZE: [u32; 2] = [512; 2];

/// Steps of a scene, at most.
const STEPS: u64 = 13;

/// How everything is measured.
#[derive(Clone, Debug)]
struct Course {
    size: [u32; 2],
    /// Frames of a window at rest.
    rest: u32,
    /// Frames of a window before a sudden change.
    lead: u32,
    /// Most frames of the converged image.
    most_frames: u32,
    /// Images averaged for a converged screen.
    images: u32,
    /// Steps from frame to frame in which blocks may jump.
    played: u32,
    /// Samples a pixel of the path tracer.
    samples: u32,
    cache: PathBuf,
}

impl Course {
    fn of(args: &BenchArgs) -> Self {
        let by_length = |full: u32, quick: u32| if args.quick { quick } else { full };
        Self {
            size: args.size.unwrap_or(SIZE),
            rest: args.frames.unwrap_or(by_length(256, 32)),
            lead: by_length(32, 8),
            most_frames: args.aa.unwrap_or(by_length(1024, 64)),
            images: by_length(16, 4).min(args.aa.unwrap_or(u32::MAX)),
            played: by_length(16, 4),
            samples: args.reference_spp.unwrap_or(by_length(256, 64)),
            cache: args.cache.clone(),
        }
    }

    fn in_words(&self) -> String {
        format!(
            "Images of {} pixels, {} frames at rest, {} before a change, {} steps of motion, at most {} frames of the \
             converged image and {} of a converged screen, references of {} samples a pixel",
            markdown::size(self.size),
            self.rest,
            self.lead,
            self.played,
            self.most_frames,
            self.images,
            self.samples
        )
    }
}

/// Measures the scenes that are missing in the folder, and writes `noise.json`, `noise.md` and pictures; gives the report's
/// path.
///
/// # Errors
/// If a scene cannot be loaded or drawn, or a file not be written.
pub(super) fn run(args: &BenchArgs, common: &Common) -> Result<PathBuf> {
    let course = Course::of(args);
    let scenes: Vec<&str> = match args.scenes.is_empty() {
        true => SCENES.to_vec(),
        false => args.scenes.iter().map(String::as_str).collect(),
    };
    let gpu = fixture::open_gpu(common)?;
    let header = machine::header(&gpu, course.in_words())?;
    let mut subjects = scenes
        .iter()
        .map(|scene| Subject::open(&gpu, scene, args.camera.as_deref(), common))
        .collect::<Result<Vec<_>>>()?;
    std::fs::create_dir_all(&args.output).with_context(|| format!("cannot make {}", args.output.display()))?;
    let file = args.output.join("noise.json");
    let old = results::take_up(&file, &header, args.fresh, |old: &mut Results| &mut old.header)?;
    let mut results = old.unwrap_or_else(|| Results { header, scenes: Vec::new() });
    let bar = progress::bar(subjects.len() as u64 * STEPS, "bench --noise");
    let report = args.output.join("noise.md");
    for (index, subject) in (0..).zip(&mut subjects) {
        let name = subject.name();
        let is_done = |scene: &SceneFigures| scene.name == name && scene.course == course.in_words();
        if !results.scenes.iter().any(is_done) {
            let mut step = index * STEPS;
            let told = &mut |what: &str| {
                bar.set_message(format!("{name}: {what}"));
                bar.set_position(step);
                step += 1;
            };
            let measured = measure::measure(subject, &course, &args.output, told);
            let measured = measured.with_context(|| format!("scene `{name}`"))?;
            results.put(measured);
            results::write_whole(&file, serde_json::to_string_pretty(&results)?.as_bytes())?;
            results::write_whole(&report, report::text(&results).as_bytes())?;
        }
        bar.set_position((index + 1) * STEPS);
    }
    bar.finish_and_clear();
    results::write_whole(&report, report::text(&results).as_bytes())?;
    Ok(report)
}

impl Results {
    /// Adds a scene, in place of what an earlier run in other settings left of it.
    fn put(&mut self, scene: SceneFigures) {
        match self.scenes.iter_mut().find(|old| old.name == scene.name) {
            Some(old) => *old = scene,
            None => self.scenes.push(scene),
        }
    }
}
