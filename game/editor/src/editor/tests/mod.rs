//! Tests that click: the whole editor without window and device, driven through what a screen reader would see.

#![allow(clippy::unwrap_used)]

mod custom_component;
mod custom_method;
mod details;
mod dialogs;
mod edit;
mod export;
mod handles;
mod keyboard;
mod keyed;
mod model;
mod panels;
mod play;
mod reload;
mod save;
mod tree;

use super::Editor;
use super::camera::FlyCamera;
use super::clock::PlayClock;
use super::console::Record;
use super::layout::Pane;
use super::stage::{Facts, PlayFacts, PlayRequest, Request, Stage, Working};
use crate::comparison::{Comparison, LiveError};
use crate::play::playing::{End, NewGame, Playing, plain};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use lightwell::assets::AssetLibrary;
use lightwell::files::{LoadOptions, load_scene, save_scene};
use lightwell::graph::FrameReport;
use lightwell::profile::Profiler;
use lightwell::render::{DisplaySettings, MethodInfo};
use lightwell::scene::{Extractor, Scene, SceneId};
use lightwell::world::{GameWorld, SceneSettings};
use lightwell_runtime::cli::{LookArgs, built_in_methods};
use lightwell_runtime::session::Files;
use std::path::{Path, PathBuf};
use std::rc::Rc;

/// What a window has, without the window.
struct Desk {
    editor: Editor,
    world: GameWorld,
    extractor: Extractor,
    scene: Scene,
    library: AssetLibrary,
    options: LoadOptions,
    path: PathBuf,
    look: LookArgs,
    methods: Vec<MethodInfo>,
    display: DisplaySettings,
    comparison: Comparison,
    live_error: Option<LiveError>,
    clock: PlayClock,
    camera: FlyCamera,
    report: FrameReport,
    profiler: Profiler,
    errors: Vec<String>,
    log: Vec<Record>,
    requests: Vec<Request>,
    working: Working,
    budget: Option<String>,
    new_game: NewGame,
    playing: Option<Playing>,
}

const SCENE: &str = r#"Scene(
    settings: (duration: 4),
    materials: { "red": (color: (0.6, 0.05, 0.05), specular: 0) },
    entities: [
        (name: "Camera", transform: (translation: (0, 1, 5)), camera: (fov: 45, primary: true)),
        (name: "Lamp", transform: (translation: (0, 3, 0)), light: (kind: Point, color: (1, 0.95, 0.85), intensity: 20)),
        (
            name: "Group",
            transform: (rotation: (0, 90, 0)),
            children: [
                (name: "Ball", transform: (translation: (1, 0.5, 0)), mesh: Sphere(radius: 0.5), material: "red"),
                (name: "Cube", transform: (translation: (-1, 0.5, 0)), mesh: Box(size: (1, 1, 1))),
            ],
        ),
        (
            name: "Mover",
            mesh: Box(),
            animation: (tracks: [
                Keys(target: Translation, keys: [(0, (0, 0, 0)), (4, (4, 0, 0))], wrap: Once),
            ]),
        ),
    ],
)
"#;

impl Desk {
    fn new(path: &Path) -> Self {
        Self::with_options(path, LoadOptions::default())
    }

    fn with_options(path: &Path, options: LoadOptions) -> Self {
        let mut library = AssetLibrary::new();
        let world = load_scene(path, &mut library, &options).unwrap();
        let settings = world.ecs.resource::<SceneSettings>().clone();
        let mut desk = Self {
            editor: Editor::default(),
            world,
            extractor: Extractor::new(),
            scene: Scene::default(),
            library,
            options,
            path: path.to_owned(),
            look: LookArgs::default(),
            methods: built_in_methods(),
            display: DisplaySettings::default(),
            comparison: Comparison::default(),
            live_error: None,
            clock: PlayClock::new(&settings),
            camera: FlyCamera::default(),
            report: FrameReport::default(),
            profiler: Profiler::new(),
            errors: Vec::new(),
            log: Vec::new(),
            requests: Vec::new(),
            working: Working::default(),
            budget: None,
            new_game: Rc::new(|| Ok(plain(&LoadOptions::default()))),
            playing: None,
        };
        desk.clock.playing = false;
        desk.update();
        desk
    }

    fn update(&mut self) {
        if let Some(playing) = &mut self.playing {
            let world = &mut playing.game_mut().world;
            world.update();
            return self.extractor.extract(world, &mut self.scene);
        }
        self.world.set_tick(self.clock.ticks());
        self.world.update();
        self.extractor.extract(&mut self.world, &mut self.scene);
    }

    fn show(&mut self, ui: &mut egui::Ui) {
        let requests = self.with_stage(|editor, stage| editor.show(ui, stage));
        for request in requests {
            match request {
                Request::Play(request) => self.play(request),
                other => self.requests.push(other),
            }
        }
        self.update();
    }

    /// Does with a game what the window does.
    fn play(&mut self, request: PlayRequest) {
        match (request, &mut self.playing) {
            (PlayRequest::Begin, None) => self.begin_play(),
            (PlayRequest::Stop, Some(_)) => self.end_play(),
            (PlayRequest::Pause(paused), Some(playing)) => {
                playing.paused = paused;
                self.editor.view.takes_input = !paused;
            }
            (PlayRequest::Step, Some(playing)) => {
                playing.step_once();
                self.pass(0.0);
            }
            (PlayRequest::Apply(edits), Some(_)) => {
                let playing = self.playing.take();
                let result = self.with_stage(|editor, stage| editor.apply_to_scene(stage, &edits));
                self.playing = playing;
                self.editor.told(result);
            }
            other => panic!("{:?} does not fit", other.0),
        }
    }

