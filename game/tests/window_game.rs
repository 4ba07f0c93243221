//! Games in a real window: played with the keyboard, edited with their own components, changed while they run.

#![cfg(target_os = "linux")]
#![allow(clippy::unwrap_used)]

#[path = "../program/tests/screen/mod.rs"]
mod screen;

use lightwell_game::prelude::*;
use lightwell_needs::needs;
use screen::{Display, PATIENCE, Window, difference};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// An example's program. Cargo builds it with the tests, unless a single test was asked for.
fn example(name: &str) -> PathBuf {
    let path = std::env::current_exe().unwrap().parent().unwrap().parent().unwrap().join("examples").join(name);
    assert!(path.exists(), "the example `{name}` is not built (cargo build --release --examples)");
    path
}

fn scene(name: &str) -> String {
    std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("examples").join(name)).unwrap()
}

#[needs("Xvfb", "xdotool", "import")]
fn lamplight_is_played_with_the_keyboard() {
    let (display, program) = (Display::open(), example("lamplight"));
    let folder = tempfile::tempdir().unwrap();
    let record = folder.path().join("way.script.ron");
    let words = ["--record", record.to_str().unwrap(), "--scale", "0.4"];
    let mut window = Window::start(&display, &program, &words, folder.path());
    window.focus("Lamplight");
    // The title stands in white on the dark image.
    let bright = |image: &lightwell::measure::Image| {
        let count = image.values().filter(|value| *value > 0.8).count();
        count as f64 / image.values().count() as f64
    };
    let menu = window.screen_until(|now| bright(now) > 0.002);
    assert!(bright(&menu) > 0.002, "no menu shows; the program said {}", window.said());
    window.keep("lamplight_menu");
    window.key("Return");
    let begun = window.screen_until(|now| difference(&menu, now) > 0.01);
    assert!(difference(&menu, &begun) > 0.01, "Enter begins the game");
    window.keep("lamplight_begun");
    window.xdotool(&["keydown", "w"]);
    let rolled = window.screen_until(|now| difference(&begun, now) > 0.004);
    window.xdotool(&["keyup", "w"]);
    window.keep("lamplight_rolled");
    let moved = difference(&begun, &rolled);
    assert!(moved > 0.004, "the ball rolls and the camera with it: {moved}");
    window.key("Escape");
    assert!(window.wait_for_end(), "Escape ends the game: {}", window.said());
    let script = InputScript::read(&record).unwrap();
    let has = |event: InputEvent| script.events.iter().any(|(_, known)| *known == event);
    for key in [Key::Enter, Key::W, Key::Escape] {
        assert!(has(InputEvent::Press(Button::Key(key))), "{key:?} is in {script:?}");
    }
    assert!(has(InputEvent::Release(Button::Key(Key::W))));
}

#[needs("Xvfb", "xdotool", "import")]
fn a_scene_that_changes_shows_in_the_running_game() {
    let (display, program) = (Display::open(), example("custom_component"));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("lift.scene.ron");
    // At rest, so that the image changes by the file alone.
    let text = scene("scenes/lift.scene.ron").replace("\"Lift\": (", "\"Lift\": (low: 1, high: 1,");
    let text = text.replace("high: 1,high: 3,", "high: 1,").replace(", 0.25, 0))", ", 1, 0))");
    std::fs::write(&path, &text).unwrap();
    let words = ["--scene", path.to_str().unwrap(), "--scale", "0.3"];
    let window = Window::start(&display, &program, &words, folder.path());
    window.focus("Lifts");
    let mean = |image: &lightwell::measure::Image, channel: usize| {
        image.pixels().iter().map(|pixel| f64::from(pixel[channel])).sum::<f64>() / image.pixels().len() as f64
    };
    let before = window.screen_until(|now| mean(now, 2) > 0.05);
    assert!(mean(&before, 2) > 0.05, "no picture; the program said {}", window.said());
    window.keep("lifts");
    let red = text.replace("sky: (0.25, 0.3, 0.4)", "sky: (0.6, 0.05, 0.05)");
    std::fs::write(&path, &red).unwrap();
    let changed = window.screen_until(|now| mean(now, 0) > 1.5 * mean(now, 2));
    assert!(mean(&changed, 0) > 1.5 * mean(&changed, 2), "a red sky; the program said {}", window.said());
    window.keep("lifts_red");
    std::fs::write(&path, red.replace("\"Lift\": (low", "\"Lift\": (lo")).unwrap();
    let start = Instant::now();
    while !window.said().contains("unknown field `lo`") {
        assert!(start.elapsed() < PATIENCE, "no error; the program said {}", window.said());
        std::thread::sleep(Duration::from_millis(100));
    }
    let text_shows = |now: &lightwell::measure::Image| difference(now, &changed) > 0.0005;
    let faulty = window.screen_until(text_shows);
    assert!(text_shows(&faulty) && difference(&faulty, &changed) < 0.05, "the last good one, with the error over it");
    window.keep("lifts_error");
    std::fs::write(&path, &text).unwrap();
    let mended = window.screen_until(|now| difference(now, &before) < 0.002);
    assert!(difference(&mended, &before) < 0.002, "mended: {}", difference(&mended, &before));
    window.kill();
}

