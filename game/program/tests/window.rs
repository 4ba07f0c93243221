//! The program in a real window: opened, clicked, edited, saved and killed as a person would.

#![cfg(target_os = "linux")]
#![allow(clippy::unwrap_used)]

mod screen;

use lightwell_needs::needs;
use lightwell_runtime::window_figures::{RESTED, WindowFigures};
use screen::{Display, PATIENCE, Place, Window, difference};
use std::path::Path;
use std::time::{Duration, Instant};

/// The editor on a scene, still, at the start of the clock.
fn open<'a>(display: &'a Display, scene: &Path) -> Window<'a> {
    // A picture stands still at once.
    let words = ["play", scene.to_str().unwrap(), "--average", "off"];
    Window::open_editor(display, Path::new(env!("CARGO_BIN_EXE_lightwell")), &words, scene.parent().unwrap())
}

#[needs("Xvfb", "xdotool", "import")]
fn a_scene_is_opened_edited_undone_saved_and_survives_a_kill() {
    let display = Display::open();
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("box.scene.ron");
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/cornell.scene.ron");
    std::fs::copy(source, &scene).unwrap();
    let read = || std::fs::read_to_string(&scene).unwrap();
    let before = read();

    let window = open(&display, &scene);
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
        let window = open(&display, &scene);
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
#[needs("Xvfb", "xdotool", "import")]
fn the_first_minutes_of_a_user() {
    let display = Display::open();
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("box.scene.ron");
    std::fs::copy(Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/cornell.scene.ron"), &scene).unwrap();
    let text = |path: &Path| {
        let world = lightwell::files::load_scene(path, &mut Default::default(), &Default::default()).unwrap();
        lightwell::files::save_scene(&world, &folder.path().join("again.scene.ron")).unwrap();
        std::fs::read_to_string(folder.path().join("again.scene.ron")).unwrap()
    };
    let before = text(&scene);
    let mut window = open(&display, &scene);
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
    // Nothing is selected then, and no handle is in the image.
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

    let window = open(&display, &other);
    let again = difference(&still, &window.picture(|now| difference(&still, now) < 0.005));
    assert!(again < 0.005, "what was saved under another name looks the same: {again}");
    window.keep("walk_played");
    window.kill();
}

#[needs("Xvfb", "xdotool", "import")]
fn a_light_is_changed_without_a_mouse() {
    let display = Display::open();
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("box.scene.ron");
    std::fs::copy(Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/cornell.scene.ron"), &scene).unwrap();
    let window = open(&display, &scene);
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
    while !std::fs::read_to_string(&scene).unwrap().contains("intensity: 33") {
        assert!(start.elapsed() < PATIENCE, "nothing is saved; it said {}", window.said());
        std::thread::sleep(Duration::from_millis(100));
    }
    window.kill();
}

/// Images of the animation as a user makes them: from the menu, with fields that are typed into, and one export that is
/// cancelled.
#[needs("Xvfb", "xdotool", "import")]
fn an_animation_is_exported_and_another_export_cancelled() {
    let display = Display::open();
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("box.scene.ron");
    std::fs::copy(Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/cornell.scene.ron"), &scene).unwrap();
    let window = open(&display, &scene);
    let ask_for = |into: &Path, frames: u32| {
        window.click(window.place("File").at(0.5, 0.5));
        window.click(window.place("Export the animation…").at(0.5, 0.5));
        // At 30 frames a second.
        let size = format!("64 × 48 pixels, {:.2} s of the animation", f64::from(frames) / 30.0);
        let (into, frames) = (into.to_str().unwrap(), frames.to_string());
        let is_filled =
            |all: &[(Place, String)]| [into, &size].iter().all(|value| all.iter().any(|(_, text)| text == value));
        let start = Instant::now();
        // A slow interface may miss a key that comes before its field is open: then whoever sits there types again.
        while !is_filled(&window.widgets()) {
            assert!(start.elapsed() < PATIENCE, "the fields take nothing; it said {}", window.said());
            for (field, value) in [("Path", into), ("Width", "64"), ("Height", "48"), ("Frames", &frames)] {
                window.click(window.place(field).at(0.5, 0.5));
                window.key("ctrl+a");
                window.xdotool(&["type", value]);
                window.key("Tab");
            }
            std::thread::sleep(Duration::from_secs(1));
        }
        window.keep("export");
        window.click(window.place("Export").at(0.5, 0.5));
    };
    let (whole, cut) = (folder.path().join("whole"), folder.path().join("cut"));
    ask_for(&whole, 3);
    window.wait_for("the end of the export", |all| all.iter().any(|(_, text)| text.starts_with("exported into")));
    let frames = |folder: &Path| std::fs::read_dir(folder).map_or(0, Iterator::count);
    assert_eq!(frames(&whole), 3, "{}", window.said());
    let frame = |number: u32| lightwell::measure::read_image(&whole.join(format!("frame_000{number}.png"))).unwrap();
    assert_eq!(frame(1).size(), [64, 48]);
    assert!(difference(&frame(1), &frame(3)) > 0.0, "nothing moves");

    ask_for(&cut, 500);
    window.wait_for("a first frame", |_| frames(&cut) > 0);
    window.click(window.place("Cancel the export").at(0.5, 0.5));
    window.wait_for("the end", |all| all.iter().any(|(_, text)| text.starts_with("export cancelled")));
    window.keep("export_cancelled");
    let done = frames(&cut);
    std::thread::sleep(Duration::from_secs(2));
    assert!(done < 500 && frames(&cut) == done, "{done} frames, then {}", frames(&cut));
    window.kill();
}

/// A shader is broken and mended in another program while the window is open.
#[needs("Xvfb", "xdotool", "import")]
fn a_broken_shader_leaves_the_picture_and_a_mended_one_changes_it() {
    let display = Display::open();
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("box.scene.ron");
    std::fs::copy(Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/cornell.scene.ron"), &scene).unwrap();
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shaders");
    let shaders = folder.path().join("shaders");
    // The program takes those of the folder that it runs in.
    assert!(std::process::Command::new("cp").arg("-r").args([&source, &shaders]).status().unwrap().success());
    let window = open(&display, &scene);
    let before = window.picture(|_| true);
    let compose = shaders.join("post/compose.wgsl");
    let text = std::fs::read_to_string(&compose).unwrap();
    let says = |words: &'static str| move |all: &[(_, String)]| all.iter().any(|(_, text)| text.contains(words));
    std::fs::write(&compose, text.replace("over.rgb;", "over.rgb + nonsense;")).unwrap();
    window.wait_for("the error", says("`nonsense`"));
    window.keep("broken_shader");
    let kept = difference(&before, &window.picture(|_| true));
    assert!(kept < 0.005, "the last good shader goes on: {kept}");
    // No red light any more.
    let mended =
        text.replace("vec4f(min(all, vec3f(MAX_RADIANCE)), 1.0)", "vec4f(0.0, min(all.gb, vec2f(MAX_RADIANCE)), 1.0)");
    assert_ne!(mended, text);
    std::fs::write(&compose, mended).unwrap();
    window.wait_for("the mended one", says("reloaded shader post/compose.wgsl"));
    let red = |image: &lightwell::measure::Image| image.pixels().iter().map(|pixel| f64::from(pixel[0])).sum::<f64>();
    let after = window.picture(|now| red(now) < 0.5 * red(&before));
    assert!(red(&after) < 0.5 * red(&before), "{} of {}", red(&after), red(&before));
    window.kill();
}

/// A window that is made as small as can be, taken off the screen and brought back shows the same image again.
#[needs("Xvfb", "xdotool", "import")]
fn a_window_comes_back_from_nothing() {
    let display = Display::open();
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("box.scene.ron");
    std::fs::copy(Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/cornell.scene.ron"), &scene).unwrap();
    let mut window = open(&display, &scene);
    let before = window.picture(|_| true);
    let to_window = |words: &[&str]| window.xdotool(&[&["search", "--name", "Lightwell"], words].concat());
    to_window(&["windowsize", "1", "1"]);
    std::thread::sleep(Duration::from_secs(2));
    to_window(&["windowunmap"]);
    std::thread::sleep(Duration::from_secs(2));
    to_window(&["windowmap"]);
    let [width, height] = screen::SIZE.map(|edge| edge.to_string());
    to_window(&["windowsize", &width, &height]);
    let after =
        difference(&before, &window.picture(|now| now.size() == before.size() && difference(&before, now) < 0.005));
    assert!(after < 0.005, "another picture came back: {after}; it said {}", window.said());
    assert!(!window.said().contains("error"), "{}", window.said());
    window.focus("Lightwell");
    window.key("ctrl+q");
    assert!(window.wait_for_end(), "{}", window.said());
}

/// The window goes to a monitor of half as many pixels again to the inch, and back: all panels grow with it, clicks fall
/// where they are shown, and the same image comes back.
#[needs("Xvfb", "xdotool", "import")]
fn a_monitor_of_another_scale_is_followed() {
    let display = Display::open();
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("box.scene.ron");
    std::fs::copy(Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/cornell.scene.ron"), &scene).unwrap();
    let mut window = open(&display, &scene);
    let height = |place: Place| f64::from(place.0[3] - place.0[1]);
    let to = |dots_per_inch: u32, factor: f64, of: f64| {
        display.set_dots_per_inch(dots_per_inch);
        window.wait_for("another scale", |all| {
            all.iter().any(|(place, name)| name == "Search" && (height(*place) / of / factor - 1.0).abs() < 0.1)
        });
        // The program asked for a window that has as much room for its panels.
        let [width, height] = screen::SIZE.map(|edge| edge.to_string());
        window.xdotool(&["search", "--name", "Lightwell", "windowsize", &width, &height]);
        let [width, _] = screen::SIZE.map(|edge| edge as i32);
        let fits = |all: &[(Place, String)]| {
            let right =
                all.iter().filter(|(_, name)| name == "Size x" || name == "Picture").map(|(place, _)| place.0[2]);
            right.max().is_some_and(|right| right > width / 4 && right <= width)
        };
        window.wait_for("the old size of the window", fits);
    };
    let before = window.picture(|_| true);
    let line = height(window.place("Search"));

    to(144, 1.5, line);
    let large = window.picture(|_| true);
    window.keep("scale");
    assert!(large.size() != before.size(), "the panels leave as much room as before");
    // The front of the taller block, in a view of another form: heights count from the middle.
    window.click(window.place("Picture").at(0.5, 0.85));
    window.wait_for("the floor", |all| all.iter().any(|(_, name)| name == "Size x"));
    window.key("Escape");

    to(96, 1.0, line);
    let fits = |now: &lightwell::measure::Image| now.size() == before.size() && difference(&before, now) < 0.005;
    let after = window.picture(fits);
    assert!(fits(&after), "another picture came back, of {:?}; it said {}", after.size(), window.said());
    assert!(!window.said().contains("error"), "{}", window.said());
    window.focus("Lightwell");
    window.key("ctrl+q");
    assert!(window.wait_for_end(), "{}", window.said());
}

#[needs("Xvfb", "xdotool", "import")]
fn a_window_measures_itself_and_ends() {
    let display = Display::open();
    let folder = tempfile::tempdir().unwrap();
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/cornell.scene.ron");
    let file = folder.path().join("figures.ron");
    let words = ["play", scene.to_str().unwrap(), "--scale", "0.1", "--measure", file.to_str().unwrap()];
    let mut window = Window::start(&display, Path::new(env!("CARGO_BIN_EXE_lightwell")), &words, folder.path());
    assert!(window.wait_for_end_within(4 * PATIENCE), "{}", window.said());
    let figures = WindowFigures::read(&file).unwrap();
    assert!(0.0 < figures.first_picture && figures.first_picture < figures.first_indirect, "{figures:?}");
    assert!(figures.rate() > 0.0 && figures.answers.len() == 8 && figures.answers_at_rest.len() == 8, "{figures:?}");
    assert!(figures.rested.len() == RESTED.len() && figures.rested.is_sorted(), "{figures:?}");
    assert!(!folder.path().join("config").exists(), "a measured window remembers nothing");
}
