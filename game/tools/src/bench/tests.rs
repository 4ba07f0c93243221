//! Tests of whole runs on the device.

#![allow(clippy::unwrap_used)]

use super::fixture::{self, Fixture};
use super::reference::{References, Wanted};
use super::results::{Mode, Results};
use super::run;
use super::stage::stage_of;
use super::variant::{self, Variant};
use crate::cli::{BenchArgs, BenchLine};
use clap::Parser;
use lightwell::graph::PassState;
use lightwell::measure::read_image;
use lightwell::scene::SceneView;
use lightwell_runtime::cli::Common;
use std::path::Path;

fn args(folder: &Path, more: &[&str]) -> BenchArgs {
    let (output, cache) = (folder.join("out"), folder.join("cache"));
    let base = ["bench", "cornell", "-o", output.to_str().unwrap(), "--cache", cache.to_str().unwrap()];
    let small =
        ["--time-size", "32x32", "--error-size", "32x32", "--frames", "2", "--aa", "2", "--reference-spp", "16"];
    BenchLine::try_parse_from(base.iter().chain(&small).chain(more)).unwrap().args
}

fn results(folder: &Path) -> Results {
    serde_json::from_str(&std::fs::read_to_string(folder.join("out/results.json")).unwrap()).unwrap()
}

#[test]
fn a_tiny_run_from_end_to_end_and_taken_up_again() {
    let dir = tempfile::tempdir().unwrap();
    let more = [
        "--times",
        "0.5",
        "--spp",
        "1,4",
        "--flicker",
        "3",
        "--throughput",
        "--sweep",
        "steps",
        "--method",
        "clpv,reference",
    ];
    let args = args(dir.path(), &more);
    let report = std::fs::read_to_string(run(&args, &Common::default()).unwrap()).unwrap();
    let first = results(dir.path());
    assert_eq!((first.scenes[0].triangles, first.scenes[0].cells), (84, Some(448)));
    let clpv = first.timings.iter().find(|t| t.variant == "clpv" && t.mode == Mode::Full).unwrap();
    assert_eq!(clpv.counts["IL"]["injections"] + clpv.counts["IB"]["injections"], 32_768);
    assert_eq!((clpv.counts["PRP"]["cells"], clpv.merges), (7_168, Some(0)));
    assert!(clpv.unknown_passes.is_empty() && clpv.allocated_bytes > 0, "{clpv:?}");
    let shifted = first.timings.iter().find(|t| t.variant == "clpv" && t.mode == Mode::Shifted).unwrap();
    assert!(shifted.stages.contains_key("GB") && !shifted.stages.contains_key("PRP"), "{shifted:?}");
    for word in ["clpv", "path tracing 4 spp", "32,768", "## Flicker", "Sweeps", "## Path tracer"] {
        assert!(report.contains(word), "no `{word}` in\n{report}");
    }
    for error in &first.errors {
        assert!(
            error.direct.nrmse.is_finite() && error.pictures.iter().all(|p| dir.path().join("out").join(p).is_file())
        );
    }
    let traced = |spp: u32| {
        let name = format!("path tracing {spp} spp");
        first.errors.iter().find(|error| error.variant == name).unwrap().indirect
    };
    assert!(traced(4).nrmse < traced(1).nrmse, "more samples, less noise");
    assert!(dir.path().join("out/plots/cornell_sweep_steps_row.png").is_file());

    // As if interrupted: what is missing is taken again, and only that.
    let mut less = first.clone();
    let lost = less.errors.remove(0);
    less.errors[0].total.rmse = -1.0;
    std::fs::write(dir.path().join("out/results.json"), serde_json::to_string(&less).unwrap()).unwrap();
    run(&args, &Common::default()).unwrap();
    let again = results(dir.path());
    assert_eq!(again.timings, first.timings);
    assert_eq!(again.flicker, first.flicker);
    assert_eq!(again.errors.len(), first.errors.len());
    assert_eq!(again.errors[0].total.rmse, -1.0, "what is there is not measured again");
    assert!(again.errors.contains(&lost), "the same bits from the cached reference");
}

#[test]
fn every_pass_of_a_frame_has_a_stage() {
    let mut fixture =
        Fixture::open(fixture::open_gpu(&Common::default()).unwrap(), "cornell", None, &Common::default()).unwrap();
    // The qualities of the sweep differ in numbers, not in passes.
    let methods = variant::methods()
        .into_iter()
        .filter(|(_, preset)| !["medium", "high", "ultra"].iter().any(|q| preset.name.contains(q)));
    let variants: Vec<Variant> = methods.map(Variant::of).collect();
    fixture.add(&variants).unwrap();
    for index in 0..variants.len() {
        let (variant, session) = fixture.runner(index);
        let name = variant.name.clone();
        let view = SceneView { camera: session.camera().unwrap(), size: [32; 2], jitter: [0.0; 2] };
        let settings = lightwell::render::RenderSettings {
            gi: match variant.is_traced() {
                true => lightwell::render::GiMethod::REFERENCE,
                false => session.render_settings(true).gi,
            },
            ..session.render_settings(true)
        };
        let report = session.render(&view, &settings).unwrap();
        let ran: Vec<&str> =
            report.passes.iter().filter(|p| p.state == PassState::Ran).map(|p| p.name.as_str()).collect();
        assert!(!ran.is_empty());
        ran.iter().for_each(|pass| assert!(stage_of(pass).is_some(), "{name}: no stage for `{pass}`"));
    }
}

