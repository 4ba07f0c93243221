//! `compare`.

use super::*;

#[test]
fn compare_prints_metrics_and_obeys_bounds() {
    let dir = tempfile::tempdir().unwrap();
    let a = picture(dir.path(), "a.exr", [8, 4], [1.1; 3]);
    let b = picture(dir.path(), "b.exr", [8, 4], [1.0; 3]);
    let (a, b) = (a.to_str().unwrap(), b.to_str().unwrap());
    let plain = lightwell(&["compare", a, b]);
    assert_eq!(plain.status.code(), Some(0), "{}", err(&plain));
    for line in ["nrmse       0.100000", "rmse        0.100000", "bias        0.100000", "p95         0.100000", "flip"]
    {
        assert!(out(&plain).contains(line), "no `{line}` in\n{}", out(&plain));
    }
    let few = lightwell(&["compare", a, b, "--metric", "bias"]);
    assert_eq!(out(&few).lines().count(), 1, "{}", out(&few));
    assert_eq!(lightwell(&["compare", a, b, "--max", "nrmse=0.2,bias=0.2"]).status.code(), Some(0));
    let past = lightwell(&["compare", a, b, "--max", "nrmse=0.2", "--max", "bias=0.05"]);
    assert_eq!(past.status.code(), Some(1));
    assert!(
        out(&past).contains("past the bound 0.05") && out(&past).contains("within the bound 0.2"),
        "{}",
        out(&past)
    );
    // Too dark counts as much as too bright.
    assert_eq!(lightwell(&["compare", b, a, "--max", "bias=0.05"]).status.code(), Some(1));
}

#[test]
fn compare_writes_the_difference() {
    let dir = tempfile::tempdir().unwrap();
    let a = picture(dir.path(), "a.png", [8, 4], [0.5; 3]);
    let b = picture(dir.path(), "b.png", [8, 4], [0.2; 3]);
    let difference = dir.path().join("difference.png");
    let args = ["compare", a.to_str().unwrap(), b.to_str().unwrap(), "--difference", difference.to_str().unwrap()];
    let output = lightwell(&args);
    assert_eq!(output.status.code(), Some(0), "{}", err(&output));
    let picture = lightwell::measure::read_image(&difference).unwrap();
    let [red, _, blue] = picture.pixel(3, 2);
    assert!(red > 0.9 && blue < 0.1, "too bright is red: {red} {blue}");
}

#[test]
fn compare_puts_pictures_side_by_side() {
    let dir = tempfile::tempdir().unwrap();
    let a = picture(dir.path(), "a.exr", [8, 4], [0.5; 3]);
    let b = picture(dir.path(), "b.exr", [8, 4], [0.2; 3]);
    let figure = dir.path().join("figure.png");
    let output =
        lightwell(&["compare", a.to_str().unwrap(), b.to_str().unwrap(), "--figure", figure.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(0), "{}", err(&output));
    assert_eq!(lightwell::measure::read_image(&figure).unwrap().size(), [40, 4]);
}

#[test]
fn compare_takes_the_noise_of_the_reference_out() {
    let dir = tempfile::tempdir().unwrap();
    let file = |name: &str, color: f32| picture(dir.path(), name, [8, 4], [color; 3]).display().to_string();
    // The halves err by 0.2 each way, so that (1.1 - 0.8)(1.1 - 1.2) < 0: no error is left, and noise of 0.2.
    let (a, b, low, high) = (file("a.exr", 1.1), file("b.exr", 1.0), file("low.exr", 0.8), file("high.exr", 1.2));
    let output = lightwell(&["compare", &a, &b, "--halves", &low, &high, "--max", "nrmse=0.05"]);
    assert_eq!(output.status.code(), Some(0), "{}", out(&output));
    for line in ["noise       0.200000", "nrmse       0.000000", "bias        0.100000"] {
        assert!(out(&output).contains(line), "no `{line}` in\n{}", out(&output));
    }
    assert_eq!(lightwell(&["compare", &a, &b, "--halves", &low]).status.code(), Some(2));
}

#[test]
fn compare_says_what_is_wrong() {
    let dir = tempfile::tempdir().unwrap();
    let a = picture(dir.path(), "a.exr", [8, 4], [1.0; 3]);
    let other = picture(dir.path(), "b.exr", [4, 8], [1.0; 3]);
    let nan = picture(dir.path(), "nan.exr", [8, 4], [f32::NAN; 3]);
    let a = a.to_str().unwrap();
    for (b, expected) in [(other.to_str().unwrap(), "4x8"), (nan.to_str().unwrap(), "NaN"), ("none.exr", "none.exr")] {
        let output = lightwell(&["compare", a, b]);
        assert_eq!(output.status.code(), Some(1));
        assert!(err(&output).starts_with("error: ") && err(&output).contains(expected), "{}", err(&output));
    }
}

#[test]
fn compare_wants_exact_darkness() {
    let dir = tempfile::tempdir().unwrap();
    let dark = picture(dir.path(), "dark.exr", [8, 4], [0.0; 3]);
    let faint = picture(dir.path(), "faint.exr", [8, 4], [1e-20; 3]);
    let (dark, faint) = (dark.to_str().unwrap(), faint.to_str().unwrap());
    assert!(out(&lightwell(&["compare", dark, dark])).contains("exactly zero, as it must be"));
    let past = lightwell(&["compare", faint, dark, "--max", "rmse=1"]);
    assert_eq!(past.status.code(), Some(1), "{}", out(&past));
}

/// A file that is not there is named once, and so is the reason.
#[test]
fn compare_says_once_what_is_missing() {
    let output = lightwell(&["compare", "gone.exr", "gone too.exr"]);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{message}");
    for word in ["gone.exr", "os error 2"] {
        assert_eq!(message.matches(word).count(), 1, "{message}");
    }
}
