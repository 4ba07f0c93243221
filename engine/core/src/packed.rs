//! Games that `lightwell pack` made: a folder with the program, what it loads, and a list of both.

use std::path::{Path, PathBuf};
use std::sync::LazyLock;

/// The list of a packed game's files, beside its program: a line of words, then a path a line, with `/` on every system. A
/// program with such a list beside it is packed.
pub const LIST: &str = "packed.txt";
/// The folder of what the game loads, beside its program.
pub const ASSETS: &str = "assets";
/// The folder of third-party models within [`ASSETS`]: what `--models` names in the source tree.
pub const MODELS: &str = "third_party";

/// A packed game. It looks for files in its own folder alone: neither in the working directory nor where it was built.
pub struct Packed {
    folder: PathBuf,
    files: Vec<PathBuf>,
}

/// The running program, if it is a packed game.
pub fn game() -> Option<&'static Packed> {
    static GAME: LazyLock<Option<Packed>> = LazyLock::new(|| {
        let program = std::env::current_exe().ok()?;
        Packed::read(program.canonicalize().unwrap_or(program).parent()?)
    });
    GAME.as_ref()
}

impl Packed {
    /// The packed game in a folder; none if there is no list that can be read.
    pub fn read(folder: &Path) -> Option<Self> {
        let list = std::fs::read_to_string(folder.join(LIST)).ok()?;
        Some(Self {
            folder: folder.to_owned(),
            files: list.lines().skip(1).map(|line| line.split('/').collect()).collect(),
        })
    }

    /// The folder of the program.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// The files that were packed, relative to the folder. Of those that the game loads, its first scene comes first.
    pub fn files(&self) -> &[PathBuf] {
        &self.files
    }

    /// The folder of what the game loads.
    pub fn assets(&self) -> PathBuf {
        self.folder.join(ASSETS)
    }

    /// The packed file that the game names by a path in the source tree, with one of the endings or with none: the one
    /// whose path agrees with it from the end for longest, and of several the first.
    pub fn find(&self, written: &Path, endings: &[&str]) -> Option<PathBuf> {
        let name = written.file_name()?.to_string_lossy().into_owned();
        let names = std::iter::once(name.clone()).chain(endings.iter().map(|ending| format!("{name}.{ending}")));
        let paths: Vec<PathBuf> = names.map(|name| written.with_file_name(name)).collect();
        let mut best = (0, None);
        for file in self.files.iter().filter(|file| file.starts_with(ASSETS)) {
            let agreement = paths.iter().map(|path| common_end(path, file)).max().unwrap_or(0);
            if agreement > best.0 {
                best = (agreement, Some(self.folder.join(file)));
            }
        }
        best.1.filter(|path| path.is_file())
    }
}

/// Number of parts at their ends that two paths have in common.
fn common_end(a: &Path, b: &Path) -> usize {
    a.components().rev().zip(b.components().rev()).take_while(|(a, b)| a == b).count()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn the_file_that_agrees_for_longest_is_found() {
        let folder = tempfile::tempdir().unwrap();
        let files = ["assets/b/a.scene.ron", "assets/a.scene.ron", "assets/scenes/a.scene.ron", "assets/c.wav"];
        for file in files {
            std::fs::create_dir_all(folder.path().join(file).parent().unwrap()).unwrap();
            std::fs::write(folder.path().join(file), "").unwrap();
        }
        assert!(Packed::read(folder.path()).is_none());
        let list = format!("Made by a test.\ngame\n{}\nassets/gone.wav\n", files.join("\n"));
        std::fs::write(folder.path().join(LIST), list).unwrap();
        let packed = Packed::read(folder.path()).unwrap();
        assert_eq!(packed.files().len(), 6);
        for (written, found) in [
            ("/home/someone/game/scenes/a.scene.ron", Some("assets/scenes/a.scene.ron")),
            ("../b/a.scene.ron", Some("assets/b/a.scene.ron")),
            ("a.scene.ron", Some("assets/b/a.scene.ron")),
            ("a", Some("assets/b/a.scene.ron")),
            ("x/c.wav", Some("assets/c.wav")),
            ("gone.wav", None),
            ("game", None),
            ("d.scene.ron", None),
            ("..", None),
        ] {
            let found = found.map(|name| folder.path().join(name));
            assert_eq!(packed.find(Path::new(written), &["scene.ron", "glb"]), found, "{written}");
        }
    }

    #[test]
    fn a_program_without_a_list_beside_it_is_not_packed() {
        assert!(game().is_none());
    }
}
