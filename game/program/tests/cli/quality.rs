//! `--quality` of `render` from the outside.

#![allow(clippy::unwrap_used)]

use std::path::Path;
use std::process::{Command, Output};

fn render(path: &Path, more: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_lightwell"));
    command.args(["render", "cornell", "--size", "32x24", "--gi", "none", "-o"]).arg(path).args(more);
    command.env_remove("RUST_LOG").output().unwrap()
}

fn said(output: &[u8]) -> String {
    String::from_utf8_lossy(output).into_owned()
}

#[test]
fn an_image_and_a_sequence_say_how_quiet_they_are() {
    let dir = tempfile::tempdir().unwrap();
    for (more, expected) in [
        (&[][..], "bound 0.02"),
        (&["--quality", "fast", "--time-limit", "60"], "bound 0.04"),
        (&["--frames", "0..2"], "for each of 2 frames; all are within their bound"),
    ] {
        let output = render(&dir.path().join("a.png"), more);
        assert_eq!(output.status.code(), Some(0), "{}", said(&output.stderr));
        let told = said(&output.stdout);
        assert!(told.contains("images averaged") && told.contains(expected), "{told}");
    }
    let first = std::fs::read(dir.path().join("a_0000.png")).unwrap();
    render(&dir.path().join("b.png"), &["--quality", "fast"]);
    assert!(first == std::fs::read(dir.path().join("b.png")).unwrap(), "a frame alone has the bytes of the sequence's");
}

#[test]
fn a_single_frame_and_radiance_are_averaged_only_if_asked_for() {
    let dir = tempfile::tempdir().unwrap();
    for (name, more) in [("a.png", &["--aa", "1"][..]), ("a.exr", &[]), ("b.png", &["--only", "depth"])] {
        let output = render(&dir.path().join(name), more);
        assert_eq!((output.status.code(), said(&output.stdout).as_str()), (Some(0), ""), "{name}");
    }
}

#[test]
fn what_means_nothing_is_refused() {
    let dir = tempfile::tempdir().unwrap();
    for (name, more, code, expected) in [
        ("a.exr", &["--quality", "fast"][..], 1, "--quality does not apply: an .exr image"),
        ("a.png", &["--time-limit", "5", "--only", "depth"], 1, "--time-limit does not apply"),
        ("a.png", &["--aa", "4", "--quality", "best"], 2, "cannot be used with"),
        ("a.png", &["--time-limit", "0"], 2, "more than zero"),
        ("a.png", &["--quality", "perfect"], 2, "possible values: fast, good, best"),
    ] {
        let output = render(&dir.path().join(name), more);
        let message = said(&output.stderr);
        assert!(output.status.code() == Some(code) && message.contains(expected), "{more:?}: {message}");
    }
}
