//! Files on disk: they are replaced in one step, and temporary files that a killed program left beside them are removed.

use crate::core::{beside, discard, write_in_place_of};
use crate::files::error::{FileError, FileErrorKind as Kind};
use crate::files::ron::document::folder_of;
use std::path::Path;
use std::time::Duration;

/// No save takes longer.
const LONG_AGO: Duration = Duration::from_secs(600);

/// Removes half-written copies of a scene, prefab or saved game that no running program writes any more: those of
/// programs that are gone, or, where the system does not tell, those that are ten minutes old.
pub fn remove_leftovers(path: &Path) {
    let path = path.canonicalize().unwrap_or_else(|_| path.to_owned());
    let Some(name) = path.file_name().map(|name| name.to_string_lossy().into_owned()) else { return };
    let Ok(entries) = std::fs::read_dir(folder_of(&path)) else { return };
    for entry in entries.flatten() {
        let found = entry.file_name().to_string_lossy().into_owned();
        let Some(process) = writer(&found, &name) else { continue };
        let age = entry.metadata().and_then(|data| data.modified()).ok().and_then(|time| time.elapsed().ok());
        let is_old = age.is_some_and(|age| age > LONG_AGO);
        if process != std::process::id() && (is_old || is_gone(process)) {
            // Another program may have removed it already.
            let _ = std::fs::remove_file(entry.path());
        }
    }
}

/// The process that writes a temporary file of that scene, if it is one.
fn writer(found: &str, scene: &str) -> Option<u32> {
    let of_scene = found.strip_prefix(scene).and_then(|rest| rest.strip_prefix('.')).and_then(|rest| {
        let rest = rest.strip_suffix(".tmp")?;
        Some(rest.strip_suffix(".bak").unwrap_or(rest))
    });
    // A scene that is tried in another folder before it is saved there.
    let of_trial = || found.strip_prefix('.')?.strip_suffix(".trial.scene.ron");
    of_scene.or_else(of_trial)?.parse().ok()
}

/// Whether no process has that number; only Linux tells.
fn is_gone(process: u32) -> bool {
    let processes = Path::new("/proc");
    cfg!(target_os = "linux") && processes.join("self").exists() && !processes.join(process.to_string()).exists()
}

/// Replaces the file in one step, and keeps the one before as `NAME.bak`. Both have the permissions of the file before.
pub fn write_atomically(path: &Path, text: &str) -> Result<(), FileError> {
    // A link stays a link: the file it leads to is replaced.
    let path = &path.canonicalize().unwrap_or_else(|_| path.to_owned());
    let failed = |what: &str, e: &std::io::Error| {
        FileError::new(path, Kind::Io, format!("{what}: {e}"))
            .with_help("check the folder's permissions and free space")
    };
    if path.file_name().is_none() {
        return Err(FileError::new(path, Kind::Io, "the path names no file"));
    }
    remove_leftovers(path);
    let (temporary, copy) = (beside(path, ".tmp"), beside(path, ".bak.tmp"));
    let mut backup = path.as_os_str().to_owned();
    backup.push(".bak");
    let result = write_in_place_of(&temporary, text.as_bytes(), path)
        .map_err(|e| failed("cannot write beside it", &e))
        .and_then(|()| match path.exists() {
            // In one step too: a backup that is cut off would be none.
            true => std::fs::read(path)
                .and_then(|old| write_in_place_of(&copy, &old, path))
                .and_then(|()| std::fs::rename(&copy, backup))
                .map_err(|e| failed("cannot keep the file before as backup", &e)),
            false => Ok(()),
        })
        .and_then(|()| std::fs::rename(&temporary, path).map_err(|e| failed("cannot replace it", &e)));
    if result.is_err() {
        [&temporary, &copy].into_iter().for_each(|file| discard(file));
    }
    result
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    #[cfg(target_os = "linux")]
    fn only_what_the_dead_left_goes() {
        let folder = tempfile::tempdir().unwrap();
        let scene = folder.path().join("a.scene.ron");
        let parent = std::os::unix::process::parent_id();
        // Process numbers end far below this.
        let dead = 4_000_000_000_u32;
        let gone = [
            format!("a.scene.ron.{dead}.tmp"),
            format!("a.scene.ron.{dead}.bak.tmp"),
            format!(".{dead}.trial.scene.ron"),
        ];
        let kept = [
            "a.scene.ron".to_owned(),
            "a.scene.ron.bak".to_owned(),
            "a.scene.ron.notes.tmp".to_owned(),
            format!("b.scene.ron.{dead}.tmp"),
            format!("a.scene.ron.{parent}.tmp"),
        ];
        for name in gone.iter().chain(&kept) {
            std::fs::write(folder.path().join(name), "x").unwrap();
        }
        remove_leftovers(&scene);
        let left = |names: &[String]| names.iter().filter(|name| folder.path().join(name).exists()).count();
        assert_eq!((left(&gone), left(&kept)), (0, kept.len()));
    }
}

#[cfg(all(test, unix))]
mod access_tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::core::replace_file;
    use std::fs::File;
    use std::fs::{Permissions, set_permissions};
    use std::os::unix::fs::{MetadataExt, PermissionsExt};

    #[test]
    fn permissions_stay_those_of_the_file_before() {
        let folder = tempfile::tempdir().unwrap();
        let mode = |name: &str| folder.path().join(name).metadata().unwrap().mode() & 0o777;
        let (path, plain) = (folder.path().join("a.scene.ron"), folder.path().join("plain"));
        File::create(&plain).unwrap();
        write_atomically(&path, "one").unwrap();
        assert_eq!(mode("a.scene.ron"), mode("plain"), "a new file has the usual permissions");
        for wanted in [0o600, 0o640, 0o664, 0o755, 0o444] {
            set_permissions(&path, Permissions::from_mode(wanted)).unwrap();
            write_atomically(&path, "two").unwrap();
            assert_eq!((mode("a.scene.ron"), mode("a.scene.ron.bak")), (wanted, wanted), "{wanted:o}");
            replace_file(&path, b"three").unwrap();
            assert_eq!(mode("a.scene.ron"), wanted, "{wanted:o}");
        }
    }

    #[test]
    fn the_owner_stays_where_the_system_lets() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.scene.ron");
        std::fs::write(&path, "one").unwrap();
        if std::os::unix::fs::chown(&path, Some(4242), Some(4243)).is_err() {
            return; // only root may give files away
        }
        write_atomically(&path, "two").unwrap();
        for name in ["a.scene.ron", "a.scene.ron.bak"] {
            let data = folder.path().join(name).metadata().unwrap();
            assert_eq!((data.uid(), data.gid()), (4242, 4243), "{name}");
        }
    }
}
