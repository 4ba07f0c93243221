//! The program in a real window: opened, clicked, edited, saved and killed as a person would.
//!
//! Needs `Xvfb`, `xdotool` and `import` (ImageMagick); without them the test says so and checks nothing.

#![cfg(target_os = "linux")]
#![allow(clippy::unwrap_used)]

use lightwell::measure::{Image, read_image};
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

const SIZE: [u32; 2] = [1280, 800];
/// Software drivers on busy machines take their time.
const PATIENCE: Duration = Duration::from_secs(90);

/// A display that nobody sees.
struct Display {
    server: Child,
    name: String,
}

impl Display {
    /// None, with a message, where a tool is missing.
    fn open() -> Option<Self> {
        for tool in ["Xvfb", "xdotool", "import"] {
            let found = std::env::split_paths(&std::env::var_os("PATH")?).any(|folder| folder.join(tool).is_file());
            if !found {
                eprintln!("skipped: there is no {tool} (Debian: apt-get install xvfb xdotool imagemagick)");
                return None;
            }
        }
        let screen = format!("{}x{}x24", SIZE[0], SIZE[1]);
        let mut server = Command::new("Xvfb")
            .args(["-displayfd", "1", "-screen", "0", &screen, "-nolisten", "tcp"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let mut number = String::new();
        BufReader::new(server.stdout.take().unwrap()).read_line(&mut number).unwrap();
        Some(Self { server, name: format!(":{}", number.trim()) })
    }

    fn run(&self, program: &str, args: &[&str]) {
        let status = Command::new(program).args(args).env("DISPLAY", &self.name).status().unwrap();
        assert!(status.success(), "{program} {args:?}");
    }
}

impl Drop for Display {
    fn drop(&mut self) {
        let _ = self.server.kill();
        let _ = self.server.wait();
    }
}

/// The program in its window.
struct Window<'a> {
    display: &'a Display,
    program: Child,
    log: PathBuf,
    folder: PathBuf,
}

/// A place in the window [pixels]: left, top, right, bottom.
#[derive(Clone, Copy, Debug)]
struct Place([i32; 4]);

impl Place {
    fn at(self, x: f32, y: f32) -> [i32; 2] {
        let [left, top, right, bottom] = self.0;
        let between = |a: i32, b: i32, share: f32| a + ((b - a) as f32 * share).round() as i32;
        [between(left, right, x), between(top, bottom, y)]
    }
}

impl<'a> Window<'a> {
    fn open(display: &'a Display, scene: &Path) -> Self {
        let folder = scene.parent().unwrap().to_owned();
        let log = folder.join("log.txt");
        let file = std::fs::File::create(&log).unwrap();
        let program = Command::new(env!("CARGO_BIN_EXE_lightwell"))
            .args(["play", scene.to_str().unwrap(), "--size", &format!("{}x{}", SIZE[0], SIZE[1])])
            .current_dir(&folder)
            .env("DISPLAY", &display.name)
            .env("XDG_CONFIG_HOME", folder.join("config"))
            .env("RUST_LOG", "warn,lightwell::widgets=trace")
            .env("NODEVICE_SELECT", "1")
            .env_remove("WAYLAND_DISPLAY")
            .env_remove("WAYLAND_SOCKET")
            .stdout(Stdio::null())
            .stderr(file)
            .spawn()
            .unwrap();
        let window = Self { display, program, log, folder };
        window.wait_for("the picture", |all| all.iter().any(|(_, name)| name == "Picture"));
        window.xdotool(&["search", "--sync", "--name", "Lightwell", "windowfocus"]);
        // Still, at the start of the clock.
        window.key("space");
        window.key("Home");
        window.wait_for("a pause", |all| all.iter().any(|(_, name)| name.ends_with("Play")));
        window
    }

    fn xdotool(&self, args: &[&str]) {
        self.display.run("xdotool", args);
        std::thread::sleep(Duration::from_millis(300));
    }

