//! A game of one's own: components, systems and a scene, in a window or without one.
//!
//! ```no_run
//! use lightwell_game::prelude::*;
//!
//! /// Turns about the y axis.
//! #[derive(Component, SceneData, Clone, Default)]
//! struct Spinner {
//!     /// Speed \[degrees/s\], -720 to 720.
//!     speed: f32,
//! }
//!
//! fn spin(time: Res<Time>, mut spinners: Query<(&Spinner, &mut Transform)>) {
//!     for (spinner, mut transform) in &mut spinners {
//!         transform.rotation *= Quat::from_rotation_y(spinner.speed.to_radians() * time.delta);
//!     }
//! }
//!
//! fn app() -> App {
//!     App::new("mill.scene.ron").component::<Spinner>().systems(FixedUpdate, spin)
//! }
//!
//! fn main() -> std::process::ExitCode {
//!     lightwell_game::run(app)
//! }
//! ```
//!
//! [`run`] takes a command line: `--edit` (with the feature `editor`) opens the scene in the editor, where `Spinner` is a
//! component like any other and Play runs the game; `--record FILE` keeps what the player does, and `--headless --script FILE` plays it again without a window.

mod args;
mod canvas;
mod files;
mod headless;
mod hud;
#[cfg(feature = "editor")]
mod in_editor;
#[cfg(test)]
mod method_tests;
#[cfg(feature = "gamepad")]
mod pads;
mod player;
mod reload;
mod sounds;
#[cfg(feature = "sound")]
mod speaker;
mod window;

pub use args::GameArgs;
pub use headless::{Outcome, Pictures};
pub use hud::Hud;
pub use sounds::Sounds;

#[cfg(not(feature = "editor"))]
use anyhow::bail;
use anyhow::{Context, Result};
use bevy_ecs::message::Message;
use bevy_ecs::observer::IntoObserver;
use bevy_ecs::prelude::{Component, IntoScheduleConfigs, Resource};
use bevy_ecs::schedule::ScheduleLabel;
use bevy_ecs::system::ScheduleSystem;
use clap::{CommandFactory, FromArgMatches};
use lightwell::files::{ComponentTypes, SceneData};
use lightwell::game::{Actions, Game, GameError, InputScript, LightProbe, NonSolid, Persistent, Update};
use lightwell::graph::{Graph, Handle, Texture};
use lightwell::render::{IndirectMethod, Picture};
#[cfg(feature = "editor")]
use lightwell_editor::{CustomComponent, Display, EditedGame, Opening};
use lightwell_runtime::cli::{Common, built_in_methods, method_parser};
use lightwell_runtime::session::{self, CustomMethods, RenderState};
use lightwell_runtime::window::has_display;
use lightwell_runtime::{logging, scene_path, set};
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::rc::Rc;

/// Adds a pass to what draws the game.
type CustomPassAdder = Box<dyn Fn(&mut RenderState)>;

/// Runs a game as the program's command line says, in a window if there is a display; prints an error. The editor calls
/// `app` for each play, so that every play begins with a new game.
pub fn run(app: impl Fn() -> App + 'static) -> ExitCode {
    run_with(app, std::env::args_os())
}

/// The same with a command line of one's own; the first word is the program's name.
pub fn run_with(
    app: impl Fn() -> App + 'static,
    words: impl IntoIterator<Item = impl Into<OsString> + Clone>,
) -> ExitCode {
    let first = app();
    first.run_again(Some(Rc::new(app)), words)
}

/// A game: what it is made of, until it runs.
///
/// What is wrong with the parts (two types of one name, a table of actions with a mistake) is told when it runs.
pub struct App {
    game: Game,
    scene: String,
    actions: Option<String>,
    title: Option<String>,
    #[cfg(feature = "editor")]
    shown: Vec<CustomComponent>,
    passes: Vec<CustomPassAdder>,
    methods: CustomMethods,
    fault: Option<GameError>,
}