#[needs("Xvfb", "xdotool", "import")]
fn frames_that_come_too_late_are_drawn_smaller() {
    let (display, program) = (Display::open(), example("lamplight"));
    let folder = tempfile::tempdir().unwrap();
    let window = Window::start(&display, &program, &["--scale", "0.3", "--fps", "500"], folder.path());
    window.focus("Lamplight");
    let start = Instant::now();
    while !window.said().contains("of the size for 500 frames/s") {
        assert!(start.elapsed() < PATIENCE, "no smaller frames; the program said {}", window.said());
        std::thread::sleep(Duration::from_millis(100));
    }
    window.kill();
}

#[cfg(feature = "editor")]
#[needs("Xvfb", "xdotool", "import")]
fn a_component_of_the_game_is_edited_undone_and_saved() {
    let (display, program) = (Display::open(), example("custom_component"));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("lift.scene.ron");
    std::fs::write(&path, scene("scenes/lift.scene.ron")).unwrap();
    let read = || std::fs::read_to_string(&path).unwrap();
    let before = read();
    let words = ["--edit", "--scene", path.to_str().unwrap()];
    let window = Window::open_editor(&display, &program, &words, folder.path());
    let row = window.place("First").at(0.5, 0.5);
    window.click(row);
    window.wait_for("the component in the inspector", |all| {
        ["Remove Lift", "Low", "High", "Duration", "Way"]
            .iter()
            .all(|wanted| all.iter().any(|(_, name)| name == wanted))
    });
    window.keep("edit_own");
    let high = window.place("High").at(0.5, 0.5);
    window.drag(high, 80);
    window.keep("edit_own_changed");
    // The second one has a height of its own in the file already.
    let changed = |text: &str| text.matches("\"Lift\": (high: ").count() == 2;
    window.key("ctrl+z");
    window.key("ctrl+s");
    std::thread::sleep(Duration::from_secs(2));
    assert!(!changed(&read()), "undone: {}", read());
    window.key("ctrl+y");
    window.key("ctrl+s");
    let start = Instant::now();
    while !changed(&read()) || read() == before {
        assert!(start.elapsed() < PATIENCE, "nothing is saved: {}; it said {}", read(), window.said());
        std::thread::sleep(Duration::from_millis(100));
    }
    let saved = read();
    assert!(saved.contains("(high: 3, way: Even)"), "the other lifts stay: {saved}");
    window.kill();
    // The game itself reads what was saved.
    let out = folder.path().join("out");
    let status = std::process::Command::new(&program)
        .args(["--headless", "--steps", "2", "--every", "2", "--size", "64x40", "--scene", path.to_str().unwrap()])
        .args(["-o", out.to_str().unwrap(), "--set", "First.Lift.low=1.5"])
        .env("NODEVICE_SELECT", "1")
        .status()
        .unwrap();
    assert!(status.success() && out.join("step_0002.png").exists());
    assert!(!read().contains("low: 1.5"), "--set changes no file");
}
