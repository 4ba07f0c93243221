//! Which files a scene may have read: those of its project, of the folder of models, and of what the user trusts. A
//! scene from elsewhere can so not reach, nor show in an error, what else lies on the machine.

use super::options::LoadOptions;
use crate::files::error::{FileError, FileErrorKind as Kind};
use crate::files::ron::document::{Document, folder_of};
use crate::files::ron::tree::Step;
use std::cell::RefCell;
use std::collections::HashSet;
use std::path::{Component, Path, PathBuf};

/// Names that Windows takes for devices, whatever folder and ending they have.
const DEVICES: [&str; 4] = ["CON", "PRN", "AUX", "NUL"];

/// The root of the project that a scene belongs to: the nearest folder around the scene that has both a folder `scenes`
/// and a folder `prefabs`, or else the scene's own folder. The user's home and what lies above it are never taken for a
/// project.
pub fn project_root(scene: &Path) -> PathBuf {
    let folder = real(folder_of(scene));
    let home = std::env::home_dir().map(|home| real(&home));
    let is_project = |folder: &&Path| {
        let is_too_high = folder.parent().is_none() || home.as_ref().is_some_and(|home| home.starts_with(folder));
        !is_too_high && folder.join("scenes").is_dir() && folder.join("prefabs").is_dir()
    };
    folder.ancestors().find(is_project).map(Path::to_owned).unwrap_or(folder)
}

/// Folders below which files are read.
pub(crate) struct Roots {
    /// As the system names them, without links.
    folders: Vec<PathBuf>,
    /// As they were given.
    given: Vec<PathBuf>,
    /// Paths that were found to lie below them.
    known: RefCell<HashSet<PathBuf>>,
}

impl Roots {
    /// Those of a scene.
    pub fn of(scene: &Path, options: &LoadOptions) -> Self {
        let trusted = options.models.iter().chain(&options.trusted);
        let given: Vec<PathBuf> = trusted.cloned().chain([folder_of(scene).to_owned()]).collect();
        let folders = [project_root(scene)].into_iter().chain(given.iter().map(|folder| real(folder))).collect();
        Self { folders, given, known: RefCell::default() }
    }

    /// Whether a file, written so, may be read. Files of other machines and devices are not even looked for.
    pub fn allow(&self, written: &str, path: &Path) -> bool {
        let is_given = || self.given.iter().any(|root| Path::new(written).starts_with(root));
        if (is_network(written) && !is_given()) || (cfg!(windows) && is_device(written)) {
            return false;
        }
        if self.known.borrow().contains(path) {
            return true;
        }
        let real = real(path);
        let is_below = self.folders.iter().any(|root| real.starts_with(root));
        if is_below {
            self.known.borrow_mut().insert(path.to_owned());
        }
        is_below
    }

    /// The same as an error at the value that names the file, which is a `what`.
    pub fn check(
        &self,
        what: &str,
        written: &str,
        path: &Path,
        document: &Document,
        at: &[Step],
    ) -> Result<(), FileError> {
        if self.allow(written, path) { Ok(()) } else { Err(refused(what, written, document, at)) }
    }
}

/// The error of a file that must not be read.
fn refused(what: &str, written: &str, document: &Document, at: &[Step]) -> FileError {
    let message =
        format!("the {what} `{}` lies outside of the project and of all trusted folders", written.escape_debug());
    let help = "move it into the project; or, if you trust this file, pass `--trust DIR` with the folder of what it \
                names (or set LIGHTWELL_TRUST)";
    document.error(at, Kind::Untrusted, message).with_help(help)
}

/// Whether a path leads to another machine, or around the system's rules for names (`\\?\`, `\\.\`).
fn is_network(written: &str) -> bool {
    let mut start = written.chars();
    let is_separator = |c: Option<char>| matches!(c, Some('/' | '\\'));
    is_separator(start.next()) && is_separator(start.next())
}

/// Whether a part of the path is the name of a device of Windows.
fn is_device(written: &str) -> bool {
    written.split(['/', '\\']).any(|part| {
        let stem = part.split(['.', ':']).next().unwrap_or_default().trim_end().to_ascii_uppercase();
        let is_port =
            |port: &str| stem.strip_prefix(port).is_some_and(|n| n.len() == 1 && n != "0" && n.parse::<u8>().is_ok());
        DEVICES.contains(&stem.as_str()) || is_port("COM") || is_port("LPT")
    })
}

/// The path without links and `..`, as far as it is there; what is not there is taken as written.
pub(in crate::files) fn real(path: &Path) -> PathBuf {
    if let Ok(real) = path.canonicalize() {
        return real;
    }
    let path = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    let mut real = PathBuf::new();
    for part in path.components() {
        match part {
            Component::ParentDir => drop(real.pop()),
            part => real.push(part),
        }
        real = real.canonicalize().unwrap_or(real);
    }
    real
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn names_of_devices_and_other_machines_are_known() {
        for name in ["NUL", "a/nul.png", "COM1", "lpt9.txt", "b\\Con", "aux:"] {
            assert!(is_device(name), "{name}");
        }
        for name in ["COM0", "console.png", "COM10", "null", "auxiliary/a.png"] {
            assert!(!is_device(name), "{name}");
        }
        assert!([r"\\host\share\a", "//host/share", r"\\?\C:\a", r"\/host"].iter().all(|path| is_network(path)));
        assert!(["/a", "a//b", "../a", ""].iter().all(|path| !is_network(path)));
    }

    #[test]
    fn a_project_has_scenes_and_prefabs() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path().canonicalize().unwrap();
        for inner in ["game/scenes/deep", "game/prefabs", "other/scenes"] {
            std::fs::create_dir_all(folder.join(inner)).unwrap();
        }
        for (scene, root) in [
            ("game/scenes/a.scene.ron", "game"),
            ("game/scenes/deep/a.scene.ron", "game"),
            ("game/a.scene.ron", "game"),
            ("other/scenes/a.scene.ron", "other/scenes"),
            ("a.scene.ron", ""),
        ] {
            assert_eq!(project_root(&folder.join(scene)), folder.join(root), "{scene}");
        }
    }

    #[test]
    fn what_is_not_there_is_resolved_too() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path().canonicalize().unwrap();
        assert_eq!(real(&folder.join("a/../../b")), folder.parent().unwrap().join("b"));
        assert_eq!(real(&folder.join("./a/b")), folder.join("a/b"));
    }
}
