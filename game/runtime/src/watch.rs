//! Notices when the scene's file changes, or one that it was made from or would have been: prefabs, models, buffers,
//! images.
//!
//! Folders are watched and not files, since editors replace files; and all folders above these, since they are replaced,
//! deleted and remade too. Whatever the events say, files are then looked at: only their content decides.

use notify_debouncer_full::notify::event::{AccessKind, AccessMode};
use notify_debouncer_full::notify::{EventKind, RecommendedWatcher, RecursiveMode};
use notify_debouncer_full::{DebounceEventResult, Debouncer, RecommendedCache, new_debouncer};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Component, Path, PathBuf};
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

/// Watches a scene and all that it was made from, whether the files are there or not.
pub struct SceneWatcher {
    debouncer: Option<Debouncer<RecommendedWatcher, RecommendedCache>>,
    events: Receiver<DebounceEventResult>,
    /// The scene's file as it was named, and where links lead from there.
    scene: [PathBuf; 2],
    /// Folders of the files and all above them, those above first.
    folders: BTreeSet<PathBuf>,
    /// State seen of each file, so that a touch or a file saved unchanged reloads nothing; none: it was not there.
    seen: BTreeMap<PathBuf, Option<State>>,
}

/// What tells one content of a file from another: all of it where it is text, else its size, time and identity.
#[derive(Clone, Debug, PartialEq, Eq)]
enum State {
    Text(Vec<u8>),
    Data(u64, Option<SystemTime>, u64),
}

impl State {
    /// None for files that are not there, or empty: editors truncate before they write.
    fn of(path: &Path) -> Option<Self> {
        let data = std::fs::metadata(path).ok().filter(|data| data.is_file() && data.len() > 0)?;
        if path.extension().is_some_and(|ending| ending == "ron") {
            return std::fs::read(path).ok().filter(|bytes| !bytes.is_empty()).map(Self::Text);
        }
        Some(Self::Data(data.len(), data.modified().ok(), file_number(&data)))
    }
}

/// What tells a file from another one that was put in its place with the same size and time.
#[cfg(unix)]
fn file_number(data: &std::fs::Metadata) -> u64 {
    std::os::unix::fs::MetadataExt::ino(data)
}

/// Other systems give none.
#[cfg(not(unix))]
fn file_number(_: &std::fs::Metadata) -> u64 {
    0
}

impl SceneWatcher {
    /// Watches a scene and its parts. If the system cannot, it says so in the log and nothing is noticed.
    pub fn new(scene: &Path, parts: &BTreeSet<PathBuf>) -> Self {
        let (sender, events) = channel();
        let debouncer = new_debouncer(Duration::from_millis(100), None, sender).inspect_err(failed).ok();
        Self::with(debouncer, events, scene, parts)
    }

    fn with(
        debouncer: Option<Debouncer<RecommendedWatcher, RecommendedCache>>,
        events: Receiver<DebounceEventResult>,
        scene: &Path,
        parts: &BTreeSet<PathBuf>,
    ) -> Self {
        let scene = names(scene);
        let (folders, seen) = (BTreeSet::new(), BTreeMap::new());
        let mut watcher = Self { debouncer, events, scene: scene.clone(), folders, seen };
        watcher.follow(&parts.iter().chain(&scene).cloned().collect());
        watcher
    }

    /// Watches parts that came since.
    pub fn follow(&mut self, parts: &BTreeSet<PathBuf>) {
        let new: BTreeSet<PathBuf> =
            parts.iter().flat_map(|part| names(part)).filter(|part| !self.seen.contains_key(part)).collect();
        let above = new.iter().flat_map(|file| file.ancestors().skip(1)).map(Path::to_owned);
        let folders: BTreeSet<PathBuf> = above.filter(|folder| !self.folders.contains(folder)).collect();
        self.watch(&folders);
        self.folders.extend(folders);
        // After the folders, so that no change lies between.
        self.seen.extend(new.into_iter().map(|file| (file.clone(), State::of(&file))));
    }

    /// Watches folders, as far as they are there; those above first, so that one which comes meanwhile is noticed.
    fn watch(&mut self, folders: &BTreeSet<PathBuf>) {
        let Some(debouncer) = &mut self.debouncer else { return };
        for folder in folders.iter().filter(|folder| folder.is_dir()) {
            // Folders above need not be readable.
            if let Err(error) = debouncer.watch(folder, RecursiveMode::NonRecursive) {
                log::debug!("changes in {} are not noticed: {error}", folder.display());
            }
        }
    }

