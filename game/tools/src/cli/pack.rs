//! Arguments of `lightwell pack`.

use clap::Args;
use std::path::PathBuf;

const HELP: &str = "\
Examples:
  lightwell pack                              the program of the package in this folder
  lightwell pack --example lamplight --script game/examples/lamplight/win.script.ron
  lightwell pack --manifest-path ../moth/Cargo.toml --include ../moth/sounds --features gamepad -o moth-1.0

The folder holds the program, the licences of what it is made of, and in `assets` what the game loads: its first scene,
and prefabs, models, images and tables that the scene names. What systems load by name is found with --script, which
plays the game once without a window, or is named with --include. The packed game is loaded once to see that it is whole.";

/// What to pack.
#[derive(Args, Debug, Default)]
#[command(after_help = HELP)]
pub struct PackArgs {
    /// Package of the game, as for cargo
    #[arg(short, long, value_name = "NAME")]
    pub package: Option<String>,
    /// Its program, if there are several
    #[arg(long, value_name = "NAME", conflicts_with = "example")]
    pub bin: Option<String>,
    /// An example in place of a program
    #[arg(long, value_name = "NAME")]
    pub example: Option<String>,
    /// Cargo.toml of the game; the game's paths start at its folder then, else at the current one
    #[arg(long, value_name = "PATH")]
    pub manifest_path: Option<PathBuf>,
    /// Features to build with, separated by commas
    #[arg(long, value_name = "LIST")]
    pub features: Option<String>,
    /// Pack this program, built already, in place of building one with the profile `dist`
    #[arg(long, value_name = "FILE")]
    pub program: Option<PathBuf>,
    /// A file that the game loads by name, with what it names itself, or a folder of such; may be given several times
    #[arg(long, value_name = "PATH")]
    pub include: Vec<PathBuf>,
    /// Play this input once, without a window, and pack what the game loads meanwhile
    #[arg(long, value_name = "FILE")]
    pub script: Option<PathBuf>,
    /// The new folder [default: out/pack/NAME]
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Replace a folder that this command made before
    #[arg(long)]
    pub force: bool,
}
