//! Tests of the measures, and of a whole run on the device.

#![allow(clippy::unwrap_used)]

use super::cases::CASES;
use super::figures::Results;
use super::measure::{coarse_error, left_of_change, near_from};
use crate::bench::run;
use crate::cli::{BenchArgs, BenchLine};
use clap::Parser;
use lightwell::measure::Image;
use lightwell_runtime::cli::Common;
use std::path::Path;

fn args(folder: &Path) -> BenchArgs {
    let line = ["bench", "--response", "-o", folder.to_str().unwrap()];
    let small = ["--quick", "--size", "32x32", "--aa", "16"];
    BenchLine::try_parse_from(line.iter().chain(&small)).unwrap().args
}

#[test]
fn what_is_left_of_a_change_is_its_share() {
    let image = |value: f32| Image::filled(8, 8, [value, 1.0, 2.0 * value]);
    let (before, after) = (image(5.0), image(1.0));
    for (value, left) in [(5.0, 1.0), (1.0, 0.0), (2.0, 0.25), (0.0, -0.25)] {
        assert!((left_of_change(&image(value), &before, &after).unwrap() - left).abs() < 1e-6);
    }
    assert_eq!(left_of_change(&after, &after, &after), None);
}

#[test]
fn coarse_errors_leave_grain_out() {
    let truth = Image::filled(64, 64, [2.0; 3]);
    let board = (0..64 * 64).map(|index| [if (index + index / 64) % 2 == 0 { 3.0 } else { 1.0 }; 3]).collect();
    assert!(coarse_error(&Image::from_pixels(64, 64, board).unwrap(), &truth) < 0.01);
    assert!((coarse_error(&Image::filled(64, 64, [2.2; 3]), &truth) - 0.1).abs() < 1e-6);
}

#[test]
fn frames_are_near_from_when_on_they_stay_near() {
    assert_eq!(near_from(&[0.5, 0.04, 0.2, 0.05, 0.01], 0.05), Some(4));
    assert_eq!(near_from(&[0.01, 0.02], 0.05), Some(1));
    assert_eq!(near_from(&[0.01, 0.2], 0.05), None);
    assert_eq!(near_from(&[], 0.05), None);
}

#[test]
fn a_tiny_run_from_end_to_end_and_taken_up_again() {
    let dir = tempfile::tempdir().unwrap();
    let report = std::fs::read_to_string(run(&args(dir.path()), &Common::default()).unwrap()).unwrap();
    for words in ["stale shadow after 96 frames", "same pose twice", "sealed box", "Within 5 %", "fast flight"] {
        assert!(report.contains(words), "no {words} in\n{report}");
    }
    let read = || -> Results {
        serde_json::from_str(&std::fs::read_to_string(dir.path().join("response.json")).unwrap()).unwrap()
    };
    let results = read();
    assert_eq!(results.cases.len(), CASES.len());
    for (case, figures) in CASES.iter().zip(&results.cases) {
        assert_eq!((figures.name.as_str(), figures.residue.len(), figures.frames), (case.name, 4, 32), "{figures:?}");
        assert!(figures.residue.iter().all(|value| value.is_finite()), "{figures:?}");
        assert_eq!(figures.left.is_empty(), case.moves_camera, "{figures:?}");
        assert!(dir.path().join(&figures.picture).is_file(), "{}", figures.picture);
    }
    // Half a second after a light is switched on most of it is there, and the first frame has seen it at all.
    let on = results.cases.iter().find(|case| case.name == "light switched on").unwrap();
    assert!(on.left[0] < 0.6 && on.left[3].abs() < 0.1, "{on:?}");
    // A single image depends on nothing before it, and nothing shines into a closed box.
    assert_eq!(results.same_view.as_ref().unwrap().single, [0.0; 2]);
    assert_eq!(results.sealed.as_ref().unwrap().single[0], 0.0);
    run(&args(dir.path()), &Common::default()).unwrap();
    let again = read();
    assert_eq!((&again.cases, &again.sealed), (&results.cases, &results.sealed));
}
