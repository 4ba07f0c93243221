//! The game as the editor plays it: everything but window and device.

#[cfg(feature = "gamepad")]
use super::pads::Pads;
#[cfg(feature = "sound")]
use super::speaker::Speaker;
use super::{App, CustomPassAdder, Hud, sounds};
use anyhow::{Context, Result};
use egui::RawInput;
use lightwell::game::{Game, GameError, InputEvent};
use lightwell_editor::{NewGame, Overlay, PlayedGame};
use lightwell_runtime::cli::Common;
use lightwell_runtime::session::RenderState;
use std::cell::Cell;
use std::rc::Rc;

/// How an app can be had again.
pub(super) type Again = Rc<dyn Fn() -> App>;

/// What makes a game for each play of the editor: the first one of `app`, the others of what makes it again.
pub(super) fn new_game(app: App, again: Option<Again>, common: &Common) -> NewGame {
    let (first, common) = (Cell::new(Some(app)), common.clone());
    Rc::new(move || {
        let app = first.take().or_else(|| again.as_ref().map(|again| again()));
        let app = app.context(
            "`App::run` gives the editor its game once: write `lightwell_game::run(app)` with a function `app` that \
             makes it, so that it can be played again",
        )?;
        Ok(Box::new(InEditor::new(app, &common)?))
    })
}

struct InEditor {
    game: Game,
    passes: Vec<CustomPassAdder>,
    #[cfg(feature = "gamepad")]
    pads: Pads,
    #[cfg(feature = "sound")]
    speaker: Speaker,
}

impl InEditor {
    fn new(mut app: App, common: &Common) -> Result<Self> {
        let passes = std::mem::take(&mut app.passes);
        Ok(Self {
            game: app.prepare(common)?,
            passes,
            #[cfg(feature = "gamepad")]
            pads: Pads::open(),
            #[cfg(feature = "sound")]
            speaker: Speaker::open(),
        })
    }
}

impl PlayedGame for InEditor {
    fn game(&self) -> &Game {
        &self.game
    }

    fn game_mut(&mut self) -> &mut Game {
        &mut self.game
    }

    #[cfg(feature = "gamepad")]
    fn device_events(&mut self) -> Vec<InputEvent> {
        self.pads.events()
    }

    #[cfg(not(feature = "gamepad"))]
    fn device_events(&mut self) -> Vec<InputEvent> {
        Vec::new()
    }

    fn frame(&mut self, delta: f32, input: RawInput) -> (Result<(), GameError>, Option<Overlay>) {
        let (result, output) = Hud::pass(&mut self.game, Some(input), |game| game.frame(delta));
        let played = sounds::play_all(
            &mut self.game,
            #[cfg(feature = "sound")]
            &self.speaker,
        );
        let result = result.and(played.map_err(|error| GameError::Failed(vec![format!("{error:#}")])));
        let context = self.game.world.ecs.resource::<Hud>().context().clone();
        (result, Some(Overlay { context, output }))
    }

    fn add_passes(&self, rendering: &mut RenderState) {
        self.passes.iter().for_each(|add| add(rendering));
    }
}