#[test]
fn references_are_found_by_what_they_are_of() {
    let dir = tempfile::tempdir().unwrap();
    let stored = dir.path().join("stored");
    std::fs::create_dir(&stored).unwrap();
    let mut fixture =
        Fixture::open(fixture::open_gpu(&Common::default()).unwrap(), "cornell", None, &Common::default()).unwrap();
    let wanted = |time| Wanted { scene: "cornell", time, size: [16; 2], bounces: None, samples: 8 };
    let references = References { cache: dir.path().join("cache"), stored: Some(stored.clone()), bless: true };
    let mut get = |references: &References, time: f64, name_as: f64| {
        fixture.set_seconds(time);
        let mut traced = false;
        let found = references.get(fixture.tracer(), &wanted(name_as), &mut |_| traced = true).unwrap();
        (found, traced)
    };
    let (first, traced) = get(&references, 0.0, 0.0);
    assert!(traced && first.note.is_none());
    assert!(!get(&references, 0.0, 0.0).1, "found in the cache");

    // What is stored is found without a cache, in half precision.
    let fresh = References { cache: dir.path().join("other"), bless: false, ..references.clone() };
    let (found, traced) = get(&fresh, 0.0, 0.0);
    assert!(!traced && found.note.is_none());
    assert!((found.estimate.total().mean() / first.estimate.total().mean() - 1.0).abs() < 1e-3);

    // The light has moved: another key, so that what is stored under this name is stale.
    let (moved, traced) = get(&fresh, 1.5, 0.0);
    assert!(traced && moved.note.unwrap().contains("--bless"));
    assert_ne!(moved.estimate.total(), first.estimate.total());
    // And back: nothing was overwritten.
    assert!(!get(&references, 0.0, 0.0).1);
}

#[test]
fn keys_follow_what_a_measurement_depends_on() {
    let mut fixture =
        Fixture::open(fixture::open_gpu(&Common::default()).unwrap(), "cornell", None, &Common::default()).unwrap();
    let long = Variant::parse("long: clpv.steps=32").unwrap();
    let dim = Variant::parse("dim: Spot light.light.intensity=1").unwrap();
    let renamed = Variant { name: "renamed".into(), ..long.clone() };
    fixture.add(&[Variant::of(variant::methods()[1]), long, dim, renamed]).unwrap();
    let mut key = |index, times: &[f64], what: &str| fixture.key(index, times, what).unwrap();
    let base = key(0, &[0.0], "x");
    assert_eq!(key(0, &[0.0], "x"), base);
    assert_eq!(key(1, &[0.0], "x"), key(3, &[0.0], "x"));
    for other in [key(1, &[0.0], "x"), key(2, &[0.0], "x"), key(0, &[1.0], "x"), key(0, &[0.0], "y")] {
        assert_ne!(other, base);
    }
}

#[test]
fn pictures_hold_three_images() {
    let dir = tempfile::tempdir().unwrap();
    let more = ["--times", "0", "--method", "none", "--bounces", "inf,1"];
    run(&args(dir.path(), &more), &Common::default()).unwrap();
    let found = results(dir.path());
    assert_eq!(found.errors.iter().map(|error| error.bounces).collect::<Vec<_>>(), [None, Some(1)]);
    assert!(found.errors[1].indirect.mean < found.errors[0].indirect.mean, "one bounce is darker than all");
    let picture = read_image(&dir.path().join("out").join(&found.errors[0].pictures[0])).unwrap();
    assert!(picture.size()[0] > 3 * 256);
    assert!((found.errors[0].indirect.bias + 1.0).abs() < 1e-9, "no indirect light at all");
}

#[test]
fn growth_is_measured_once_and_a_refusal_is_a_result() {
    let dir = tempfile::tempdir().unwrap();
    let output = dir.path().join("out");
    let line = ["bench", "-o", output.to_str().unwrap(), "--growth", "all", "--quick", "--frames", "1"];
    let args = BenchLine::try_parse_from(line).unwrap().args;
    let report = std::fs::read_to_string(run(&args, &Common::default()).unwrap()).unwrap();
    let first = results(dir.path());
    assert!(first.scenes.is_empty() && first.growth.len() == 10 && first.pairs.len() == 2, "{first:?}");
    for curve in &first.growth {
        assert_eq!(curve.points.len(), 2);
        for point in &curve.points {
            assert!(point.refused.is_none() && point.frame.median > 0.0 && point.draws > 0, "{curve:?}");
            assert!(point.still.median < point.frame.median, "{curve:?}");
        }
        assert!(output.join(format!("plots/growth_{}_{}.png", curve.axis, curve.series)).is_file());
    }
    let objects = &first.growth[0].points;
    assert!(objects[1].triangles >= objects[0].triangles + 12 * 90, "{objects:?}");
    let meshes = first.pairs.iter().find(|pair| pair.name == "meshes").unwrap();
    assert!(meshes.draws[0] >= meshes.draws[1], "{meshes:?}");
    assert!(report.contains("### objects, direct") && report.contains("1200 boxes"), "{report}");
    run(&args, &Common::default()).unwrap();
    assert_eq!(results(dir.path()).growth, first.growth);
}