    /// Watches all folders anew: another one may stand where one of them was.
    fn watch_again(&mut self) {
        if let Some(debouncer) = &mut self.debouncer {
            for folder in &self.folders {
                // One that is gone is watched no longer.
                let _ = debouncer.unwatch(folder);
            }
        }
        let folders = std::mem::take(&mut self.folders);
        self.watch(&folders);
        self.folders = folders;
    }

    /// The scene's file was written by ourselves: that is no change.
    pub fn saved(&mut self) {
        for name in &self.scene {
            if let Some(state) = State::of(name) {
                self.seen.insert(name.clone(), Some(state));
            }
        }
    }

    /// The scene could not be loaded with the files as they are: those that are not there now are a change when they
    /// come, even with the content that they had.
    pub fn failed(&mut self) {
        for (path, seen) in &mut self.seen {
            if State::of(path).is_none() {
                *seen = None;
            }
        }
    }

    /// What changed since the last call. The scene counts most.
    pub fn changed(&mut self) -> Option<Change> {
        let changes = self.changes();
        let is_scene = changes.contains(&Change::Scene);
        if is_scene { Some(Change::Scene) } else { changes.into_iter().next() }
    }

    /// All that changed since the last call.
    pub fn changes(&mut self) -> Vec<Change> {
        if !self.is_touched() {
            return Vec::new();
        }
        let mut changes = Vec::new();
        for (path, known) in &mut self.seen {
            let Some(state) = State::of(path).filter(|state| Some(state) != known.as_ref()) else { continue };
            *known = Some(state);
            let is_scene = self.scene.contains(path);
            changes.push(if is_scene { Change::Scene } else { Change::Part(path.clone()) });
        }
        changes.dedup();
        changes
    }

    /// Whether any file may have changed since the last call. Folders that came or went are watched anew.
    fn is_touched(&mut self) -> bool {
        let (mut is_touched, mut has_other_folders) = (false, false);
        for result in self.events.try_iter() {
            let events = match result {
                Ok(events) => events,
                Err(errors) => {
                    errors.iter().for_each(|error| log::warn!("watching the scene's files: {error}"));
                    (is_touched, has_other_folders) = (true, true);
                    continue;
                }
            };
            let paths = || events.iter().filter(|event| is_change(event.kind)).flat_map(|event| &event.paths);
            has_other_folders |= events.iter().any(|event| event.need_rescan());
            has_other_folders |= paths().any(|path| has_name_of(path, self.folders.iter()));
            is_touched |= paths().any(|path| has_name_of(path, self.seen.keys()));
        }
        if has_other_folders {
            self.watch_again();
        }
        is_touched || has_other_folders
    }
}

/// A file as it is named, and where links lead from there: either may be replaced.
fn names(file: &Path) -> [PathBuf; 2] {
    let named = std::path::absolute(file).unwrap_or_else(|_| file.to_owned());
    let real = real_path(&named);
    let leads_back = named.components().any(|part| part == Component::ParentDir);
    [if leads_back { real.clone() } else { named }, real]
}

/// Where links lead, as far as the path is there.
fn real_path(path: &Path) -> PathBuf {
    path.canonicalize().unwrap_or_else(|_| match (path.parent(), path.file_name()) {
        (Some(folder), Some(name)) => real_path(folder).join(name),
        // The path ends in `..`.
        (Some(folder), None) => real_path(folder).parent().map_or_else(PathBuf::new, Path::to_owned),
        (None, _) => path.to_owned(),
    })
}

/// Whether one of the paths ends in the same name. The system tells of a folder by one of its names, and it may be watched
/// under several.
fn has_name_of<'a>(path: &Path, mut paths: impl Iterator<Item = &'a PathBuf>) -> bool {
    paths.any(|known| known.file_name() == path.file_name())
}

