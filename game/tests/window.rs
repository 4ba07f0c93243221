//! The program in a real window: opened, clicked, edited, saved and killed as a person would.

#![cfg(target_os = "linux")]
#![allow(clippy::unwrap_used)]

mod screen;

use screen::{Display, PATIENCE, Window, difference};
use std::path::Path;
use std::time::{Duration, Instant};

#[test]
fn a_scene_is_opened_edited_undone_saved_and_survives_a_kill() {
    let Some(display) = Display::open() else { return };
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("box.scene.ron");
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/cornell.scene.ron");
    std::fs::copy(source, &scene).unwrap();
    let read = || std::fs::read_to_string(&scene).unwrap();
    let before = read();

    let window = Window::open(&display, &scene);
    let view = window.place("Picture");
    // The front of the taller block.
    window.click(view.at(0.42, 0.62));
    window.wait_for("the size of the block", |all| all.iter().any(|(_, name)| name == "Size x"));
    // The sign of the light below the ceiling: 0.9 m above the middle, 4 m away, in a view of 40°.
    let height = 0.5 - 0.5 * (0.9 / 4.0) / 20_f32.to_radians().tan();
    window.click(view.at(0.5, height));
    window.wait_for("the light in the inspector", |all| all.iter().any(|(_, name)| name == "Intensity"));
    let [x, y] = view.at(0.5, 0.98);
    window.move_to([x, y]);
    let lit = window.picture(|_| true);

    // Less green: the light turns to purple.
    let green = window.place("Color y").at(0.5, 0.5);
    window.drag(green, -300);
    window.move_to([x, y]);
    let purple = window.picture(|now| difference(&lit, now) > 0.005);
    let changed = difference(&lit, &purple);
    assert!(changed > 0.005, "the light of another colour changes the picture by {changed}");

    window.key("ctrl+z");
    let undone = difference(&lit, &window.picture(|now| difference(&lit, now) < 0.02 * changed));
    assert!(undone < 0.02 * changed, "undo leaves a difference of {undone}");
    assert_eq!(read(), before, "nothing was saved");

    window.key("ctrl+y");
    window.key("ctrl+s");
    let start = Instant::now();
    while read() == before {
        assert!(start.elapsed() < PATIENCE, "nothing is saved");
        std::thread::sleep(Duration::from_millis(50));
    }
    let saved = read();
    assert_eq!(std::fs::read_to_string(scene.with_extension("ron.bak")).unwrap(), before, "the file before is kept");
    window.kill();

    // Killed around a save: either the old scene is there or the new one, and it opens.
    for trial in 0..3 {
        let window = Window::open(&display, &scene);
        let row = window.place("Camera").at(0.5, 0.5);
        window.click(row);
        window.wait_for("the camera in the inspector", |all| all.iter().any(|(_, name)| name == "Fov"));
        let at = window.place("Translation y").at(0.5, 0.5);
        window.drag(at, 60);
        display.run("xdotool", &["key", "ctrl+s"]);
        std::thread::sleep(Duration::from_millis(15 * trial));
        window.kill();
        let left = read();
        let is_old = left == saved;
        println!("trial {trial}: the {} scene is there", if is_old { "old" } else { "new" });
        let world = lightwell::files::load_scene(&scene, &mut Default::default(), &Default::default());
        let world = world.unwrap_or_else(|error| panic!("the scene is torn: {error}"));
        assert!(world.find("Swing/Spot light").is_some());
        std::fs::write(&scene, &saved).unwrap();
    }
}

/// What the README promises: open a scene, move the lamp, change the quality of the light volume, undo it all, save under
/// another name and play that.
#[test]
fn the_first_minutes_of_a_user() {
    let Some(display) = Display::open() else { return };
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("box.scene.ron");
    std::fs::copy(Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/cornell.scene.ron"), &scene).unwrap();
    let text = |path: &Path| {
        let world = lightwell::files::load_scene(path, &mut Default::default(), &Default::default()).unwrap();
        lightwell::files::save_scene(&world, &folder.path().join("again.scene.ron")).unwrap();
        std::fs::read_to_string(folder.path().join("again.scene.ron")).unwrap()
    };
    let before = text(&scene);
    let mut window = Window::open(&display, &scene);
    let still = window.picture(|_| true);

    let view = window.place("Picture");
    let height = 0.5 - 0.5 * (0.9 / 4.0) / 20_f32.to_radians().tan();
    window.click(view.at(0.5, height));
    window.wait_for("the lamp in the inspector", |all| all.iter().any(|(_, name)| name == "Intensity"));
    // The handle to the right.
    let [x, y] = view.at(0.5, height);
    window.drag([x + 60, y], 50);
    let moved = window.picture(|now| difference(&still, now) > 0.005);
    let by = difference(&still, &moved);
    assert!(by > 0.005, "the lamp has moved, and its light with it: {by}");
    window.keep("walk_moved");

    let row = window.place("Light volume").at(0.5, 0.5);
    window.click(row);
    let quality = window.place("Quality").at(0.5, 0.5);
    window.click(quality);
    let low = window.place("Low").at(0.5, 0.5);
    window.keep("walk_quality");
    window.click(low);
    window.wait_for("the choice to be made", |all| !all.iter().any(|(_, name)| name == "Ultra"));

    window.key("ctrl+z");
    window.key("ctrl+z");
    // Nothing is selected then, and no handle is in the picture.
    window.click(window.place("Camera").at(0.5, 0.5));
    window.key("ctrl+shift+s");
    let _ = window.place("Path");
    let other = folder.path().join("other.scene.ron");
    window.key("ctrl+a");
    window.xdotool(&["type", other.to_str().unwrap()]);
    window.keep("walk_save_as");
    window.key("Return");
    let start = Instant::now();
    while !other.exists() {
        assert!(start.elapsed() < PATIENCE, "nothing is saved; it said {}", window.said());
        std::thread::sleep(Duration::from_millis(100));
    }
    assert_eq!(text(&other), before, "all was undone");
    window.key("ctrl+q");
    assert!(window.wait_for_end(), "{}", window.said());

    let window = Window::open(&display, &other);
    let again = difference(&still, &window.picture(|now| difference(&still, now) < 0.005));
    assert!(again < 0.005, "what was saved under another name looks the same: {again}");
    window.keep("walk_played");
    window.kill();
}

#[test]
fn a_light_is_changed_without_a_mouse() {
    let Some(display) = Display::open() else { return };
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("box.scene.ron");
    std::fs::copy(Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/cornell.scene.ron"), &scene).unwrap();
    let window = Window::open(&display, &scene);
    let tab_to = |wanted: &str| {
        for _ in 0..120 {
            if window.focused().as_deref() == Some(wanted) {
                return;
            }
            window.key("Tab");
        }
        panic!("Tab does not come to {wanted}; it said {}", window.said());
    };
    window.key("ctrl+f");
    window.xdotool(&["type", "Spot"]);
    tab_to("Spot light");
    window.key("Return");
    window.wait_for("the light in the inspector", |all| all.iter().any(|(_, name)| name == "Intensity"));
    tab_to("Intensity");
    window.key("ctrl+a");
    window.xdotool(&["type", "33"]);
    window.key("Return");
    window.keep("keyboard");
    window.key("ctrl+s");
    let start = Instant::now();
    while !std::fs::read_to_string(&scene).unwrap().contains("intensity: 33.0") {
        assert!(start.elapsed() < PATIENCE, "nothing is saved; it said {}", window.said());
        std::thread::sleep(Duration::from_millis(100));
    }
    window.kill();
}
