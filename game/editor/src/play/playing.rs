//! A game that plays in the editor: the game's systems on a copy of the edited scene.
//!
//! ```text
//! edited world ── EditedScene ──▶ world of the game ── steps, Update ──▶ view, hierarchy, inspector
//!      ▲                               │
//!      └──────── "Apply to scene" ─────┘        Stop drops the game; the edited world was never touched
//! ```

use anyhow::{Context, Result};
use egui::{FullOutput, RawInput};
use lightwell::assets::AssetLibrary;
use lightwell::files::LoadOptions;
use lightwell::game::{CurrentScene, EditedScene, Game, GameError, InputEvent, Time};
use lightwell::world::GameWorld;
use lightwell_runtime::session::{Files, RenderState};
use lightwell_runtime::steps::StepClock;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::rc::Rc;

/// A game that an editor plays.
pub trait PlayedGame {
    /// The game.
    fn game(&self) -> &Game;

    /// The game, to be changed.
    fn game_mut(&mut self) -> &mut Game;

    /// Input of devices that the window does not tell of, such as gamepads.
    fn device_events(&mut self) -> Vec<InputEvent> {
        Vec::new()
    }

    /// Runs `Update`, so many seconds after the frame before; gives what the game draws over the view.
    fn frame(&mut self, delta: f32, input: RawInput) -> (Result<(), GameError>, Option<Overlay>);

    /// Adds the game's own passes to what draws it.
    fn add_passes(&self, _rendering: &mut RenderState) {}
}

/// What a game draws over the view.
pub struct Overlay {
    /// egui of the game.
    pub context: egui::Context,
    /// What a pass of it made.
    pub output: FullOutput,
}

/// Makes a game that has entered no scene yet. Each play begins with a new one.
pub type NewGame = Rc<dyn Fn() -> Result<Box<dyn PlayedGame>>>;

/// A game without systems: the engine plays what it does by itself, such as animation.
pub fn plain(options: &LoadOptions) -> Box<dyn PlayedGame> {
    let mut game = Game::new();
    game.set_models(options.models.clone());
    game.set_trusted(options.trusted.clone());
    game.set_budget(options.budget.clone());
    game.allow_unknown_components();
    Box::new(Plain(game))
}

struct Plain(Game);

impl PlayedGame for Plain {
    fn game(&self) -> &Game {
        &self.0
    }

    fn game_mut(&mut self) -> &mut Game {
        &mut self.0
    }

    fn frame(&mut self, delta: f32, _: RawInput) -> (Result<(), GameError>, Option<Overlay>) {
        (self.0.frame(delta), None)
    }
}

/// What came of letting time pass.
#[derive(Default)]
pub struct Passed {
    /// Whether anything ran.
    pub ran: bool,
    /// What the game draws over the view, if it was drawn anew.
    pub overlay: Option<Overlay>,
    /// Why the game cannot go on, or that it has ended: it is to be stopped.
    pub end: Option<End>,
}

/// Why a game ends by itself.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum End {
    /// A system asked for it.
    Quit,
    /// A system panicked, with that message. The game's world may be half changed.
    Panic(String),
}

/// A game that plays.
pub struct Playing {
    played: Box<dyn PlayedGame>,
    /// Whether time stands still.
    pub paused: bool,
    clock: StepClock,
    /// Steps that were asked for one by one.
    asked: u64,
    /// What systems failed with last.
    trouble: Option<String>,
    /// The scene that is edited, and the one that plays.
    edited: PathBuf,
    path: PathBuf,
}

