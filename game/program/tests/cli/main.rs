//! The program as its users call it.

#![allow(clippy::unwrap_used)]

mod compare;
mod faults;
mod quality;
mod reload;

use lightwell::measure::{Image, write_image};
use lightwell_needs::needs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn lightwell(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_lightwell")).args(args).env_remove("RUST_LOG").output().unwrap()
}

fn out(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

fn err(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Writes an image of one colour, and gives its path.
fn picture(folder: &Path, name: &str, size: [u32; 2], color: [f32; 3]) -> PathBuf {
    let path = folder.join(name);
    write_image(&path, &Image::filled(size[0], size[1], color)).unwrap();
    path
}

#[test]
fn help_teaches_by_example() {
    let help = lightwell(&["--help"]);
    assert_eq!(help.status.code(), Some(0));
    for word in [
        "play",
        "render",
        "compare",
        "explain",
        "test",
        "sheet",
        "pack",
        "info",
        "Examples:",
        "LIGHTWELL_MODELS",
        "Exit codes",
    ] {
        assert!(out(&help).contains(word), "no {word} in\n{}", out(&help));
    }
    for command in ["play", "render", "compare", "explain", "test", "sheet", "pack", "info"] {
        let help = lightwell(&[command, "--help"]);
        assert_eq!(help.status.code(), Some(0), "{command}: {}", err(&help));
    }
}

/// Without a desktop the driver has nothing to complain about.
#[test]
fn the_driver_is_quiet() {
    let mut command = Command::new(env!("CARGO_BIN_EXE_lightwell"));
    let info = command.arg("info").env_remove("XDG_RUNTIME_DIR").env_remove("NODEVICE_SELECT").output().unwrap();
    assert_eq!((err(&info).as_str(), info.status.code()), ("", Some(0)));
}

#[test]
fn wrong_usage_is_two() {
    for args in [
        &[][..],
        &["dance"],
        &["render"],
        &["render", "cornell"],
        &["render", "cornell", "-o", "a.bmp"],
        &["render", "cornell", "-o", "a.png", "--size", "12"],
        &["render", "cornell", "-o", "a.png", "--time", "1", "--frames", "0..2"],
        &["render", "cornell", "-o", "a.png", "--gi", "magic"],
        &["render", "cornell", "-o", "a.png", "--set", "nonsense"],
        &["render", "cornell", "-o", "a.png", "--aa", "0"],
        &["compare", "a.exr"],
        &["compare", "a.exr", "b.exr", "--max", "luck=1"],
        &["compare", "a.exr", "b.exr", "--metric", "luck"],
    ] {
        let output = lightwell(args);
        assert_eq!(output.status.code(), Some(2), "{args:?}: {}", err(&output));
        assert!(!err(&output).is_empty(), "{args:?}");
    }
}

#[test]
fn scene_tests_run_are_blessed_and_fail_with_pictures() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("box.test.ron");
    let text = "(description: \"a box\", scene: \"cornell\", size: (32, 32), expect: (golden: (flip: 0.01)))";
    std::fs::write(&file, text).unwrap();
    let (folder, pictures) = (dir.path().to_str().unwrap(), dir.path().join("pictures"));
    let test = |more: &[&str]| {
        lightwell(&[&["test", folder, "-o", pictures.to_str().unwrap(), "--jobs", "1"][..], more].concat())
    };
    assert!(out(&test(&["--list"])).contains("box  a box"));
    let missing = test(&[]);
    assert_eq!(missing.status.code(), Some(1), "{}", out(&missing));
    assert!(out(&missing).contains("no golden image") && out(&missing).contains("--bless"), "{}", out(&missing));
    let blessed = test(&["--bless"]);
    assert_eq!(blessed.status.code(), Some(0), "{}", out(&blessed));
    assert!(out(&blessed).contains("blessed") && out(&blessed).contains("box_0s.png"), "{}", out(&blessed));
    let passed = test(&["--filter", "box"]);
    assert!(passed.status.code() == Some(0) && out(&passed).contains("1 passed, 0 failed, 0 skipped"));
    // A golden image that is wrong.
    write_image(&dir.path().join("goldens/box_0s.png"), &Image::filled(32, 32, [0.9, 0.1, 0.5])).unwrap();
    let wrong = test(&[]);
    assert_eq!(wrong.status.code(), Some(1), "{}", out(&wrong));
    for kind in ["actual", "expected", "difference"] {
        let picture = pictures.join(format!("box_0s_golden.{kind}.png"));
        assert!(picture.is_file() && out(&wrong).contains(picture.to_str().unwrap()), "{}", out(&wrong));
    }
    std::fs::write(&file, text.replace("size", "sise")).unwrap();
    let misspelt = test(&[]);
    assert_eq!(misspelt.status.code(), Some(1));
    assert!(
        out(&misspelt).contains("box.test.ron:1:42:") && out(&misspelt).contains("did you mean `size`?"),
        "{}",
        out(&misspelt)
    );
    assert_eq!(test(&["--filter", "sphere"]).status.code(), Some(1));
    assert_eq!(test(&["--jobs", "0"]).status.code(), Some(2));
}

#[test]
fn a_missing_scene_is_named_with_those_that_exist() {
    for command in [&["explain", "no_such_scene"][..], &["render", "no_such_scene", "-o", "a.png"]] {
        let output = lightwell(command);
        assert_eq!(output.status.code(), Some(1));
        assert!(err(&output).contains("`no_such_scene`"), "{}", err(&output));
        assert!(err(&output).contains("cornell"), "{}", err(&output));
    }
}

#[test]
fn info_names_the_adapter() {
    let output = lightwell(&["info"]);
    assert_eq!(output.status.code(), Some(0), "{}", err(&output));
    assert!(out(&output).contains("adapter") && out(&output).contains("storage binding"), "{}", out(&output));
    let none = lightwell(&["info", "--adapter", "no such adapter"]);
    assert_eq!(none.status.code(), Some(1));
    assert!(err(&none).contains("no such adapter"), "{}", err(&none));
}

#[test]
fn render_twice_gives_equal_bytes() {
    let dir = tempfile::tempdir().unwrap();
    let render = |name: &str, more: &[&str]| {
        let path = dir.path().join(name);
        let mut args = vec!["render", "cornell", "-o", path.to_str().unwrap(), "--size", "64x48", "--time", "1.5"];
        args.extend(more);
        let output = lightwell(&args);
        assert_eq!(output.status.code(), Some(0), "{}", err(&output));
        std::fs::read(path).unwrap()
    };
    let first = render("a.exr", &["--aa", "2"]);
    assert_eq!(first, render("b.exr", &["--aa", "2"]));
    assert_ne!(first, render("c.exr", &["--aa", "2", "--set", "Spot light.light.intensity=3"]));
    let image = lightwell::measure::read_image(&dir.path().join("a.exr")).unwrap();
    assert_eq!((image.size(), image.first_non_finite()), ([64, 48], None));
    assert!(image.mean() > 0.0);
    assert!(render("d.png", &[]).starts_with(b"\x89PNG"));
}

#[test]
fn frames_are_numbered_files() {
    let dir = tempfile::tempdir().unwrap();
    let pattern = dir.path().join("new folder/{}.png");
    let args = ["render", "cornell", "-o", pattern.to_str().unwrap(), "--size", "32x32", "--frames", "2..4"];
    let output = lightwell(&args);
    assert_eq!(output.status.code(), Some(0), "{}", err(&output));
    for name in ["0002.png", "0003.png"] {
        assert!(dir.path().join("new folder").join(name).is_file(), "{name}");
    }
}

/// Each is read back while the next one is drawn, over what was kept of those before it.
#[test]
fn frames_of_a_sequence_are_those_drawn_alone() {
    let dir = tempfile::tempdir().unwrap();
    let render = |folder: &str, ending: &str, frames: &str| {
        let pattern = dir.path().join(folder).join(format!("{{}}.{ending}"));
        let pattern = pattern.to_str().unwrap();
        let output = lightwell(&[
            "render",
            "bleeding_gloss",
            "-o",
            pattern,
            "--size",
            "48x48",
            "--gi",
            "none",
            "--frames",
            frames,
        ]);
        assert_eq!(output.status.code(), Some(0), "{}", err(&output));
    };
    for ending in ["png", "exr"] {
        render("all", ending, "3..8");
        for frame in [3, 5, 7] {
            render("alone", ending, &format!("{frame}..{}", frame + 1));
            let [all, alone] = ["all", "alone"]
                .map(|folder| std::fs::read(dir.path().join(folder).join(format!("{frame:04}.{ending}"))).unwrap());
            assert!(all == alone, "frame {frame} as {ending} differs");
        }
    }
}

#[test]
fn wrong_paths_and_cameras_say_what_there_is() {
    for (more, expected) in [
        (["--set", "Spot light.light.power=5"], "intensity"),
        (["--set", "Moon.light.intensity=5"], "Spot light"),
        (["--camera", "Selfie"], "there are: Camera"),
    ] {
        let output = lightwell(&[&["explain", "cornell"][..], &more].concat());
        assert_eq!(output.status.code(), Some(1));
        assert!(err(&output).contains(expected), "{}", err(&output));
    }
}

#[test]
fn explain_shows_work_and_then_reuse() {
    let output = lightwell(&["explain", "cornell", "--size", "64x64"]);
    assert_eq!(output.status.code(), Some(0), "{}", err(&output));
    let text = out(&output);
    let (first, second) = text.split_once("frame 2").unwrap();
    // The light moves.
    let (second, third) = second.split_once("frame 4").unwrap();
    assert!(first.contains(" ran ") && !second.contains(" ran ") && third.contains(" ran "), "{text}");
    assert!(second.contains(" cached "), "{text}");
}

#[test]
fn explain_shows_what_moves_over_what_was_kept() {
    let output = lightwell(&["explain", "bleeding_gloss", "--size", "32x32", "--gi", "none", "--only", "direct"]);
    let text = out(&output);
    let (_, moved) = text.split_once("frame 4").unwrap_or_else(|| panic!("{text}{}", err(&output)));
    let line = moved.lines().find(|line| line.starts_with("gbuffer, still")).unwrap_or_else(|| panic!("{moved}"));
    assert!(line.contains(" cached "), "{moved}");
}

#[test]
#[cfg(not(any(windows, target_os = "macos")))]
fn play_without_a_display_writes_frames() {
    let dir = tempfile::tempdir().unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_lightwell"))
        .args(["play", "cornell", "--size", "32x32"])
        .current_dir(dir.path())
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        .env_remove("WAYLAND_SOCKET")
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", err(&output));
    assert!(dir.path().join("out/cornell/frame_0048.png").is_file(), "{}", out(&output));
    assert!(out(&output).contains("frame_0001.png"), "{}", out(&output));
}

#[test]
#[cfg(not(any(windows, target_os = "macos")))]
fn windows_are_measured_where_there_is_a_display() {
    let dir = tempfile::tempdir().unwrap();
    for words in [&["play", "cornell", "--measure", "a.ron"][..], &["bench", "--window", "-o", "out"]] {
        let output = Command::new(env!("CARGO_BIN_EXE_lightwell"))
            .args(words)
            .current_dir(dir.path())
            .env_remove("DISPLAY")
            .env_remove("WAYLAND_DISPLAY")
            .env_remove("WAYLAND_SOCKET")
            .output()
            .unwrap();
        assert!(!output.status.success() && err(&output).contains("there is no display"), "{}", err(&output));
    }
}

#[test]
fn sheets_show_bad_files_too() {
    let dir = tempfile::tempdir().unwrap();
    std::fs::write(dir.path().join("broken.gltf"), b"{").unwrap();
    std::fs::write(
        dir.path().join("ball.scene.ron"),
        r#"Scene(entities: [
            (name: "Camera", transform: (translation: (0, 0, 4)), camera: (fov: 45)),
            (name: "Ball", mesh: Sphere(radius: 1), material: (emissive: (1, 0, 0))),
        ])"#,
    )
    .unwrap();
    let sheets = dir.path().join("sheets");
    let (folder, target) = (dir.path().to_string_lossy(), sheets.to_string_lossy());
    let output = lightwell(&["sheet", &folder, "-o", &target, "--size", "160x160", "--jobs", "1"]);
    assert_eq!(output.status.code(), Some(0), "{}", err(&output));
    assert!(out(&output).contains("2 files: 1 drawn (0 with warnings), 1 with errors"), "{}", out(&output));
    let report = std::fs::read_to_string(sheets.join("sheet.txt")).unwrap();
    assert!(report.contains("broken ") && report.contains("error: JSON, line 1"), "{report}");
    let sheet = lightwell::measure::read_image(&sheets.join("sheet_01.png")).unwrap();
    // The first cell holds the ball's red middle, the second the message on grey.
    let [r, g, _] = sheet.pixel(10 + 80, 10 + 80);
    assert!(r > 2.0 * g, "{r} {g}");
    assert!(lightwell(&["sheet", "no_such_folder", "-o", &target]).status.code() == Some(1));
}

