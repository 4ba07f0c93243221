//! `lightwell pack`: a game as a folder that runs on machines without its source.
//!
//! | file | step |
//! | --- | --- |
//! | `program.rs` | cargo builds the program |
//! | `game.rs` | the program says what it loads |
//! | `layout.rs` | where each file lies in the packed folder |
//! | `licences.rs` | cargo names the libraries; their licences are collected |
//! | `place.rs` | the folder is written aside, and put in its place in one step |

mod game;
mod layout;
mod licences;
mod place;
mod program;

use crate::cli::PackArgs;
use anyhow::{Context, Result, bail};
use game::Game;
use layout::{Folders, Layout};
use lightwell::files::ComponentTypes;
use lightwell::packed::{ASSETS, LIST, MODELS};
use lightwell_runtime::cli::Common;
use lightwell_runtime::say;
use place::Place;
use program::Program;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// The file with the licences in a packed folder.
const LICENCES: &str = "LICENCES.txt";

/// Packs a game.
///
/// # Errors
/// If it cannot be built or loaded, a file is missing or lies elsewhere than the game, the folder is taken, or the packed
/// game does not load what the game loads.
pub fn run(args: &PackArgs, common: &Common) -> Result<()> {
    let name = program::name(args)?;
    let output = args.output.clone().unwrap_or_else(|| Path::new("out/pack").join(&name));
    // Found before the long build: that the folder is taken.
    let place = Place::new(&output, args.force)?;
    let included = layout::included(&args.include)?;
    let program = Program::find(args, name)?;
    let game = Game { program: &program.file, folder: program.folder.clone(), script: args.script.as_deref() };
    let loaded = game.files(&included, &common.arguments())?;
    let layout = Layout::new(&loaded, &included, &folders(&game, common)?)?;

    let aside = place.aside()?;
    let file_name = format!("{}{}", program.name, std::env::consts::EXE_SUFFIX);
    let packed_program = aside.path().join(&file_name);
    copy(&program.file, &packed_program)?;
    layout.copy(aside.path())?;
    write(&aside.path().join(LICENCES), &licences::text(args, &program)?)?;
    write(&aside.path().join(LIST), &list(&file_name, &layout))?;
    check(&game, &packed_program, &layout, &included)?;
    let size = place.finish(aside)?;
    let own = std::fs::metadata(output.join(&file_name)).map_or(0, |data| data.len());
    say!(
        "{}: the program ({:.1} MB) and {} files that it loads ({:.1} MB in all)",
        output.display(),
        own as f64 * 1e-6,
        layout.files.len(),
        size as f64 * 1e-6
    );
    Ok(())
}

/// The folders that the game's files may lie in.
fn folders(game: &Game, common: &Common) -> Result<Folders> {
    let start = game.folder.as_deref().unwrap_or(Path::new("."));
    let trusted = common.load_options(ComponentTypes::default()).trusted;
    let own = std::iter::once(start).chain(trusted.iter().map(PathBuf::as_path)).map(absolute);
    Ok(Folders { own: own.collect::<Result<_>>()?, models: common.models.as_deref().map(absolute).transpose()? })
}

/// The text of [`LIST`].
fn list(program: &str, layout: &Layout) -> String {
    let version = env!("CARGO_PKG_VERSION");
    let mut text = format!(
        "Made by lightwell pack {version}. The program finds its files by this list; --force replaces these files alone.\n"
    );
    let files = layout.files.iter().map(|file| file.to.as_str());
    for path in [program, LICENCES].into_iter().chain(files) {
        text += path;
        text.push('\n');
    }
    text
}

/// Sees that the packed game loads the same, in its own folder, from an empty one.
fn check(game: &Game, program: &Path, layout: &Layout, included: &[PathBuf]) -> Result<()> {
    let empty = tempfile::tempdir().context("cannot make a temporary folder")?;
    let folder = program.parent().unwrap_or(Path::new("")).canonicalize()?;
    let packed = Game { program, folder: Some(empty.path().to_owned()), script: game.script };
    let included: Vec<PathBuf> =
        included.iter().filter_map(|path| Some(layout.packed(path)?.within(&folder))).collect();
    let files = packed.files_alone(&included).context("the packed game does not load")?;
    let outside = files.iter().find(|file| !file.starts_with(folder.join(ASSETS)));
    if let Some(file) = outside {
        bail!(
            "the packed game still loads {}: name it in the scene by a path that is relative to the scene's file, or put \
             third-party models below --models (which are packed into {ASSETS}/{MODELS})",
            file.display()
        );
    }
    let found: BTreeSet<PathBuf> = files.into_iter().collect();
    let lost = layout.files.iter().find(|file| file.is_loaded && !found.contains(&file.within(&folder)));
    match lost {
        Some(file) => bail!("the packed game does not load {}, which the game loads", file.from.display()),
        None => Ok(()),
    }
}

fn absolute(path: &Path) -> Result<PathBuf> {
    path.canonicalize().with_context(|| format!("there is no {}", path.display()))
}

fn copy(from: &Path, to: &Path) -> Result<()> {
    if let Some(folder) = to.parent() {
        std::fs::create_dir_all(folder).with_context(|| format!("cannot make the folder {}", folder.display()))?;
    }
    std::fs::copy(from, to).with_context(|| format!("cannot copy {} to {}", from.display(), to.display()))?;
    Ok(())
}

fn write(path: &Path, text: &str) -> Result<()> {
    std::fs::write(path, text).with_context(|| format!("cannot write {}", path.display()))
}