impl App {
    /// A game that begins with a scene: a `.scene.ron` file, or the name of one in a folder `scenes`.
    pub fn new(scene: impl Into<String>) -> Self {
        let mut game = Game::new();
        game.world.ecs.init_resource::<Hud>();
        game.world.ecs.init_resource::<Sounds>();
        game.add_systems(Update, hud::show_trouble);
        let app = Self {
            game,
            scene: scene.into(),
            actions: None,
            title: None,
            #[cfg(feature = "editor")]
            shown: Vec::new(),
            passes: Vec::new(),
            methods: CustomMethods::default(),
            fault: None,
        };
        app.show::<NonSolid>().show::<LightProbe>().show::<Persistent>()
    }

    fn try_to(mut self, work: impl FnOnce(&mut Game) -> Result<(), GameError>) -> Self {
        if let Err(error) = work(&mut self.game) {
            self.fault.get_or_insert(error);
        }
        self
    }

    /// Adds a component that scenes can hold and the editor shows.
    pub fn component<C: Component + SceneData + Clone + Default>(self) -> Self {
        self.show::<C>().try_to(|game| game.add_component::<C>())
    }

    /// Has the editor show a component in its inspector.
    #[cfg(feature = "editor")]
    fn show<C: SceneData>(mut self) -> Self {
        self.shown.push(CustomComponent::of::<C>());
        self
    }

    /// There is no editor.
    #[cfg(not(feature = "editor"))]
    fn show<C: SceneData>(self) -> Self {
        self
    }

    /// Adds systems to [`OnSceneEnter`](lightwell::game::OnSceneEnter), [`FixedUpdate`](lightwell::game::FixedUpdate) or [`Update`].
    pub fn systems<M>(
        mut self,
        label: impl ScheduleLabel,
        systems: impl IntoScheduleConfigs<ScheduleSystem, M>,
    ) -> Self {
        self.game.add_systems(label, systems);
        self
    }

    /// Adds a resource.
    pub fn resource(mut self, resource: impl Resource) -> Self {
        self.game.world.ecs.insert_resource(resource);
        self
    }

    /// Adds a resource that is saved with the game.
    pub fn saved_resource<R: Resource + SceneData>(self, resource: R) -> Self {
        self.try_to(|game| game.add_saved_resource(resource))
    }

    /// Adds a message that systems send to each other.
    pub fn message<M: Message>(mut self) -> Self {
        self.game.add_message::<M>();
        self
    }

    /// Adds an observer of an event.
    pub fn observer<M>(mut self, observer: impl IntoObserver<M>) -> Self {
        self.game.add_observer(observer);
        self
    }

    /// Sets the file that says what buttons and sticks mean; its path is relative to the first scene's folder.
    pub fn actions(mut self, path: impl Into<String>) -> Self {
        self.actions = Some(path.into());
        self
    }

    /// Adds a render pass, which is declared by a function and whose shader has a name and a text, as `docs/frame.md`
    /// explains. `pass` is added to every renderer of the game.
    pub fn pass<F>(mut self, shader: &'static str, source: &'static str, pass: F) -> Self
    where
        F: Fn(&mut Graph<'_>, &Picture<'_>) -> Handle<Texture> + Send + Sync + Clone + 'static,
    {
        self.passes.push(Box::new(move |rendering| {
            rendering.gpu.shaders.add(shader, source);
            rendering.renderer.add_pass(pass.clone());
        }));
        self
    }

    /// Adds a method of indirect light, which `method` makes for every renderer of the game. Scene files choose it by
    /// `gi: ConstantAmbient` and the command line by `--gi constant-ambient`, if its name is `constant-ambient`; the editor lists
    /// it by its title. `docs/frame.md` explains what a method is, and the example `custom_method` has one.
    pub fn method<M: IndirectMethod>(mut self, method: impl Fn() -> M + Send + Sync + Clone + 'static) -> Self {
        let info = self.methods.add(method.clone());
        self.game.add_method(info.id);
        self.passes.push(Box::new(move |rendering| rendering.add_method(Box::new(method()))));
        self
    }

