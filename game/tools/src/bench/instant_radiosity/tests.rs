//! Small runs on the device.

#![allow(clippy::unwrap_used)]

use super::measure::{Stage, Step};
use super::{Results, SCENES, formulas};
use crate::bench::{fixture, run};
use crate::cli::{BenchArgs, BenchLine};
use clap::Parser;
use lightwell::world::{
    Accumulation, InstantRadiosity, ParticleBounce, ParticleCasts, ParticleSequence, Schedule, ShadowLookup,
    VirtualShading, VirtualVisibility,
};
use lightwell_runtime::cli::Common;
use std::path::Path;

fn args(folder: &Path, more: &[&str]) -> BenchArgs {
    let (output, cache) = (folder.join("out"), folder.join("cache"));
    let base = ["bench", "--instant-radiosity", "-o", output.to_str().unwrap(), "--cache", cache.to_str().unwrap()];
    let small = ["--error-size", "16x16", "--aa", "1", "--reference-spp", "8"];
    BenchLine::try_parse_from(base.iter().chain(&small).chain(more)).unwrap().args
}

fn results(folder: &Path) -> Results {
    serde_json::from_str(&std::fs::read_to_string(folder.join("out/instant_radiosity.json")).unwrap()).unwrap()
}

/// The preset of every scene that is measured without being named is all that the report has.
#[test]
fn presets_follow_the_report() {
    let gpu = fixture::open_gpu(&Common::default()).unwrap();
    for name in SCENES {
        let session = Stage::open(&gpu, name, &Common::default()).unwrap().session(true, 10, &[]).unwrap();
        let found = session.scene().vpl.clone().unwrap();
        let expected = InstantRadiosity {
            particles: 10,
            schedule: Schedule::Report,
            sequence: ParticleSequence::Random,
            casts: ParticleCasts::BruteForce,
            bounce: ParticleBounce::Mirror,
            shading: VirtualShading::AsPublished,
            visibility: VirtualVisibility::None,
            accumulation: Accumulation::ByTheLetter,
            view_driven: false,
            shadow_lookup: ShadowLookup::AsPublished,
            ..found.clone()
        };
        assert_eq!(found, expected, "{name}");
        assert!(found.shadow_bias > 0.0 && found.shadow_slope_bias > 0.0 && found.shadow_samples > 1, "{name}");
        assert!(found.shadow_bias < 0.1 && found.shadow_offset < 0.1, "{name}: metres, not texels");
    }
}

#[test]
fn a_tiny_run_from_end_to_end_and_taken_up_again() {
    let dir = tempfile::tempdir().unwrap();
    let args = args(dir.path(), &["vpl_report"]);
    let report = std::fs::read_to_string(run(&args, &Common::default()).unwrap()).unwrap();
    let first = results(dir.path());
    let scene = &first.scenes[0];
    for row in &scene.casts {
        // The room is closed: no particle is lost, and the formula holds to the last test.
        let (lights, tests) = (formulas::lights(row.particles, 0.5), formulas::tests(row.particles, 0.5, 9));
        assert_eq!((row.objects, row.reflectance, row.lights, row.rays), (9, 0.5, lights, lights), "{row:?}");
        assert_eq!((row.brute_force, row.bounds), (tests, [tests, 0]), "{row:?}");
    }
    for row in &scene.draws {
        assert_eq!((row.lights, row.objects), (formulas::lights(row.particles, 0.5), 9), "{row:?}");
        // Each light draws what the camera sees once more.
        assert_eq!(row.virtual_lights, row.lights * row.camera, "{row:?}");
        assert!(row.shadows <= 6 * row.objects && row.camera <= row.objects, "{row:?}");
        assert_eq!(row.batched, row.shadows + row.camera, "{row:?}");
    }
    // Ten particles leave eighteen lights, six a row, behind the picture of the whole.
    assert_eq!(scene.pictures.len(), 1 + 3);
    let files = scene.pictures.iter().map(|picture| picture.file.clone());
    for file in files.chain(["casts", "errors"].map(|what| format!("plots/vpl_report_{what}.png"))) {
        assert!(dir.path().join("out").join(&file).is_file() && report.contains(&file), "{file}");
    }
    assert!(scene.errors.iter().all(|row| row.nrmse.is_finite() && row.scaled.is_finite()));
    let error = |what: &str, particles| {
        scene.errors.iter().find(|row| row.what.contains(what) && row.particles == particles).unwrap().nrmse
    };
    assert!(error("our defaults", 1024) < 0.5 * error("our defaults", 4), "more particles, less error");
    assert!(error("as the report", 1024) > 2.0 * error("our defaults", 1024), "its formula is no light transport");

    // As if interrupted: what is missing is taken again, and only that.
    let mut less = results(dir.path());
    let lost = less.scenes[0].errors.pop().unwrap();
    less.scenes[0].casts[0].rays = 12_345;
    let file = dir.path().join("out/instant_radiosity.json");
    std::fs::write(&file, serde_json::to_string(&less).unwrap()).unwrap();
    run(&args, &Common::default()).unwrap();
    let again = results(dir.path());
    assert_eq!((again.scenes[0].errors.last(), again.scenes[0].casts[0].rays), (Some(&lost), 12_345));
    assert_eq!(again.scenes[0].errors.len(), scene.errors.len());
    std::fs::write(&file, "{}").unwrap();
    let error = format!("{:#}", run(&args, &Common::default()).unwrap_err());
    assert!(error.contains("--fresh"), "{error}");
}

#[test]
fn scenes_without_the_preset_are_refused() {
    let dir = tempfile::tempdir().unwrap();
    let error = format!("{:#}", run(&args(dir.path(), &["gallery"]), &Common::default()).unwrap_err());
    assert!(error.contains("`gallery` has no preset `report`"), "{error}");
    assert!(!dir.path().join("out").exists(), "nothing is left of what cannot be measured");
}

#[test]
fn steps_have_names_of_their_own() {
    let mut names: Vec<String> = Step::all().iter().map(Step::to_string).collect();
    names.sort();
    names.dedup();
    assert_eq!(names.len(), Step::all().len());
}