impl Playing {
    /// Begins to play a copy of an edited world, which is left as it is.
    ///
    /// # Errors
    /// If there is no game, the world holds something that no scene file can say, or the game does not take the scene.
    pub fn begin(new: &NewGame, world: &GameWorld, library: &AssetLibrary, path: &Path) -> Result<Self> {
        let scene = EditedScene::of(world, path).context("the scene cannot be copied")?;
        let begun = guarded(|| {
            let mut played = new()?;
            let game = played.game_mut();
            game.set_edited(scene, library.clone());
            let trouble = match game.enter(path) {
                Err(error @ GameError::Failed(_)) => Some(error.to_string()),
                result => result.map(|()| None)?,
            };
            Ok((played, trouble))
        });
        let (played, trouble) = begun.unwrap_or_else(|message| Err(anyhow::anyhow!("a system panicked: {message}")))?;
        let (edited, path) = (path.to_owned(), path.to_owned());
        let clock = StepClock::default();
        let mut playing = Self { played, paused: false, clock, asked: 0, trouble: None, edited, path };
        playing.tell(trouble);
        Ok(playing)
    }

    /// The game.
    pub fn game(&self) -> &Game {
        self.played.game()
    }

    /// The game, to be changed.
    pub fn game_mut(&mut self) -> &mut Game {
        self.played.game_mut()
    }

    /// What plays.
    pub fn played(&self) -> &dyn PlayedGame {
        &*self.played
    }

    /// The world that plays, and its files.
    pub fn parts(&mut self) -> (&mut GameWorld, Files<'_>) {
        let (world, library, options) = self.played.game_mut().parts();
        (world, Files { library, options, path: &self.path })
    }

    /// Whether it is in the scene that is edited, and in no other one that the game went to.
    pub fn is_in_edited_scene(&self) -> bool {
        self.path == self.edited
    }

    /// What systems failed with last.
    pub fn trouble(&self) -> Option<&str> {
        self.trouble.as_deref()
    }

    /// The time of the game.
    pub fn time(&self) -> Time {
        *self.game().world.ecs.resource::<Time>()
    }

    /// Pauses, and has one step pass.
    pub fn step_once(&mut self) {
        self.paused = true;
        self.asked += 1;
    }

    /// Lets wall time pass \[s\], with what the player did meanwhile: the steps that are due, and `Update`. `follow` is
    /// told of the world after each, since what was removed is known for two steps alone.
    pub fn advance(
        &mut self,
        elapsed: f64,
        mut events: Vec<InputEvent>,
        input: RawInput,
        mut follow: impl FnMut(&mut GameWorld),
    ) -> Passed {
        let rate = self.time().rate;
        let asked = std::mem::take(&mut self.asked);
        let due = if self.paused { asked } else { self.clock.due(elapsed, rate) };
        if self.paused && due == 0 {
            return Passed::default();
        }
        let delta = if self.paused { due as f64 / f64::from(rate) } else { elapsed };
        events.extend(self.played.device_events());
        let result = guarded(|| {
            for _ in 0..due {
                let result = self.played.game_mut().step(&std::mem::take(&mut events));
                self.note(result);
                follow(&mut self.played.game_mut().world);
                if self.game().has_ended() {
                    return None;
                }
            }
            let (result, overlay) = self.played.frame(delta as f32, input);
            self.note(result);
            follow(&mut self.played.game_mut().world);
            overlay
        });
        match result {
            Ok(overlay) => {
                self.path = self.game().world.ecs.resource::<CurrentScene>().path.clone();
                Passed { ran: true, overlay, end: self.game().has_ended().then_some(End::Quit) }
            }
            Err(message) => Passed { ran: true, overlay: None, end: Some(End::Panic(message)) },
        }
    }

    fn note(&mut self, result: Result<(), GameError>) {
        if let Err(error) = result {
            self.tell(Some(error.to_string()));
        }
    }

    /// Keeps and logs what went wrong; the game goes on as far as it can.
    fn tell(&mut self, trouble: Option<String>) {
        if let Some(text) = trouble.filter(|text| self.trouble.as_ref() != Some(text)) {
            log::error!("{text}");
            self.trouble = Some(text);
        }
    }
}

/// Does something that may panic; gives the message then.
fn guarded<T>(work: impl FnOnce() -> T) -> Result<T, String> {
    catch_unwind(AssertUnwindSafe(work)).map_err(|panic| {
        let text = panic.downcast_ref::<String>().map(String::as_str);
        text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("no message").to_owned()
    })
}
