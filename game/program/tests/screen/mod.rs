//! Programs in a real window on a display that nobody sees, driven as a person would.
//!
//! Needs `Xvfb`, `xdotool` and `import` (ImageMagick); without them the tests are ignored.

#![allow(dead_code, missing_docs, clippy::unwrap_used, reason = "each test takes what it needs")]

use lightwell::measure::{Image, read_image};
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use x11rb::connection::Connection;
use x11rb::protocol::xproto::{
    AtomEnum, CONFIGURE_NOTIFY_EVENT, ConfigureNotifyEvent, ConnectionExt, EventMask, PropMode,
};
use x11rb::wrapper::ConnectionExt as _;

pub const SIZE: [u32; 2] = [1280, 800];
/// Software drivers on busy machines take their time.
pub const PATIENCE: Duration = Duration::from_secs(90);

/// A display that nobody sees.
pub struct Display {
    server: Child,
    name: String,
}

impl Display {
    /// Opens it; fails where a tool is missing (Debian: apt-get install xvfb xdotool imagemagick).
    pub fn open() -> Self {
        let screen = format!("{}x{}x24", SIZE[0], SIZE[1]);
        let mut server = Command::new("Xvfb")
            .args(["-displayfd", "1", "-screen", "0", &screen, "-nolisten", "tcp"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let mut number = String::new();
        BufReader::new(server.stdout.take().unwrap()).read_line(&mut number).unwrap();
        Self { server, name: format!(":{}", number.trim()) }
    }

    /// Tells all windows of another density, as a desktop and its window manager do on another monitor.
    pub fn set_dots_per_inch(&self, value: u32) {
        let (connection, screen) = x11rb::connect(Some(&self.name)).unwrap();
        let root = connection.setup().roots[screen].root;
        let resources = format!("Xft.dpi:\t{value}\n");
        let windows = connection.query_tree(root).unwrap().reply().unwrap().children;
        // Programs read the root's, and hear of those of their own windows.
        for window in std::iter::once(root).chain(windows.iter().copied()) {
            let (property, kind) = (AtomEnum::RESOURCE_MANAGER, AtomEnum::STRING);
            let set = connection.change_property8(PropMode::REPLACE, window, property, kind, resources.as_bytes());
            set.unwrap().check().unwrap();
        }
        // Where the window is now.
        for window in windows {
            let place = connection.get_geometry(window).unwrap().reply().unwrap();
            let event = ConfigureNotifyEvent {
                response_type: CONFIGURE_NOTIFY_EVENT,
                sequence: 0,
                event: window,
                window,
                above_sibling: 0,
                x: place.x,
                y: place.y,
                width: place.width,
                height: place.height,
                border_width: 0,
                override_redirect: false,
            };
            connection.send_event(false, window, EventMask::STRUCTURE_NOTIFY, event).unwrap().check().unwrap();
        }
    }

    pub fn run(&self, program: &str, args: &[&str]) {
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
pub struct Window<'a> {
    display: &'a Display,
    program: Child,
    log: PathBuf,
    pub folder: PathBuf,
}

/// A place in the window [pixels]: left, top, right, bottom.
#[derive(Clone, Copy, Debug)]
pub struct Place(pub [i32; 4]);

impl Place {
    pub fn at(self, x: f32, y: f32) -> [i32; 2] {
        let [left, top, right, bottom] = self.0;
        let between = |a: i32, b: i32, share: f32| a + ((b - a) as f32 * share).round() as i32;
        [between(left, right, x), between(top, bottom, y)]
    }
}

impl<'a> Window<'a> {
    /// The editor of any program, still, at the start of the clock.
    pub fn open_editor(display: &'a Display, program: &Path, words: &[&str], folder: &Path) -> Self {
        let window = Self::start(display, program, words, folder);
        window.wait_for("the picture", |all| all.iter().any(|(_, name)| name == "Picture"));
        window.focus("Lightwell");
        window.key("space");
        window.key("Home");
        window.wait_for("a pause", |all| all.iter().any(|(_, name)| name.ends_with("Play")));
        window
    }

    /// A program in a folder of its own.
    pub fn start(display: &'a Display, program: &Path, words: &[&str], folder: &Path) -> Self {
        let log = folder.join("log.txt");
        let file = std::fs::File::create(&log).unwrap();
        let program = Command::new(program)
            .args(words)
            .args(["--size", &format!("{}x{}", SIZE[0], SIZE[1])])
            .current_dir(folder)
            .env("DISPLAY", &display.name)
            .env("XDG_CONFIG_HOME", folder.join("config"))
            .env("RUST_LOG", "warn,lightwell::widgets=trace,lightwell_game::app::window=info")
            .env("NODEVICE_SELECT", "1")
            .env_remove("WAYLAND_DISPLAY")
            .env_remove("WAYLAND_SOCKET")
            .stdout(Stdio::null())
            .stderr(file)
            .spawn()
            .unwrap();
        Self { display, program, log, folder: folder.to_owned() }
    }

    /// Waits for the window of that title, and gives it the keyboard.
    pub fn focus(&self, title: &str) {
        self.xdotool(&["search", "--sync", "--name", title, "windowfocus"]);
    }

    /// What the program said, without the places of its widgets.
    pub fn said(&self) -> String {
        let log = std::fs::read_to_string(&self.log).unwrap();
        log.lines().filter(|line| !line.contains("TRACE]")).collect::<Vec<_>>().join("\n")
    }

    /// The name of the widget that the keyboard writes to.
    pub fn focused(&self) -> Option<String> {
        let text = std::fs::read_to_string(&self.log).unwrap();
        let text = text.rsplit_once("TRACE] frame")?.0;
        let last = text.rsplit_once("TRACE] frame").map_or(text, |(_, last)| last);
        last.lines().find_map(|line| Some(line.split_once("TRACE] focus ")?.1.to_owned()))
    }

    /// Waits for the program to end by itself; whether it was content.
    pub fn wait_for_end(&mut self) -> bool {
        self.wait_for_end_within(PATIENCE)
    }

    /// The same, of one that takes its time.
    pub fn wait_for_end_within(&mut self, patience: Duration) -> bool {
        let start = Instant::now();
        loop {
            if let Some(status) = self.program.try_wait().unwrap() {
                return status.success();
            }
            assert!(start.elapsed() < patience, "it does not end; it said {}", self.said());
            std::thread::sleep(Duration::from_millis(100));
        }
    }

    /// The whole screen.
    pub fn screen(&self) -> Image {
        let file = self.folder.join("whole.png");
        self.display.run("import", &["-window", "root", file.to_str().unwrap()]);
        read_image(&file).unwrap()
    }

    /// The screen once it is as wanted; the last one if that never comes.
    pub fn screen_until(&self, is_wanted: impl Fn(&Image) -> bool) -> Image {
        let start = Instant::now();
        loop {
            let now = self.screen();
            if is_wanted(&now) || start.elapsed() > PATIENCE {
                return now;
            }
            std::thread::sleep(Duration::from_millis(300));
        }
    }

    /// Keeps an image of the screen to look at, if `LIGHTWELL_TEST_PICTURES` names a folder.
    pub fn keep(&self, name: &str) {
        let Some(folder) = std::env::var_os("LIGHTWELL_TEST_PICTURES").map(PathBuf::from) else { return };
        std::fs::create_dir_all(&folder).unwrap();
        let file = folder.join(format!("{name}.png"));
        self.display.run("import", &["-window", "root", file.to_str().unwrap()]);
    }

    pub fn xdotool(&self, args: &[&str]) {
        self.display.run("xdotool", args);
        std::thread::sleep(Duration::from_millis(300));
    }

    pub fn key(&self, key: &str) {
        self.xdotool(&["key", key]);
    }

    pub fn move_to(&self, [x, y]: [i32; 2]) {
        self.xdotool(&["mousemove", &x.to_string(), &y.to_string()]);
    }

    pub fn click(&self, at: [i32; 2]) {
        self.move_to(at);
        self.xdotool(&["click", "1"]);
    }

    pub fn drag(&self, [x, y]: [i32; 2], dx: i32) {
        self.move_to([x, y]);
        self.xdotool(&["mousedown", "1"]);
        for step in 1..=4 {
            self.move_to([x + dx * step / 4, y]);
        }
        self.xdotool(&["mouseup", "1"]);
    }

    /// All widgets with a name in the last whole frame.
    pub fn widgets(&self) -> Vec<(Place, String)> {
        let text = std::fs::read_to_string(&self.log).unwrap();
        let text = text.rsplit_once("TRACE] frame").map_or("", |(before, _)| before);
        let last = text.rsplit_once("TRACE] frame").map_or(text, |(_, last)| last);
        let widget = |line: &str| {
            let mut words = line.split_once("TRACE] ")?.1.splitn(6, ' ');
            let mut edge = || words.next()?.parse().ok();
            let place = Place([edge()?, edge()?, edge()?, edge()?]);
            let is_text = ["Label", "TextRun"].contains(&words.next()?);
            Some((!is_text, (place, words.next()?.to_owned())))
        };
        let mut all: Vec<_> = last.lines().filter_map(widget).collect();
        // What can be clicked comes after the text beside it, which may say the same.
        all.sort_by_key(|(is_active, _)| *is_active);
        all.into_iter().map(|(_, widget)| widget).collect()
    }

    pub fn wait_for(&self, what: &str, holds: impl Fn(&[(Place, String)]) -> bool) {
        let start = Instant::now();
        while !holds(&self.widgets()) {
            if start.elapsed() > PATIENCE {
                let names: Vec<String> = self.widgets().into_iter().map(|(_, name)| name).collect();
                panic!("{what} does not come; there are {names:?}; the program said {}", self.said());
            }
            std::thread::sleep(Duration::from_millis(100));
        }
    }

    pub fn place(&self, name: &str) -> Place {
        self.wait_for(name, |all| all.iter().any(|(_, known)| known == name));
        self.widgets().into_iter().rev().find(|(_, known)| known == name).unwrap().0
    }

    /// The image as the screen shows it.
    pub fn shot(&self) -> Image {
        let Place([left, top, right, bottom]) = self.place("Picture");
        let area = format!("{}x{}+{left}+{top}", right - left, bottom - top);
        let file = self.folder.join("screen.png");
        self.display.run("import", &["-window", "root", "-crop", &area, "+repage", file.to_str().unwrap()]);
        read_image(&file).unwrap()
    }

    /// The image once it is as wanted and has stood still for some seconds; the last one if that never comes.
    pub fn picture(&self, is_wanted: impl Fn(&Image) -> bool) -> Image {
        let start = Instant::now();
        let (mut last, mut still) = (self.shot(), 0);
        while (still < 4 || !is_wanted(&last)) && start.elapsed() < PATIENCE {
            std::thread::sleep(Duration::from_millis(800));
            let now = self.shot();
            // An image that is being drawn is not that of the last change.
            let is_busy = self.widgets().iter().any(|(_, name)| name.starts_with("drawing"));
            still = if now == last && !is_busy { still + 1 } else { 0 };
            last = now;
        }
        last
    }

    pub fn kill(mut self) {
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

/// Mean difference of two images, over all pixels and channels.
pub fn difference(a: &Image, b: &Image) -> f64 {
    let sum: f64 = a.values().zip(b.values()).map(|(a, b)| f64::from(a - b).abs()).sum();
    sum / (3 * a.pixels().len()) as f64
}