    fn begin_play(&mut self) {
        self.editor.begin_play(&mut self.world).unwrap();
        self.extractor = Extractor::new();
        match Playing::begin(&self.new_game, &self.world, &self.library, &self.path) {
            Ok(playing) => self.playing = Some(playing),
            Err(error) => {
                self.editor.end_play();
                self.editor.tell(format!("cannot play: {error:#}"), true);
            }
        }
    }

    fn end_play(&mut self) {
        self.playing = None;
        self.extractor = Extractor::new();
        self.editor.end_play();
    }

    /// Lets time pass in a game \[s\]; gives why it has ended, if it has.
    fn pass(&mut self, seconds: f64) -> Option<End> {
        let playing = self.playing.as_mut().unwrap();
        let end = playing.advance(seconds, Vec::new(), egui::RawInput::default(), |_| {}).end;
        if end.is_some() {
            self.end_play();
        }
        end
    }

    fn with_stage<T>(&mut self, work: impl FnOnce(&mut Editor, &mut Stage) -> T) -> T {
        let scene_camera = self.scene.cameras.first().cloned();
        let trouble = self.playing.as_ref().and_then(Playing::trouble).map(str::to_owned);
        let resting = Files { library: &mut self.library, options: &self.options, path: &self.path };
        let (world, files, playing) = match &mut self.playing {
            None => (&mut self.world, resting, None),
            Some(playing) => {
                let time = playing.time();
                let facts = PlayFacts {
                    paused: playing.paused,
                    step: time.step,
                    seconds: time.elapsed,
                    trouble: trouble.as_deref(),
                    overlay: None,
                    edited: playing.is_in_edited_scene().then_some((&self.world, self.path.as_path())),
                };
                let (world, files) = playing.parts();
                (world, files, Some(facts))
            }
        };
        let mut stage = Stage {
            world,
            files,
            look: &mut self.look,
            display: &mut self.display,
            comparison: &mut self.comparison,
            clock: &mut self.clock,
            camera: &mut self.camera,
            facts: Facts {
                name: "test",
                scene: &self.scene,
                methods: &self.methods,
                report: &self.report,
                profiler: &self.profiler,
                errors: &self.errors,
                log: &self.log,
                scene_camera,
                image: None,
                image_size: [640, 400],
                tracing: None,
                live_error: self.live_error,
                adapter: "none",
                working: self.working,
                budget: self.budget.clone(),
                playing,
            },
        };
        work(&mut self.editor, &mut stage)
    }

    fn id(&self, path: &str) -> SceneId {
        self.world.id(self.world.find(path).unwrap_or_else(|| panic!("there is no {path}"))).unwrap()
    }

    fn select(&mut self, path: &str) {
        let id = self.id(path);
        self.editor.select_only(id);
    }

    fn text(&self) -> String {
        let file = tempfile::Builder::new().suffix(".scene.ron").tempfile().unwrap();
        save_scene(&self.world, file.path()).unwrap();
        std::fs::read_to_string(file.path()).unwrap()
    }
}

type Bench = Harness<'static, Desk>;

/// The editor with the test scene, in a folder of its own.
fn bench() -> (Bench, tempfile::TempDir) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("test.scene.ron");
    std::fs::write(&path, SCENE).unwrap();
    (bench_of(&path), folder)
}

fn bench_of(path: &Path) -> Bench {
    let desk = Desk::new(path);
    let builder = Harness::builder().with_size([1400.0, 900.0]).with_max_steps(12).with_context_setup(super::set_fonts);
    let mut harness = builder.build_ui_state(|ui, desk: &mut Desk| desk.show(ui), desk);
    harness.run_steps(3);
    harness
}

/// What bears a name, and not the text beside it.
fn find<'a>(bench: &'a Bench, label: &'a str) -> egui_kittest::Node<'a> {
    let all: Vec<_> = bench.query_all_by_label(label).collect();
    let position = all.iter().rposition(|node| node.accesskit_node().role() != egui::accesskit::Role::Label);
    let index = position.unwrap_or_else(|| panic!("there is nothing named `{label}` but {} texts", all.len()));
    all.into_iter().nth(index).unwrap()
}

fn place_of(bench: &Bench, label: &str) -> egui::Pos2 {
    find(bench, label).rect().center()
}

/// Clicks on what bears a name.
fn click(bench: &mut Bench, label: &str) {
    find(bench, label).click();
    bench.run_steps(3);
}

fn press(bench: &mut Bench, modifiers: egui::Modifiers, key: egui::Key) {
    bench.key_press_modifiers(modifiers, key);
    bench.run_steps(3);
}

/// Drags from one point to another in some steps.
fn drag(bench: &mut Bench, from: egui::Pos2, to: egui::Pos2) {
    bench.hover_at(from);
    bench.run_steps(1);
    bench.drag_at(from);
    bench.run_steps(1);
    for step in 1..=4 {
        bench.hover_at(from + (to - from) * step as f32 / 4.0);
        bench.run_steps(1);
    }
    bench.drop_at(to);
    bench.run_steps(3);
}

/// Brings a panel to the front.
fn open(bench: &mut Bench, pane: Pane) {
    bench.state_mut().editor.layout.focus(pane);
    bench.run_steps(3);
}
