//! `bench --instant-radiosity`: the figures of the report that instant radiosity follows ("Virtual Point Lights",
//! E. Franchi and L. Ferrante), measured in scenes with a preset `report`, beside what it predicts.
//!
//! ```text
//! formulas (what the report predicts) ─┐
//! measure (a scene, step by step) ─ instant_radiosity.json ─┴─ report ─ instant_radiosity.md, plots, pictures
//! ```

mod formulas;
mod measure;
mod report;
#[cfg(test)]
mod tests;

use super::machine;
use super::results::{self, Header};
use crate::cli::BenchArgs;
use anyhow::{Context, Result};
use lightwell_runtime::cli::Common;
use lightwell_runtime::progress;
use measure::{Stage, Step};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Scenes, unless others are asked for.
const SCENES: [&str; 2] = ["vpl_report", "cornell"];
/// Samples a pixel of the references, if not said.
const SAMPLES: u32 = 1024;
/// Size of the images, if not said [pixels].
const SIZE: [u32; 2] = [128; 2];
/// Images averaged, if not said.
const IMAGES: u32 = 4;

/// How errors and pictures are taken.
#[derive(Clone, Debug)]
struct Course {
    size: [u32; 2],
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
    name: String,
    casts: Vec<CastRow>,
    draws: Vec<DrawRow>,
    errors: Vec<ErrorRow>,
    pictures: Vec<Picture>,
}

/// Intersection tests of a simulation.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
struct CastRow {
    /// N.
    particles: u32,
    /// B: objects that block light.
    objects: u64,
    /// ρ.
    reflectance: f64,
    /// Virtual lights that were left.
    lights: u64,
    /// Rays cast.
    rays: u64,
    /// Ray-object tests, object by object.
    brute_force: u64,
    /// Tests of boxes and triangles of the hierarchy.
    hierarchy: u64,
    /// Tests of the boxes around objects, and of triangles of those that rays start within.
    bounds: [u64; 2],
}

/// Draws of a frame.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
struct DrawRow {
    /// N.
    particles: u32,
    /// M: virtual lights that are summed.
    lights: u64,
    /// B: objects.
    objects: u64,
    /// Draws of shadow maps.
    shadows: u64,
    /// Draws of what the camera sees.
    camera: u64,
    /// Draws of virtual lights, each by itself.
    virtual_lights: u64,
    /// All draws where all virtual lights are summed in one pass.
    batched: u64,
}

/// Indirect light of settings against the path tracer.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
struct ErrorRow {
    what: String,
    /// N.
    particles: u32,
    /// M.
    lights: u64,
    nrmse: f64,
    bias: f64,
    /// The error after the image is scaled to the mean of the reference: of light by formulas that are no light
    /// transport only its distribution can be compared.
    scaled: f64,
    /// The reference's own noise, relative to its mean.
    noise: f64,
    /// How it was taken: size, images and samples.
    course: String,
}

/// A picture and what it shows.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Picture {
    what: String,
    file: String,
    /// How it was taken.
    course: String,
}

/// Takes the measurements that are missing in the folder and writes the report; returns its path.
///
/// # Errors
/// If a scene cannot be loaded or drawn or has no preset `report`, or a file not be written.
pub(super) fn run(args: &BenchArgs, common: &Common) -> Result<PathBuf> {
    let course = Course {
        size: args.error_size.unwrap_or(SIZE),
        images: args.aa.unwrap_or(IMAGES),
        samples: args.reference_spp.unwrap_or(SAMPLES),
        references: args.cache.clone(),
    };
    let scenes: Vec<&str> = match args.scenes.is_empty() {
        true => SCENES.to_vec(),
        false => args.scenes.iter().map(String::as_str).collect(),
    };
    let gpu = super::fixture::open_gpu(common)?;
    let stages = scenes.iter().map(|scene| Stage::open(&gpu, scene, common)).collect::<Result<Vec<_>>>()?;
    std::fs::create_dir_all(&args.output).with_context(|| format!("cannot make {}", args.output.display()))?;
    let file = args.output.join("instant_radiosity.json");
    let mut results = open(&file, machine::header(&gpu, course.in_words())?, args.fresh)?;
    let steps = Step::all();
    let bar = progress::bar((stages.len() * steps.len()) as u64, "bench --instant-radiosity");
    for stage in &stages {
        for step in &steps {
            let scene = results.scene(&stage.name());
            if !step.is_done(scene, &course, &args.output) {
                bar.set_message(format!("{}: {step}", stage.name()));
                let measured = step.take(stage, &course, &args.output, scene);
                measured.with_context(|| format!("scene `{}`, {step}", stage.name()))?;
                results::write_whole(&file, serde_json::to_string_pretty(&results)?.as_bytes())?;
            }
            bar.inc(1);
        }
    }
    bar.finish_and_clear();
    report::plots(&results, &args.output)?;
    let report = args.output.join("instant_radiosity.md");
    results::write_whole(&report, report::of(&results).as_bytes())?;
    Ok(report)
}

impl Results {
    /// The results of a scene, empty at first.
    fn scene(&mut self, name: &str) -> &mut SceneResults {
        let index = self.scenes.iter().position(|scene| scene.name == name).unwrap_or_else(|| {
            self.scenes.push(SceneResults { name: name.to_owned(), ..Default::default() });
            self.scenes.len() - 1
        });
        &mut self.scenes[index]
    }
}

impl Course {
    fn in_words(&self) -> String {
        format!(
            "errors and pictures at {}, {} images averaged, references of {} samples a pixel",
            super::report::markdown::size(self.size),
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
