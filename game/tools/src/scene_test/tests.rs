#![allow(clippy::unwrap_used)]
use super::*;
use lightwell_runtime::cli::Common;
use std::path::Path;

/// Writes a scene test into a folder and runs it.
fn run_text(dir: &Path, text: &str) -> Report {
    let path = dir.join("a.test.ron");
    std::fs::write(&path, text).unwrap();
    let options = Options { common: Common::default(), bless: false, output: dir.join("out") };
    run(&TestCase { name: "a".into(), path }, &options, &mut None)
}

fn faults(report: &Report) -> String {
    match &report.outcome {
        Outcome::Failed(faults) => faults.join("\n"),
        other => panic!("{other:?}"),
    }
}

/// Mistakes that the file itself shows, at the place that is marked with ‸, and words of the error.
const BAD: [(&str, &str); 13] = [
    ("(scene: \"cornell\", ‸tmes: [0])", "did you mean `times`?"),
    ("(scene: \"cornell\",\n expect: (golden: (‸flipp: 1)))", "did you mean `flip`?"),
    ("(times: [0]‸)", "`scene`"),
    ("(scene: \"cornell\", size: ‸128)", "expected"),
    ("(scene: \"cornell\", times: [0, ‸-1])", "seconds"),
    ("(scene: \"cornell\", times: ‸[])", "at least one"),
    ("(scene: \"cornell\", size: (128, ‸0))", "1 to 16384"),
    ("(scene: \"cornell\", gi: ‸Clvp)", "did you mean `Clpv`?"),
    ("(scene: \"cornell\", set: [‸\"clpv.steps\"])", "PATH=VALUE"),
    ("(scene: \"cornell\", expect: (frames: [(at: [‸2])]))", "`times` has 0"),
    ("(scene: \"cornell\", expect: (frames: [(counts: {\"a\": (draws: ‸(min: 3, max: 2))})]))", "at least 3"),
    ("(scene: \"cornell\", expect: (errors: [(reference: Image(\"a.exr\"), max: ‸())]))", "nrmse"),
    ("(scene: \"cornell\", expect: (errors: [(reference: Traced(samples: ‸3), max: (bias: 1))]))", "even"),
];

#[test]
fn mistakes_are_told_with_their_place() {
    let dir = tempfile::tempdir().unwrap();
    let mut wrong = Vec::new();
    for (marked, words) in BAD {
        let (before, after) = marked.split_once('‸').unwrap();
        let what = faults(&run_text(dir.path(), &format!("{before}{after}")));
        let column = before.rsplit('\n').next().unwrap_or(before).chars().count() + 1;
        let place = format!("a.test.ron:{}:{column}:", before.lines().count().max(1));
        if !(what.contains(&place) && what.contains(words)) {
            wrong.push(format!("{marked}\n{what}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n\n"));
}

#[test]
fn no_method_is_a_method() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.test.ron");
    for (text, gi) in [
        ("gi: None", Some(lightwell::render::GiMethod::NONE)),
        ("gi: Clpv", Some(lightwell::render::GiMethod::CLPV)),
        ("", None),
    ] {
        std::fs::write(&path, format!("(scene: \"cornell\", {text})")).unwrap();
        assert_eq!(SceneTest::read(&path).unwrap().gi, gi, "{text}");
    }
}

/// A frame that all passes of the method have a part in, of which something else is expected.
#[test]
fn a_frame_that_is_not_as_expected_fails() {
    let dir = tempfile::tempdir().unwrap();
    let text = r#"(scene: "cornell", size: (16, 16), expect: (
        golden: (),
        frames: [(ran: ["gbuffer", "gbufer"], skipped: ["gbuffer"], counts: {"gbuffer": (draws: 1000)}), (frame: Again, ran: ["gbuffer"])],
        errors: [(layer: Direct, reference: Image("white.exr"), max: (nrmse: 0.01))],
    ))"#;
    let white = lightwell::measure::Image::filled(16, 16, [1e3; 3]);
    lightwell::measure::write_image(&dir.path().join("white.exr"), &white).unwrap();
    let what = faults(&run_text(dir.path(), text));
    for words in [
        "at 0 s, first frame: `gbufer` should have run, but there is no such pass; did you mean `gbuffer`?",
        "at 0 s, first frame: `gbuffer` should be skipped, but ran",
        "draws, not 1000",
        "at 0 s, second frame: `gbuffer` should have run, but was cached",
        "at 0 s: there is no golden image",
        "at 0 s: direct light against white.exr: nrmse",
    ] {
        assert!(what.contains(words), "`{words}` is not in\n{what}");
    }
    assert_eq!(what.lines().count(), 6, "{what}");
    assert!(dir.path().join("out/a_0s_golden.actual.png").is_file());
    assert!(dir.path().join("out/a_0s_direct_0.difference.png").is_file());
}

#[test]
fn a_missing_model_is_skipped_and_a_missing_scene_fails() {
    let dir = tempfile::tempdir().unwrap();
    let scene = r#"(entities: [(name: "Hall", model: (path: "hall.glb", source: "https://halls.example"))])"#;
    std::fs::write(dir.path().join("hall.scene.ron"), scene).unwrap();
    let report = run_text(dir.path(), "(scene: \"hall.scene.ron\")");
    assert!(
        matches!(&report.outcome, Outcome::Skipped(why) if why.contains("hall.glb") && why.contains("halls.example")),
        "{report:?}"
    );
    let what = faults(&run_text(dir.path(), "(scene: \"no such scene\")"));
    assert!(what.contains("`no such scene`") && what.contains("cornell"), "{what}");
    // Without a source it is no third-party model, but a mistake.
    std::fs::write(dir.path().join("hall.scene.ron"), scene.replace(", source: \"https://halls.example\"", ""))
        .unwrap();
    assert!(faults(&run_text(dir.path(), "(scene: \"hall.scene.ron\")")).contains("hall.glb"));
}

#[test]
fn many_tests_run_side_by_side_and_report_in_order() {
    let dir = tempfile::tempdir().unwrap();
    let cases: Vec<TestCase> = (0..5)
        .map(|i| {
            let path = dir.path().join(format!("{i}.test.ron"));
            let wrong = if i == 3 { "frames: [(ran: [\"no pass\"])]" } else { "deterministic: true" };
            std::fs::write(&path, format!("(scene: \"cornell\", size: (8, 8), expect: ({wrong}))")).unwrap();
            TestCase { name: i.to_string(), path }
        })
        .collect();
    let options = Options { common: Common::default(), bless: false, output: dir.path().join("out") };
    let mut done = Vec::new();
    let reports = run_all(&cases, &options, 2, &mut |case, _| done.push(case.name.clone()));
    done.sort();
    assert_eq!(done, ["0", "1", "2", "3", "4"]);
    let passed: Vec<bool> = reports.iter().map(|report| report.outcome == Outcome::Passed).collect();
    assert_eq!(passed, [true, true, true, false, true], "{reports:?}");
}
