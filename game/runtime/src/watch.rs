//! Notices when the scene's file changes, or one that it was made from: prefabs, models, buffers, images.

use notify_debouncer_full::notify::{RecommendedWatcher, RecursiveMode};
use notify_debouncer_full::{DebounceEventResult, Debouncer, RecommendedCache, new_debouncer};
use std::collections::{BTreeSet, HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, SystemTime};

/// What changed on disk.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Change {
    /// The scene itself.
    Scene,
    /// A prefab, model, buffer or image that it uses.
    Part(PathBuf),
}

/// Watches a scene and all that it was made from. Folders, because editors replace files.
pub struct SceneWatcher {
    debouncer: Option<Debouncer<RecommendedWatcher, RecommendedCache>>,
    events: Receiver<DebounceEventResult>,
    scene: PathBuf,
    folders: HashSet<PathBuf>,
    /// State seen of each file, so that a touch or a file saved unchanged reloads nothing.
    seen: HashMap<PathBuf, State>,
}

/// What tells one content of a file from another: all of it where it is text, else its size and time.
#[derive(Clone, Debug, PartialEq, Eq)]
enum State {
    Text(Vec<u8>),
    Data(u64, Option<SystemTime>),
}

impl State {
    /// None for files that are not there, or empty: editors truncate before they write.
    fn of(path: &Path) -> Option<Self> {
        let is_text = path.extension().is_some_and(|ending| ending == "ron");
        let state = match is_text {
            true => Self::Text(std::fs::read(path).ok()?),
            false => std::fs::metadata(path).ok().map(|data| Self::Data(data.len(), data.modified().ok()))?,
        };
        let is_empty = match &state {
            Self::Text(bytes) => bytes.is_empty(),
            Self::Data(length, _) => *length == 0,
        };
        (!is_empty).then_some(state)
    }
}

impl SceneWatcher {
    /// Watches a scene and its parts. If the system cannot, it says so in the log and nothing is noticed.
    pub fn new(scene: &Path, parts: &BTreeSet<PathBuf>) -> Self {
        let (sender, events) = channel();
        let scene = scene.canonicalize().unwrap_or_else(|_| scene.to_owned());
        let debouncer = new_debouncer(Duration::from_millis(100), None, sender).inspect_err(failed).ok();
        let (folders, seen) = (HashSet::new(), HashMap::new());
        let mut watcher = Self { debouncer, events, scene: scene.clone(), folders, seen };
        watcher.add(scene);
        watcher.follow(parts);
        watcher
    }

    /// Watches parts that came since.
    pub fn follow(&mut self, parts: &BTreeSet<PathBuf>) {
        for part in parts.iter().filter(|part| !self.seen.contains_key(*part)).cloned().collect::<Vec<_>>() {
            self.add(part);
        }
    }

    fn add(&mut self, file: PathBuf) {
        let Some(state) = State::of(&file) else { return };
        let folder = file.parent().unwrap_or(Path::new(".")).to_owned();
        if let Some(debouncer) = self.debouncer.as_mut().filter(|_| self.folders.insert(folder.clone())) {
            let _ = debouncer.watch(&folder, RecursiveMode::NonRecursive).inspect_err(failed);
        }
        self.seen.insert(file, state);
    }

    /// The scene's file was written or read by ourselves: that is no change.
    pub fn saved(&mut self) {
        let state = State::of(&self.scene).map(|state| (self.scene.clone(), state));
        self.seen.extend(state);
    }

    /// What changed since the last call. The scene counts most.
    pub fn changed(&mut self) -> Option<Change> {
        let changes = self.changes();
        let is_scene = changes.contains(&Change::Scene);
        if is_scene { Some(Change::Scene) } else { changes.into_iter().next() }
    }

    /// All that changed since the last call.
    pub fn changes(&mut self) -> Vec<Change> {
        let mut changes = Vec::new();
        for path in self.touched() {
            let Some(known) = self.seen.get_mut(&path) else { continue };
            let Some(state) = State::of(&path).filter(|state| state != known) else { continue };
            *known = state;
            changes.push(if path == self.scene { Change::Scene } else { Change::Part(path) });
        }
        changes
    }

    /// Files that may have changed since the last call: all of them where events were lost.
    fn touched(&mut self) -> Vec<PathBuf> {
        let (mut paths, mut has_lost) = (Vec::new(), false);
        for result in self.events.try_iter() {
            match result {
                Ok(events) => {
                    has_lost |= events.iter().any(|event| event.need_rescan());
                    paths.extend(events.into_iter().flat_map(|event| event.event.paths));
                }
                Err(errors) => {
                    errors.iter().for_each(|error| log::warn!("watching the scene's files: {error}"));
                    has_lost = true;
                }
            }
        }
        if has_lost { self.seen.keys().cloned().collect() } else { paths }
    }
}

