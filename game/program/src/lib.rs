//! The program `lightwell`: its command line, and which crate does what a command asks for.
//!
//! In come words of a command line ([`cli::Cli`]); out goes an exit code.
//!
//! | to | look at |
//! | --- | --- |
//! | add a command or an example to the help | [`cli`] |
//! | change what a command does | `lightwell_tools` |
//! | change the window of `play` | `lightwell_editor` |

pub mod cli;
mod play;
mod shipped;

use clap::Parser;
use cli::{Cli, Command};
use lightwell_runtime::{logging, scene_path};
use lightwell_tools::{commands, pack, sheet, stress};
use std::process::ExitCode;

/// Runs the program: parses its arguments, does what they ask for, and prints an error once.
pub fn run() -> ExitCode {
    let cli = Cli::parse();
    logging::start(cli.common.verbose);
    scene_path::set_shipped(shipped::scenes);
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
        Command::Pack(args) => pack::run(args, common).map(|()| ExitCode::SUCCESS),
        Command::Info => commands::info::run(common).map(|()| ExitCode::SUCCESS),
    };
    result.unwrap_or_else(|error| {
        eprintln!("error: {error:#}");
        ExitCode::from(1)
    })
}
