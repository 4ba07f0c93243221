//! Notices when the scene's files change.

use notify_debouncer_full::notify::{RecommendedWatcher, RecursiveMode};
use notify_debouncer_full::{DebounceEventResult, Debouncer, RecommendedCache, new_debouncer};
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

/// Watches the folder of a scene and the folder `prefabs` beside it. Folders, because editors replace files.
pub struct SceneWatcher {
    _debouncer: Option<Debouncer<RecommendedWatcher, RecommendedCache>>,
    events: Receiver<DebounceEventResult>,
    scene: PathBuf,
    /// Contents seen, so that a touch or a file saved unchanged reloads nothing.
    seen: HashMap<PathBuf, Vec<u8>>,
}

impl SceneWatcher {
    /// Watches the files of a scene. If the system cannot, it says so in the log and nothing is noticed.
    pub fn new(scene: &Path) -> Self {
        let (sender, events) = channel();
        let scene = scene.canonicalize().unwrap_or_else(|_| scene.to_owned());
        let folder = scene.parent().unwrap_or(Path::new(".")).to_owned();
        let start = || {
            let mut debouncer = new_debouncer(Duration::from_millis(100), None, sender)?;
            debouncer.watch(&folder, RecursiveMode::NonRecursive)?;
            let prefabs = folder.join("../prefabs");
            if prefabs.is_dir() {
                debouncer.watch(prefabs.canonicalize().unwrap_or(prefabs), RecursiveMode::Recursive)?;
            }
            Ok::<_, notify_debouncer_full::notify::Error>(debouncer)
        };
        let debouncer = start()
            .inspect_err(|error| log::warn!("changes of the scene's files will not show by themselves: {error}"))
            .ok();
        let seen = std::fs::read(&scene).map(|bytes| (scene.clone(), bytes)).into_iter().collect();
        Self { _debouncer: debouncer, events, scene, seen }
    }

    /// The scene's file was written or read by ourselves: that is no change.
    pub fn saved(&mut self) {
        self.seen.extend(std::fs::read(&self.scene).map(|bytes| (self.scene.clone(), bytes)));
    }

    /// Whether the scene's file or a prefab changed since the last call. Empty files are passed over: editors
    /// truncate before they write.
    pub fn changed(&mut self) -> bool {
        let mut changed = false;
        let events: Vec<_> = self.events.try_iter().flatten().flatten().collect();
        for path in events.iter().flat_map(|event| &event.paths) {
            let matters = *path == self.scene || path.to_string_lossy().ends_with(".prefab.ron");
            let Some(bytes) = matters.then(|| std::fs::read(path).ok()).flatten() else { continue };
            if !bytes.is_empty() && self.seen.get(path) != Some(&bytes) {
                self.seen.insert(path.clone(), bytes);
                changed = true;
            }
        }
        changed
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use std::time::Instant;

    fn changes(watcher: &mut SceneWatcher) -> bool {
        let begin = Instant::now();
        while begin.elapsed() < Duration::from_secs(5) {
            if watcher.changed() {
                return true;
            }
            std::thread::sleep(Duration::from_millis(20));
        }
        false
    }

    #[test]
    fn saves_of_all_kinds_are_noticed() {
        let dir = tempfile::tempdir().unwrap();
        let scene = dir.path().join("a.scene.ron");
        std::fs::write(&scene, "one").unwrap();
        let mut watcher = SceneWatcher::new(&scene);
        std::fs::write(&scene, "two").unwrap();
        assert!(changes(&mut watcher), "a plain write");
        let other = dir.path().join("a.tmp");
        std::fs::write(&other, "three").unwrap();
        std::fs::rename(&other, &scene).unwrap();
        assert!(changes(&mut watcher), "a rename over the file");
        std::fs::write(dir.path().join("b.scene.ron"), "other").unwrap();
        std::fs::write(&scene, "").unwrap();
        std::thread::sleep(Duration::from_millis(500));
        assert!(!watcher.changed(), "another file, and an empty one");
    }
}