    /// Adds a component that is the settings of a method of indirect light: scenes can hold it, the editor shows it, and the
    /// method finds the first one of the scene in `frame.scene.method_settings`.
    pub fn method_settings<S: Component + SceneData + Clone + Default + PartialEq>(self) -> Self {
        self.show::<S>().try_to(|game| game.add_method_settings::<S>())
    }

    /// Sets the window's title; else it is the scene's name.
    pub fn title(mut self, title: impl Into<String>) -> Self {
        self.title = Some(title.into());
        self
    }

    /// Sets the number of steps a second, 60 if not said.
    pub fn steps_a_second(mut self, rate: u32) -> Self {
        self.game.set_rate(rate);
        self
    }

    /// Runs the game as [`run`] does. The editor plays it once: it has this one alone.
    pub fn run(self) -> ExitCode {
        self.run_with(std::env::args_os())
    }

    /// The same with a command line of one's own; the first word is the program's name.
    pub fn run_with(self, words: impl IntoIterator<Item = impl Into<OsString> + Clone>) -> ExitCode {
        self.run_again(None, words)
    }

    fn run_again(
        self,
        again: Option<Rc<dyn Fn() -> App>>,
        words: impl IntoIterator<Item = impl Into<OsString> + Clone>,
    ) -> ExitCode {
        let matches = self.command().get_matches_from(words);
        let args = match GameArgs::from_arg_matches(&matches) {
            Ok(args) => args,
            Err(error) => error.exit(),
        };
        logging::start(args.common.verbose);
        match self.run_args(&args, again) {
            Ok(()) => ExitCode::SUCCESS,
            Err(error) => {
                eprintln!("error: {error:#}");
                ExitCode::from(1)
            }
        }
    }

    /// The command line, which knows the game's methods of indirect light.
    fn command(&self) -> clap::Command {
        let methods = built_in_methods().into_iter().chain(self.methods.list()).collect();
        GameArgs::command().about(self.name()).mut_arg("gi", |gi| gi.value_parser(method_parser(methods)))
    }

    fn run_args(self, args: &GameArgs, again: Option<Rc<dyn Fn() -> App>>) -> Result<()> {
        if args.edit {
            return self.edit(args, again);
        }
        let script = args.script.as_deref().map(InputScript::read).transpose()?;
        if args.list_files {
            return files::print(self, args, script);
        }
        if args.headless || !has_display() {
            return headless::run_args(self, args, script);
        }
        window::run(self, args, script)
    }

    #[cfg(feature = "editor")]
    fn edit(mut self, args: &GameArgs, again: Option<in_editor::Again>) -> Result<()> {
        if let Some(fault) = self.fault {
            return Err(fault.into());
        }
        let scene = args.scene.clone().unwrap_or_else(|| self.scene.clone());
        scene_path::find(&scene)?;
        let (size, scale, look) = (args.size, args.scale, args.look());
        let opening = Opening { scene, size, scale, frames_per_second: args.fps, look, measure: None };
        let (types, shown) = (self.game.options().types.clone(), std::mem::take(&mut self.shown));
        let methods = self.methods.clone();
        let game = EditedGame { types, shown, methods, new_game: Some(in_editor::new_game(self, again, &args.common)) };
        Display::open().context("the editor needs a display")?.edit(&opening, &args.common, &game)
    }

    #[cfg(not(feature = "editor"))]
    fn edit(self, _: &GameArgs, _: Option<Rc<dyn Fn() -> App>>) -> Result<()> {
        bail!(
            "--edit: this game was built without the editor; build it with\n    \
             cargo run --release --features lightwell-game/editor -- --edit"
        )
    }

    fn name(&self) -> String {
        self.title.clone().unwrap_or_else(|| scene_path::name_of(Path::new(&self.scene)))
    }

