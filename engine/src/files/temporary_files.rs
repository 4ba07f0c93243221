//! Temporary files that a program leaves beside a scene if it is killed in the middle of a save.

use super::document::folder_of;
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
