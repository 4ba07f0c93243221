//! What a game is written with, [`App`] and the [`prelude`]; and the program `lightwell` as a library, so that its
//! headless scene tests and benchmarks are tests like any other.
//!
//! | to | look at |
//! | --- | --- |
//! | write a game | [`App`], [`prelude`]; the README's "Write a game"; the examples in `game/examples` |
//! | know what a system can ask for | [`lightwell::game`]: input, time, space, light probes, scenes, saved games |
//! | draw over the picture, play sounds | [`Hud`], [`Sounds`] |
//! | test a game | [`App::simulate`], [`App::headless`], [`lightwell::game::InputScript`] |
//! | add a render pass | [`App::pass`] and `docs/frame.md` |
//! | draw a scene without a game | [`session::Session`] |
//! | extend the editor | [`editor`] |
//! | test scenes, measure methods | [`scene_test`], [`bench`](mod@bench), [`stress`] |
//! | the command line | [`cli`], [`run`] |
//!
//! How the engine itself is laid out stands on top of the crate [`lightwell`].

#[macro_use]
mod output;

mod app;
pub mod bench;
pub mod beside;
mod capture;
pub mod cli;
mod commands;
pub mod editor;
mod jitter;
mod logging;
mod play;
pub mod prelude;
mod progress;
mod scene_path;
pub mod scene_test;
mod sequence;
pub mod session;
mod set;
mod sheet;
mod shot;
mod still;
pub mod stress;
mod writer;

pub use app::{App, GameArgs, Hud, Outcome, Pictures, Sounds};

use clap::Parser;
use cli::{Cli, Command};
use std::process::ExitCode;

/// Runs the program: parses its arguments, does what they ask for, and prints an error once.
pub fn run() -> ExitCode {
    let cli = Cli::parse();
    logging::start(cli.common.verbose);
    let common = &cli.common;
    let result = match &cli.command {
        Command::Play(args) => play::run(args, common).map(|()| ExitCode::SUCCESS),
        Command::Render(args) => commands::render::run(args, common).map(|()| ExitCode::SUCCESS),
        Command::Compare(args) => commands::compare::run(args),
        Command::Bench(args) => commands::bench::run(args, common).map(|()| ExitCode::SUCCESS),
        Command::Explain(args) => commands::explain::run(args, common).map(|()| ExitCode::SUCCESS),
        Command::Test(args) => commands::test::run(args, common),
        Command::Sheet(args) => sheet::run(args, common).map(|()| ExitCode::SUCCESS),
        Command::Stress(args) => stress::run(args, common),
        Command::Info => commands::info::run(common).map(|()| ExitCode::SUCCESS),
    };
    result.unwrap_or_else(|error| {
        eprintln!("error: {error:#}");
        ExitCode::from(1)
    })
}