/// Peak of a process's resident memory so far [MB]; none where the system does not tell, or it has ended.
fn peak_megabytes(process: u32) -> Option<f64> {
    let status = std::fs::read_to_string(format!("/proc/{process}/status")).ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM"))?;
    Some(line.split_whitespace().nth(1)?.parse::<f64>().ok()? * 1024.0 / 1e6)
}

#[needs("LIGHTWELL_MODELS")]
fn sponza_is_loaded_and_drawn_within_600_megabytes() {
    let folder = tempfile::tempdir().unwrap();
    let picture = folder.path().join("sponza.png");
    let mut command = Command::new(env!("CARGO_BIN_EXE_lightwell"));
    command.args(["render", "sponza", "--gi", "none", "--aa", "1", "--size", "256x256", "-o"]).arg(&picture);
    let mut child = command.env_remove("RUST_LOG").spawn().unwrap();
    let mut peak = 0.0_f64;
    let status = loop {
        if let Some(status) = child.try_wait().unwrap() {
            break status;
        }
        peak = peak.max(peak_megabytes(child.id()).unwrap_or(0.0));
        std::thread::sleep(std::time::Duration::from_millis(5));
    };
    assert!(status.success() && picture.is_file());
    eprintln!("peak: {peak:.0} MB");
    assert!(peak < 600.0, "{peak} MB");
}

/// What a process holds after many frames is what it held after few. Software drivers that make a shader anew for each
/// frame keep a third of a MiB and more of each.
#[test]
fn frames_of_every_method_leave_nothing_behind() {
    for scene in ["glossy_ring", "bleeding_gloss"] {
        let run = lightwell(&["stress", "--endure", scene, "--frames", "200", "-o", "."]);
        assert_eq!(run.status.code(), Some(0), "{}", err(&run));
        let lines = out(&run);
        let told: serde_json::Value = serde_json::from_str(lines.lines().last().unwrap()).unwrap();
        assert_eq!(told["frames"], 200, "{told}");
        let Some(memory) = told["memory"].as_array() else { continue };
        let [early, late] = [0, 1].map(|index| memory[index].as_u64().unwrap());
        assert!(late < early + 40, "{scene}: after 20 frames the process holds {early} MiB, after 200 {late}");
    }
}
