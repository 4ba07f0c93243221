//! `bench --thesis`: tables 7.1, 7.3 and 7.4 and figures 7.2 to 7.10 of the thesis that the diffusion follows (Petr
//! Šefčík 2016), with our figures beside the printed ones.
//!
//! ```text
//! published (the printed figures) ─┐
//! measure (a scene) ─ thesis.json ─┴─ report ─ thesis.md, pictures
//! ```

mod measure;
mod published;
mod report;

use super::machine;
use super::results::{self, Header};
use crate::cli::BenchArgs;
use anyhow::{Context, Result};
use lightwell_runtime::cli::Common;
use lightwell_runtime::progress;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Frames that the thesis averages over.
const FRAMES: u32 = 30;
/// Samples a pixel of the references, if not said.
const SAMPLES: u32 = 256;

/// What is measured.
#[derive(Clone, Debug)]
struct Course {
    sizes: Vec<[u32; 2]>,
    frames: u32,
    error_size: [u32; 2],
    images: u32,
    samples: u32,
    references: PathBuf,
}

/// All results in a folder.
#[derive(Debug, Default, Serialize, Deserialize)]
struct Results {
    header: Header,
    scenes: Vec<SceneResults>,
}

/// The figures of a scene.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
struct SceneResults {
    /// Its name in the thesis.
    name: String,
    /// Our scene, which may be a stand-in.
    scene: String,
    triangles: u64,
    /// Triangles drawn into reflective shadow maps.
    rsm_triangles: u64,
    injections: u64,
    cell_steps: u64,
    merges: u64,
    times: Vec<Times>,
    errors: Vec<ErrorRow>,
    /// Figures of the thesis by their numbers, and the files of ours.
    pictures: BTreeMap<String, Vec<String>>,
}

/// Medians of the stages at an image size [ms].
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Times {
    size: [u32; 2],
    frames: usize,
    stages: BTreeMap<String, f64>,
}

/// Indirect light of settings against the path tracer, which ends paths at the second scattering as the thesis has it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
struct ErrorRow {
    what: String,
    nrmse: f64,
    bias: f64,
    /// The reference's own noise, relative to its mean.
    noise: f64,
}

/// Measures what is missing in the folder, scene by scene, and writes the report; returns its path.
///
/// # Errors
/// If a scene cannot be loaded or drawn, or a file not be written.
pub(super) fn run(args: &BenchArgs, common: &Common) -> Result<PathBuf> {
    let course = Course {
        sizes: if args.time_size.is_empty() { vec![[512; 2], [1024; 2]] } else { args.time_size.clone() },
        frames: args.frames.unwrap_or(FRAMES),
        error_size: args.error_size.unwrap_or([256; 2]),
        images: args.aa.unwrap_or(4),
        samples: args.reference_spp.unwrap_or(SAMPLES),
        references: args.cache.clone(),
    };
    let gpu = super::fixture::open_gpu(common)?;
    std::fs::create_dir_all(&args.output).with_context(|| format!("cannot make {}", args.output.display()))?;
    let file = args.output.join("thesis.json");
    let mut results = open(&file, machine::header(&gpu, course.in_words())?, args.fresh)?;
    let bar = progress::bar(published::SCENES.len() as u64, "bench --thesis");
    for paper in &published::SCENES {
        let is_wanted = args.scenes.is_empty() || args.scenes.iter().any(|name| name == paper.scene);
        let is_done = results.scenes.iter().any(|scene| scene.name == paper.name);
        if is_wanted && !is_done {
            results.scenes.push(measure::scene(&gpu, paper, &course, &args.output, common)?);
            results::write_whole(&file, serde_json::to_string_pretty(&results)?.as_bytes())?;
        }
        bar.inc(1);
    }
    bar.finish_and_clear();
    let report = args.output.join("thesis.md");
    results::write_whole(&report, report::of(&results).as_bytes())?;
    Ok(report)
}

impl Course {
    fn in_words(&self) -> String {
        let sizes: Vec<String> = self.sizes.iter().map(|&size| super::report::markdown::size(size)).collect();
        format!(
            "{} frames at {}, everything recomputed; errors at {}, {} images averaged, references of {} samples a pixel",
            self.frames,
            sizes.join(" and "),
            super::report::markdown::size(self.error_size),
            self.images,
            self.samples
        )
    }
}

/// The results of a folder, or new ones.
fn open(file: &Path, header: Header, fresh: bool) -> Result<Results> {
    let old = results::take_up(file, &header, fresh, |old: &mut Results| &mut old.header)?;
    Ok(old.unwrap_or_else(|| Results { header, scenes: Vec::new() }))
}