/// Opening and reading is no change.
fn is_change(kind: EventKind) -> bool {
    !matches!(kind, EventKind::Access(access) if access != AccessKind::Close(AccessMode::Write))
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
        let mut watcher = SceneWatcher::with(None, events, &scene, &BTreeSet::from([part.clone()]));
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

    /// A scene with a prefab, a model in two files and an image, in folders of their own, watched as games do.
    struct Watched {
        dir: tempfile::TempDir,
        watcher: SceneWatcher,
    }

    impl Watched {
        /// Watches these files below a folder, of which some are there.
        fn new(there: &[&str], missing: &[&str]) -> Self {
            let dir = tempfile::tempdir().unwrap();
            let at = |name: &&str| dir.path().canonicalize().unwrap().join(name);
            for path in there.iter().map(at) {
                std::fs::create_dir_all(path.parent().unwrap()).unwrap();
                std::fs::write(path, "one").unwrap();
            }
            let parts = there.iter().chain(missing).map(at).collect();
            let scene = at(&"project/a.scene.ron");
            Self { watcher: SceneWatcher::new(&scene, &parts), dir }
        }

        fn at(&self, name: &str) -> PathBuf {
            self.dir.path().canonicalize().unwrap().join(name)
        }

        fn write(&self, name: &str, text: &str) {
            std::fs::create_dir_all(self.at(name).parent().unwrap()).unwrap();
            std::fs::write(self.at(name), text).unwrap();
        }

        /// The next change must be of this file.
        #[track_caller]
        fn expect(&mut self, name: &str) {
            let path = self.at(name);
            let is_scene = name.ends_with(".scene.ron");
            let expected = if is_scene { Change::Scene } else { Change::Part(path) };
            assert_eq!(change(&mut self.watcher), Some(expected), "{name}");
        }
    }

    #[test]
    fn files_that_were_missing_are_noticed_when_they_come() {
        let there = ["project/a.scene.ron"];
        let missing = ["project/b.prefab.ron", "project/images/deep/red.png", "other/model.bin"];
        let mut watched = Watched::new(&there, &missing);
        for name in missing {
            watched.write(name, "came");
            watched.expect(name);
        }
        let mut nothing = Watched::new(&[], &[]);
        nothing.write("project/a.scene.ron", "Scene()");
        nothing.expect("project/a.scene.ron");
    }

    #[test]
    fn folders_may_be_deleted_remade_renamed_and_swapped() {
        let files = ["project/a.scene.ron", "project/models/car/car.gltf", "project/models/car/car.bin"];
        let mut watched = Watched::new(&files, &[]);
        std::fs::remove_dir_all(watched.at("project/models")).unwrap();
        std::thread::sleep(Duration::from_millis(300));
        assert_eq!(watched.watcher.changed(), None, "what is gone is no change");
        watched.write(files[1], "again");
        watched.expect(files[1]);
        watched.write(files[2], "again");
        watched.expect(files[2]);
        // `mv models old; mv new models`.
        watched.write("project/new/car/car.gltf", "swapped");
        std::fs::rename(watched.at("project/models"), watched.at("project/old")).unwrap();
        std::fs::rename(watched.at("project/new"), watched.at("project/models")).unwrap();
        watched.expect(files[1]);
        // The whole project, as `git worktree` and synchronizing tools do.
        std::fs::rename(watched.at("project"), watched.at("before")).unwrap();
        watched.write("after/a.scene.ron", "other");
        std::fs::rename(watched.at("after"), watched.at("project")).unwrap();
        watched.expect(files[0]);
        watched.write(files[2], "still watched");
        watched.expect(files[2]);
    }

    /// What a failed load would have needed counts when it comes back, even as it was.
    #[test]
    fn what_comes_back_as_it_was_counts_after_a_failed_load() {
        let prefab = "project/parts/b.prefab.ron";
        let mut watched = Watched::new(&["project/a.scene.ron", prefab], &[]);
        let (parts, away) = (watched.at("project/parts"), watched.at("away"));
        for has_failed in [false, true] {
            std::fs::rename(&parts, &away).unwrap();
            std::thread::sleep(Duration::from_millis(300));
            assert_eq!(watched.watcher.changed(), None);
            if has_failed {
                watched.watcher.failed();
            }
            std::fs::rename(&away, &parts).unwrap();
            if has_failed {
                watched.expect(prefab);
            } else {
                std::thread::sleep(Duration::from_millis(300));
                assert_eq!(watched.watcher.changed(), None, "nothing failed meanwhile");
            }
        }
    }

    /// The ways in which programs save: each is noticed, and the file is watched on.
    #[test]
    fn saves_of_editors_and_exporters_are_noticed() {
        type Save = fn(&Path, &str);
        let vim: Save = |path, text| {
            let backup = path.with_extension("ron~");
            std::fs::rename(path, &backup).unwrap();
            std::fs::write(path, text).unwrap();
            std::fs::remove_file(backup).unwrap();
        };
        let emacs: Save = |path, text| {
            std::fs::copy(path, path.with_extension("ron~")).unwrap();
            std::fs::write(path, text).unwrap();
        };
        let truncate_and_write: Save = |path, text| {
            std::fs::write(path, "").unwrap();
            std::thread::sleep(Duration::from_millis(200));
            std::fs::write(path, text).unwrap();
        };
        let atomic: Save = |path, text| {
            let other = path.with_extension("tmp123");
            std::fs::write(&other, text).unwrap();
            std::fs::rename(other, path).unwrap();
        };
        let git_checkout: Save = |path, text| {
            std::fs::remove_file(path).unwrap();
            std::fs::write(path, text).unwrap();
        };
        let late: Save = |path, text| {
            std::fs::remove_file(path).unwrap();
            std::thread::sleep(Duration::from_millis(300));
            std::fs::write(path, text).unwrap();
        };
        let files = ["project/a.scene.ron", "project/car.bin"];
        let mut watched = Watched::new(&files, &[]);
        let saves = [vim, emacs, truncate_and_write, atomic, git_checkout, late, vim];
        for (number, save) in saves.into_iter().enumerate() {
            for name in files {
                save(&watched.at(name), &format!("save {number}"));
                watched.expect(name);
                std::thread::sleep(Duration::from_millis(250));
                while watched.watcher.changed().is_some() {}
            }
        }
    }

    /// Blender writes the `.bin` and then the `.gltf`, others the other way round, and large ones take their time.
    #[test]
    fn exporters_write_two_files_in_any_order_and_slowly() {
        let files = ["project/car.gltf", "project/car.bin"];
        let mut watched = Watched::new(&files, &[]);
        for order in [[0, 1], [1, 0]] {
            for index in order {
                for length in 1..4 {
                    watched.write(files[index], &"part ".repeat(length));
                    std::thread::sleep(Duration::from_millis(40));
                }
                watched.expect(files[index]);
            }
            std::thread::sleep(Duration::from_millis(300));
            while watched.watcher.changed().is_some() {}
        }
    }

    #[cfg(unix)]
    #[test]
    fn links_that_lead_elsewhere_are_noticed() {
        let dir = tempfile::tempdir().unwrap();
        let dir = dir.path().canonicalize().unwrap();
        for name in ["one", "two"] {
            std::fs::create_dir(dir.join(name)).unwrap();
            std::fs::write(dir.join(name).join("a.png"), name).unwrap();
        }
        let scene = dir.join("a.scene.ron");
        std::fs::write(&scene, "Scene()").unwrap();
        let lead = |to: &str| {
            std::os::unix::fs::symlink(dir.join(to), dir.join("link.tmp")).unwrap();
            std::fs::rename(dir.join("link.tmp"), dir.join("images")).unwrap();
        };
        lead("one");
        let image = dir.join("images/a.png");
        let mut watcher = SceneWatcher::new(&scene, &BTreeSet::from([image.clone()]));
        lead("two");
        assert_eq!(change(&mut watcher), Some(Change::Part(image.clone())), "a folder's link");
        std::fs::write(dir.join("two/a.png"), "longer").unwrap();
        assert_eq!(change(&mut watcher), Some(Change::Part(image)), "and what it leads to is watched");
    }

    /// Scenes name parts by paths that lead back, `../prefabs/b.prefab.ron`.
    #[test]
    fn paths_that_lead_back_are_watched() {
        let there = ["project/scenes/x", "project/a.scene.ron", "project/scenes/../prefabs/b.prefab.ron"];
        let mut watched = Watched::new(&there, &["project/scenes/../models/car/car.glb"]);
        for (name, expected) in [
            ("project/prefabs/b.prefab.ron", "project/prefabs/b.prefab.ron"),
            ("project/models/car/car.glb", "project/models/car/car.glb"),
            ("project/a.scene.ron", "project/a.scene.ron"),
        ] {
            watched.write(name, "two");
            watched.expect(expected);
        }
    }

    #[test]
    fn what_a_failed_load_needed_is_watched() {
        let dir = tempfile::tempdir().unwrap();
        let dir = dir.path().canonicalize().unwrap();
        let scene = dir.join("a.scene.ron");
        let model = r#"{"asset":{"version":"2.0"},"buffers":[{"uri":"c.bin","byteLength":4}],"meshes":[]}"#;
        std::fs::write(dir.join("c.gltf"), model).unwrap();
        let cases = [
            (r#"(name: "A", prefab: "parts/b.prefab.ron")"#, "parts/b.prefab.ron"),
            (r#"(name: "A", model: "c.glb")"#, "c.glb"),
            (r#"(name: "A", model: "c.gltf")"#, "c.bin"),
            (r#"(name: "A", mesh: Box(), material: (color_texture: "d.png"))"#, "d.png"),
        ];
        for (entity, missing) in cases {
            std::fs::write(&scene, format!("Scene(entities: [{entity}])")).unwrap();
            let mut library = AssetLibrary::new();
            let _ = load_scene(&scene, &mut library, &LoadOptions::default());
            assert!(library.watched().contains(&dir.join(missing)), "{missing}: {:?}", library.watched());
        }
    }
}