    /// Enters the first scene.
    ///
    /// # Errors
    /// If a part of the game is faulty, or the scene cannot be loaded.
    pub fn start(self) -> Result<Game> {
        self.start_with(None, &[], &Common::default())
    }

    /// The game before its first scene, with its actions, and with the options of a command line.
    fn prepare(mut self, common: &Common) -> Result<Game> {
        if let Some(path) = self.actions_path()? {
            self.game.set_actions(Actions::read(&path)?);
        }
        if let Some(fault) = self.fault {
            return Err(fault.into());
        }
        let options = common.load_options(ComponentTypes::default());
        self.game.set_models(options.models);
        self.game.set_trusted(options.trusted);
        self.game.set_budget(options.budget);
        Ok(self.game)
    }

    fn start_with(self, scene: Option<&str>, sets: &[(String, String)], common: &Common) -> Result<Game> {
        let scene = scene.unwrap_or(&self.scene).to_owned();
        let mut game = self.prepare(common)?;
        let scene = scene_path::find(&scene)?;
        let (first, sets) = (scene.clone(), sets.to_vec());
        // The first scene, whenever it is entered again.
        game.on_entering(move |world, path| match path == first {
            true => set::apply_all(world, &sets).map_err(|error| error.to_string()),
            false => Ok(()),
        });
        game.enter(&scene)?;
        Ok(game)
    }

    /// The file of the table of actions.
    fn actions_path(&self) -> Result<Option<PathBuf>> {
        let Some(actions) = &self.actions else { return Ok(None) };
        let first = scene_path::find(&self.scene)?;
        Ok(Some(first.parent().unwrap_or(Path::new("")).join(actions)))
    }

    /// Plays a script without window and device: for tests of a game's rules.
    ///
    /// # Errors
    /// If the game cannot begin, or a system fails.
    pub fn simulate(self, script: &InputScript) -> Result<Game> {
        let mut game = self.start()?;
        for step in 1..=script.steps {
            let place = || format!("step {step}");
            game.step(&script.at(step)).with_context(place)?;
            let delta = 1.0 / game.world.ecs.resource::<lightwell::game::Time>().rate as f32;
            Hud::pass(&mut game, None, |game| game.frame(delta)).0.with_context(place)?;
            game.world.ecs.resource_mut::<Sounds>().take();
            if game.has_ended() {
                break;
            }
        }
        Ok(game)
    }

    /// The files that the game loads until a script is through: its first scene, then the table of actions, other scenes,
    /// prefabs, models with their buffers, images, and sounds. Those of `also`, and what they name, are loaded besides.
    ///
    /// # Errors
    /// If the game cannot begin, a system fails, or a file is missing or faulty.
    pub fn files(self, script: &InputScript, also: &[PathBuf]) -> Result<Vec<PathBuf>> {
        files::list(self, None, script, also, &Common::default())
    }

    /// Plays a script without a window, with images.
    ///
    /// # Errors
    /// As [`App::simulate`], and if there is no device or a frame cannot be drawn.
    pub fn headless(mut self, script: &InputScript, pictures: &Pictures) -> Result<Outcome> {
        let common = Common::default();
        let gpu = session::open_gpu(&common)?;
        let passes = std::mem::take(&mut self.passes);
        headless::play(self.start()?, gpu, &passes, script, pictures)
    }
}

/// Where a game without a display writes its images.
fn default_folder(name: &str) -> PathBuf {
    Path::new("out").join(name)
}

#[cfg(all(test, not(feature = "editor")))]
mod tests {
    use super::*;
    use clap::Parser;

    #[test]
    fn without_the_editor_edit_says_how_to_get_it() {
        let result = App::new("a.scene.ron").run_args(&GameArgs::parse_from(["game", "--edit"]), None);
        let message = result.err().map(|error| error.to_string()).unwrap_or_default();
        assert!(message.contains("--features lightwell-game/editor"), "{message}");
    }
}
