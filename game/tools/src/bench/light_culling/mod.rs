//! `bench --light-culling`: tables 1 and 2 and figures 9 and 10 of the paper that light culling follows (Tokuyoshi and
//! Harada 2017), with our figures beside the printed ones.
//!
//! ```text
//! published (the printed figures) ────────────┐
//! measure (a scene) ─ light_culling.json ─────┴─ report ─ light_culling.md, pictures
//! ```

mod measure;
mod published;
mod report;

use super::machine;
use super::results::{self, Header};
use crate::cli::BenchArgs;
use anyhow::{Context, Result, bail};
use lightwell_runtime::cli::Common;
use lightwell_runtime::progress;
use published::{SUBJECTS, Subject};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Frames that are timed, if not said.
const FRAMES: u32 = 30;

/// What is measured.
#[derive(Clone, Debug)]
struct Course {
    /// Of times and counts.
    size: [u32; 2],
    frames: u32,
    error_size: [u32; 2],
    /// Edge of the lights' map, where it is not the paper's.
    map: Option<u32>,
}

/// All results in a folder.
#[derive(Debug, Default, Serialize, Deserialize)]
struct Results {
    header: Header,
    subjects: Vec<SubjectResults>,
}

/// The figures of a scene, or of a roughness.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
struct SubjectResults {
    /// Its name in the paper.
    name: String,
    /// Our scene, which may be a stand-in.
    scene: String,
    triangles: u64,
    /// Virtual lights.
    lights: u64,
    /// Of times and counts.
    size: [u32; 2],
    frames: usize,
    /// Medians of table 1's columns \[ms\].
    times: [f64; 6],
    /// Medians of table 2's rows \[ms\], diffuse and glossy lights; or why there is none.
    ways: [[Measured; 3]; 2],
    /// Rows of figure 9 or 10.
    bounds: [BoundRow; 3],
    error: Error,
    pictures: Vec<String>,
}

/// A time, or why there is none.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
enum Measured {
    /// [ms].
    Ms(f64),
    /// In the renderer's words.
    Refused(String),
}

impl Default for Measured {
    fn default() -> Self {
        Self::Ms(0.0)
    }
}

/// A bound of the lights' ranges.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
struct BoundRow {
    /// All of table 1 \[ms\].
    total_ms: f64,
    glossy: Counts,
    diffuse: Counts,
}

/// Lights a pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Counts {
    tested: f64,
    accepted: f64,
}

impl Counts {
    /// False positives.
    fn in_vain(self) -> f64 {
        self.tested - self.accepted
    }
}

/// Of an image against the sum over all lights.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Error {
    size: [u32; 2],
    /// Radiance \[W/(m² sr)\].
    rmse: f64,
    /// Over the mean of the sum.
    nrmse: f64,
    bias: f64,
}

/// Measures what is missing in the folder, scene by scene, and writes the report; returns its path.
///
/// # Errors
/// If a scene is none of the paper's or cannot be loaded or drawn, or a file not be written.
pub(super) fn run(args: &BenchArgs, common: &Common) -> Result<PathBuf> {
    let course = Course {
        size: args.time_size.first().copied().unwrap_or([1920, 1080]),
        frames: args.frames.unwrap_or(FRAMES),
        error_size: args.error_size.unwrap_or([256; 2]),
        map: None,
    };
    run_course(args, &course, common)
}

fn run_course(args: &BenchArgs, course: &Course, common: &Common) -> Result<PathBuf> {
    let wanted = subjects(&args.scenes)?;
    let gpu = super::fixture::open_gpu(common)?;
    std::fs::create_dir_all(&args.output).with_context(|| format!("cannot make {}", args.output.display()))?;
    let file = args.output.join("light_culling.json");
    let mut results = open(&file, machine::header(&gpu, course.in_words())?, args.fresh)?;
    let bar = progress::bar(wanted.len() as u64 * measure::STEPS, "bench --light-culling");
    for subject in wanted {
        if results.subjects.iter().any(|known| known.name == subject.name) {
            bar.inc(measure::STEPS);
            continue;
        }
        results.subjects.push(measure::subject(&gpu, subject, course, &args.output, common, &bar)?);
        results::write_whole(&file, serde_json::to_string_pretty(&results)?.as_bytes())?;
    }
    bar.finish_and_clear();
    let report = args.output.join("light_culling.md");
    results::write_whole(&report, report::of(&results).as_bytes())?;
    Ok(report)
}