fn failed(error: &notify_debouncer_full::notify::Error) {
    log::warn!("changes of the scene's files will not show by themselves: {error}");
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use lightwell::assets::AssetLibrary;
    use lightwell::files::{LoadOptions, load_scene};
    use lightwell::measure::write_png_rgb8;
    use std::time::Instant;

    fn change(watcher: &mut SceneWatcher) -> Option<Change> {
        let begin = Instant::now();
        while begin.elapsed() < Duration::from_secs(5) {
            if let Some(change) = watcher.changed() {
                return Some(change);
            }
            std::thread::sleep(Duration::from_millis(20));
        }
        None
    }

    #[test]
    fn saves_of_all_kinds_are_noticed() {
        let dir = tempfile::tempdir().unwrap();
        let scene = dir.path().join("a.scene.ron");
        std::fs::write(&scene, "one").unwrap();
        let mut watcher = SceneWatcher::new(&scene, &BTreeSet::new());
        std::fs::write(&scene, "two").unwrap();
        assert_eq!(change(&mut watcher), Some(Change::Scene), "a plain write");
        let other = dir.path().join("a.tmp");
        std::fs::write(&other, "three").unwrap();
        std::fs::rename(&other, &scene).unwrap();
        assert_eq!(change(&mut watcher), Some(Change::Scene), "a rename over the file");
        std::fs::write(dir.path().join("b.scene.ron"), "other").unwrap();
        std::fs::write(&scene, "").unwrap();
        std::thread::sleep(Duration::from_millis(500));
        assert_eq!(watcher.changed(), None, "another file, and an empty one");
    }

    #[test]
    fn lost_events_make_it_look_at_every_file() {
        use notify_debouncer_full::DebouncedEvent;
        use notify_debouncer_full::notify::Error;
        use notify_debouncer_full::notify::event::{Event, EventKind, Flag};
        let dir = tempfile::tempdir().unwrap();
        let dir = dir.path().canonicalize().unwrap();
        let (scene, part) = (dir.join("a.scene.ron"), dir.join("b.prefab.ron"));
        [&scene, &part].into_iter().for_each(|file| std::fs::write(file, "one").unwrap());
        let (sender, events) = channel();
        let (folders, seen) = (HashSet::new(), HashMap::new());
        let mut watcher = SceneWatcher { debouncer: None, events, scene: scene.clone(), folders, seen };
        [&scene, &part].into_iter().for_each(|file| watcher.add(file.clone()));
        sender.send(Err(vec![Error::generic("no more watches")])).unwrap();
        assert_eq!(watcher.changes(), [], "all is as it was");
        std::fs::write(&part, "two").unwrap();
        assert_eq!(watcher.changes(), [], "nothing tells of it");
        sender.send(Err(vec![Error::generic("no more watches")])).unwrap();
        assert_eq!(watcher.changes(), [Change::Part(part)]);
        std::fs::write(&scene, "two").unwrap();
        let overflow = Event::new(EventKind::Other).set_flag(Flag::Rescan);
        sender.send(Ok(vec![DebouncedEvent::new(overflow, Instant::now())])).unwrap();
        assert_eq!(watcher.changes(), [Change::Scene]);
    }

    #[test]
    fn parts_of_a_scene_are_watched_wherever_they_lie() {
        let dir = tempfile::tempdir().unwrap();
        let dir = dir.path().canonicalize().unwrap();
        for folder in ["scenes", "prefabs", "images"] {
            std::fs::create_dir(dir.join(folder)).unwrap();
        }
        let image = dir.join("images/red.png");
        write_png_rgb8(&image, [1, 1], &[255, 0, 0]).unwrap();
        let prefab = dir.join("prefabs/box.prefab.ron");
        let text = "Prefab(entities: [(name: \"Box\", mesh: Box(), material: (color_texture: \"../images/red.png\"))])";
        std::fs::write(&prefab, text).unwrap();
        let scene = dir.join("scenes/a.scene.ron");
        std::fs::write(&scene, "Scene(entities: [(name: \"A\", prefab: \"../prefabs/box.prefab.ron\")])").unwrap();
        let mut library = AssetLibrary::new();
        load_scene(&scene, &mut library, &LoadOptions::default()).unwrap();
        let parts = library.files();
        assert_eq!(parts, BTreeSet::from([image.clone(), prefab.clone()]));
        let mut watcher = SceneWatcher::new(&scene, &parts);
        std::fs::write(&prefab, format!("{text} ")).unwrap();
        assert_eq!(change(&mut watcher), Some(Change::Part(prefab)));
        write_png_rgb8(&image, [2, 1], &[0, 255, 0, 0, 0, 255]).unwrap();
        assert_eq!(change(&mut watcher), Some(Change::Part(image)));
        watcher.saved();
        let late = dir.join("images/late.png");
        write_png_rgb8(&late, [1, 1], &[0, 0, 255]).unwrap();
        watcher.follow(&BTreeSet::from([late.clone()]));
        std::thread::sleep(Duration::from_millis(300));
        assert_eq!(watcher.changed(), None, "what was there when it was followed is no change");
        write_png_rgb8(&late, [2, 2], &[0; 12]).unwrap();
        assert_eq!(change(&mut watcher), Some(Change::Part(late)));
    }
}
