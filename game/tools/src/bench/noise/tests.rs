//! Tests of a whole run on the device.

#![allow(clippy::unwrap_used)]

use super::figures::Results;
use crate::bench::run;
use crate::cli::{BenchArgs, BenchLine};
use clap::Parser;
use lightwell_runtime::cli::Common;
use std::path::Path;

fn args(folder: &Path) -> BenchArgs {
    let (output, cache) = (folder.join("out"), folder.join("cache"));
    let line = ["bench", "cornell", "--noise", "-o", output.to_str().unwrap(), "--cache", cache.to_str().unwrap()];
    let small = ["--quick", "--size", "32x32", "--frames", "4", "--aa", "8", "--reference-spp", "16"];
    BenchLine::try_parse_from(line.iter().chain(&small)).unwrap().args
}

#[test]
fn a_tiny_run_from_end_to_end_and_taken_up_again() {
    let dir = tempfile::tempdir().unwrap();
    let report = std::fs::read_to_string(run(&args(dir.path()), &Common::default()).unwrap()).unwrap();
    for words in ["`High`", "at rest", "as it plays", "`Spot light` switched on", "moved by its width", "turned by 20°"]
    {
        assert!(report.contains(words), "no {words} in\n{report}");
    }
    let file = dir.path().join("out/noise.json");
    let written = std::fs::read_to_string(&file).unwrap();
    let results: Results = serde_json::from_str(&written).unwrap();
    let scene = &results.scenes[0];
    let frames_of =
        |what: &str| scene.rows.iter().filter(|row| row.what.contains(what)).map(|row| row.frame).collect::<Vec<_>>();
    assert_eq!(frames_of("at rest"), [1, 2, 4]);
    assert_eq!(frames_of("as it plays"), [17]);
    assert_eq!(frames_of("camera turned"), [1, 3, 8]);
    assert_eq!(frames_of("one image").len(), 4);
    for row in &scene.rows {
        for layer in [&row.indirect, &row.total] {
            let part = layer.elsewhere.unwrap();
            assert!(part.nrmse.is_finite() && (0.0..1.0).contains(&layer.flip), "{row:?}");
            // Grain and blotches make up the error, but for what they have in common.
            assert!(part.grain <= 1.2 * part.nrmse + 1e-3 && part.blotches <= 1.2 * part.nrmse + 1e-3, "{row:?}");
        }
    }
    assert_eq!(scene.jumps.len(), 3);
    assert!(scene.jumps.iter().all(|row| row.jumps.blocks > 0), "{:?}", scene.jumps);
    assert!(!scene.pictures.is_empty());
    for picture in &scene.pictures {
        assert!(dir.path().join("out").join(picture).is_file(), "{picture}");
    }
    run(&args(dir.path()), &Common::default()).unwrap();
    let seconds = |text: &str| serde_json::from_str::<Results>(text).unwrap().scenes[0].seconds;
    let again = std::fs::read_to_string(&file).unwrap();
    assert_eq!(seconds(&again), seconds(&written), "what is there is not measured again");
}
