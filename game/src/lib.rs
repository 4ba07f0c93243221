//! What a game is written with: [`App`] and the [`prelude`].
//!
//! In come a scene, components, systems and what the player does; out go a window with the game in it, or, without a
//! display, images of it in files. The editor is a feature of its own (`editor`), as are OpenEXR skies (`exr`), gamepads
//! (`gamepad`) and sounds (`sound`): a game is built with what it needs.
//!
//! | to | look at |
//! | --- | --- |
//! | write a game | [`App`], [`run`], [`prelude`]; `docs/game.md`; the examples in `game/examples` |
//! | know what a system can ask for | [`lightwell::game`]: input, time, space, light probes, scenes, saved games |
//! | draw over the image, play sounds | [`Hud`], [`Sounds`] |
//! | test a game | [`App::simulate`], [`App::headless`], [`lightwell::game::InputScript`] |
//! | add a render pass | [`App::pass`] and `docs/frame.md` |
//! | draw a scene without a game | [`lightwell_runtime::session::Session`] |
//! | edit a game's scenes | `--edit` of the game, with the feature `editor`, where Play runs it: the crate `lightwell_editor` |
//! | measure, test or render scenes | the program `lightwell`: the crates `lightwell_program` and `lightwell_tools` |
//!
//! How the engine itself is laid out stands on top of the crate [`lightwell`].

mod app;
pub mod prelude;

pub use app::{App, GameArgs, Hud, Outcome, Pictures, Sounds, run, run_with};