    fn key(&self, key: &str) {
        self.xdotool(&["key", key]);
    }

    fn move_to(&self, [x, y]: [i32; 2]) {
        self.xdotool(&["mousemove", &x.to_string(), &y.to_string()]);
    }

    fn click(&self, at: [i32; 2]) {
        self.move_to(at);
        self.xdotool(&["click", "1"]);
    }

    fn drag(&self, [x, y]: [i32; 2], dx: i32) {
        self.move_to([x, y]);
        self.xdotool(&["mousedown", "1"]);
        for step in 1..=4 {
            self.move_to([x + dx * step / 4, y]);
        }
        self.xdotool(&["mouseup", "1"]);
    }

    /// All widgets with a name in the last whole frame.
    fn widgets(&self) -> Vec<(Place, String)> {
        let text = std::fs::read_to_string(&self.log).unwrap();
        let text = text.rsplit_once("TRACE] frame").map_or("", |(before, _)| before);
        let last = text.rsplit_once("TRACE] frame").map_or(text, |(_, last)| last);
        let widget = |line: &str| {
            let mut words = line.split_once("TRACE] ")?.1.splitn(6, ' ');
            let mut edge = || words.next()?.parse().ok();
            let place = Place([edge()?, edge()?, edge()?, edge()?]);
            Some((place, words.nth(1)?.to_owned()))
        };
        last.lines().filter_map(widget).collect()
    }

    fn wait_for(&self, what: &str, holds: impl Fn(&[(Place, String)]) -> bool) {
        let start = Instant::now();
        while !holds(&self.widgets()) {
            if start.elapsed() > PATIENCE {
                let log = std::fs::read_to_string(&self.log).unwrap();
                let other: Vec<&str> = log.lines().filter(|line| !line.contains("TRACE]")).collect();
                let names: Vec<String> = self.widgets().into_iter().map(|(_, name)| name).collect();
                panic!("{what} does not come; there are {names:?}; the program said {other:?}");
            }
            std::thread::sleep(Duration::from_millis(100));
        }
    }

    fn place(&self, name: &str) -> Place {
        self.wait_for(name, |all| all.iter().any(|(_, known)| known == name));
        self.widgets().into_iter().rev().find(|(_, known)| known == name).unwrap().0
    }

    /// The picture as the screen shows it.
    fn shot(&self) -> Image {
        let Place([left, top, right, bottom]) = self.place("Picture");
        let area = format!("{}x{}+{left}+{top}", right - left, bottom - top);
        let file = self.folder.join("screen.png");
        self.display.run("import", &["-window", "root", "-crop", &area, "+repage", file.to_str().unwrap()]);
        read_image(&file).unwrap()
    }

    /// The picture once it is as wanted and has stood still for some seconds; the last one if that never comes.
    fn picture(&self, is_wanted: impl Fn(&Image) -> bool) -> Image {
        let start = Instant::now();
        let (mut last, mut still) = (self.shot(), 0);
        while (still < 4 || !is_wanted(&last)) && start.elapsed() < PATIENCE {
            std::thread::sleep(Duration::from_millis(800));
            let now = self.shot();
            still = if now == last { still + 1 } else { 0 };
            last = now;
        }
        last
    }

    fn kill(mut self) {
        self.program.kill().unwrap();
        self.program.wait().unwrap();
    }
}

impl Drop for Window<'_> {
    fn drop(&mut self) {
        let _ = self.program.kill();
        let _ = self.program.wait();
    }
}

/// Mean difference of two pictures, over all pixels and channels.
fn difference(a: &Image, b: &Image) -> f64 {
    let sum: f64 = a.values().zip(b.values()).map(|(a, b)| f64::from(a - b).abs()).sum();
    sum / (3 * a.pixels().len()) as f64
}

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
    // Its name is in the tree too, but not unfolded there before.
    window.wait_for("the block in the inspector", |all| all.iter().any(|(_, name)| name == "Tall block"));
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