/// The subjects of scenes by name, all if none is named.
fn subjects(names: &[String]) -> Result<Vec<&'static Subject>> {
    let is_of = |subject: &Subject, name: &String| subject.scene == name || subject.stand_in == Some(name);
    if let Some(name) = names.iter().find(|name| !SUBJECTS.iter().any(|subject| is_of(subject, name))) {
        let mut known: Vec<&str> = SUBJECTS.iter().map(|subject| subject.scene).collect();
        known.dedup();
        bail!("`{name}` is none of the scenes of --light-culling: these are {}", known.join(", "));
    }
    let is_wanted = |subject: &&Subject| names.is_empty() || names.iter().any(|name| is_of(subject, name));
    Ok(SUBJECTS.iter().filter(is_wanted).collect())
}

impl Course {
    fn in_words(&self) -> String {
        let size = super::report::markdown::size;
        format!(
            "{} frames at {}, everything recomputed; errors at {}",
            self.frames,
            size(self.size),
            size(self.error_size)
        )
    }
}

/// The results of a folder, or new ones.
fn open(file: &Path, header: Header, fresh: bool) -> Result<Results> {
    let old = results::take_up(file, &header, fresh, |old: &mut Results| &mut old.header)?;
    Ok(old.unwrap_or_else(|| Results { header, subjects: Vec::new() }))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::cli::BenchLine;
    use clap::Parser;

    /// Figure 10 alone, with few lights, so that it takes seconds.
    #[test]
    fn a_tiny_run_from_end_to_end_and_taken_up_again() {
        let dir = tempfile::tempdir().unwrap();
        let out = dir.path().join("out");
        let line = ["bench", "glossy_ring", "--light-culling", "-o", out.to_str().unwrap()];
        let args = BenchLine::try_parse_from(line).unwrap().args;
        // Several tiles: one is of 128 × 128 pixels, and culls nothing where it is the whole image.
        let course = Course { size: [512, 384], frames: 1, error_size: [32, 24], map: Some(32) };
        let read = || -> Results {
            serde_json::from_str(&std::fs::read_to_string(out.join("light_culling.json")).unwrap()).unwrap()
        };
        let report = std::fs::read_to_string(run_course(&args, &course, &Common::default()).unwrap()).unwrap();
        let first = read();
        let names: Vec<&str> = first.subjects.iter().map(|subject| subject.name.as_str()).collect();
        assert_eq!(names, ["roughness 0.4", "roughness 0.2", "roughness 0.1", "roughness 0.05"]);
        for subject in &first.subjects {
            let [centred, enclosing, ellipsoid] = [0, 1, 2].map(|index: usize| subject.bounds[index].glossy);
            assert!(ellipsoid.accepted > 0.0 && centred.accepted == ellipsoid.accepted, "{subject:?}");
            assert!(
                ellipsoid.in_vain() < enclosing.in_vain() && enclosing.in_vain() <= centred.in_vain(),
                "{subject:?}"
            );
            assert!(subject.bounds[2].diffuse.accepted > 0.0 && subject.lights == 1024, "{subject:?}");
            assert!(subject.error.nrmse > 0.0 && subject.error.nrmse < 10.0, "{subject:?}");
            assert!(subject.pictures.iter().all(|file| out.join(file).is_file()), "{subject:?}");
        }
        for words in ["## Table 1", "## Table 2", "## Figure 9", "## Figure 10", "`roughness_0.05`", "## What deviates"]
        {
            assert!(report.contains(words), "no `{words}` in\n{report}");
        }

        // As if interrupted: what is missing is measured, and only that.
        let mut less = first;
        less.subjects.pop();
        less.subjects[0].error.rmse = -1.0;
        std::fs::write(out.join("light_culling.json"), serde_json::to_string(&less).unwrap()).unwrap();
        run_course(&args, &course, &Common::default()).unwrap();
        let again = read();
        assert_eq!((again.subjects.len(), again.subjects[0].error.rmse), (4, -1.0));
    }

    #[test]
    fn it_is_measured_alone() {
        for other in ["--thesis", "--host", "--quick", "--aa=2", "--cliffs"] {
            assert!(BenchLine::try_parse_from(["bench", "-o", "x", "--light-culling", other]).is_err(), "{other}");
        }
    }

    #[test]
    fn scenes_are_chosen_by_their_names_or_their_stand_ins() {
        let of = |names: &[&str]| {
            let names: Vec<String> = names.iter().map(|&name| name.to_owned()).collect();
            subjects(&names).map(|found| found.iter().map(|subject| subject.name).collect::<Vec<_>>())
        };
        assert_eq!(of(&[]).unwrap().len(), SUBJECTS.len());
        assert_eq!(of(&["cathedral"]).unwrap(), ["Sibenik"]);
        assert_eq!(of(&["glossy_ring", "sponza"]).unwrap().len(), 5);
        let error = of(&["cornell"]).unwrap_err().to_string();
        assert!(error.contains("`cornell`") && error.contains("night_court, sibenik, sponza, glossy_ring"), "{error}");
    }
}
