//! Reads a folder of shaders and notices when something in it changes.

use super::compose::Sources;
use notify_debouncer_full::notify::event::{AccessKind, AccessMode};
use notify_debouncer_full::notify::{self, EventKind, RecommendedWatcher, RecursiveMode};
use notify_debouncer_full::{DebounceEventResult, Debouncer, RecommendedCache, new_debouncer};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

/// Changes this close together are one: a save is several writes.
const DEBOUNCE: Duration = Duration::from_millis(100);

/// Watches a folder and all below it: watching folders instead of files survives editors that save by rename. The folders
/// above it are watched too, since it may be deleted and remade, or another one put in its place.
pub(super) struct Watcher {
    debouncer: Debouncer<RecommendedWatcher, RecommendedCache>,
    events: Receiver<DebounceEventResult>,
    dir: PathBuf,
}

impl Watcher {
    pub(super) fn new(dir: &Path) -> Result<Self, notify::Error> {
        let (sender, events) = channel();
        let mut debouncer = new_debouncer(DEBOUNCE, None, sender)?;
        let dir = std::path::absolute(dir)?;
        for above in dir.ancestors().skip(1) {
            // They need not be readable.
            let _ = debouncer.watch(above, RecursiveMode::NonRecursive);
        }
        debouncer.watch(&dir, RecursiveMode::Recursive)?;
        Ok(Self { debouncer, events, dir })
    }

    /// Whether anything in the folder changed since the last call.
    pub(super) fn changed(&mut self) -> bool {
        let (mut changed, mut is_replaced) = (false, false);
        for result in self.events.try_iter() {
            match result {
                Ok(events) => {
                    let paths = || events.iter().filter(|event| is_change(event.kind)).flat_map(|event| &event.paths);
                    changed |= paths().any(|path| path.starts_with(&self.dir));
                    is_replaced |= paths().any(|path| self.dir.starts_with(path));
                    is_replaced |= events.iter().any(|event| event.need_rescan());
                }
                Err(errors) => {
                    errors.iter().for_each(|error| log::warn!("watching files: {error}"));
                    // Events may have been lost, so that only looking tells.
                    changed = true;
                }
            }
        }
        if is_replaced {
            self.watch_again();
        }
        changed || is_replaced
    }

    /// Watches the folders anew, as far as they are there now.
    fn watch_again(&mut self) {
        let mut folders: Vec<&Path> = self.dir.ancestors().collect();
        folders.reverse();
        for folder in folders {
            let is_own = folder == self.dir;
            let mode = if is_own { RecursiveMode::Recursive } else { RecursiveMode::NonRecursive };
            // One that is gone is watched no longer, and watched again when it comes.
            let _ = self.debouncer.unwatch(folder);
            let _ = self.debouncer.watch(folder, mode);
        }
    }
}

/// Opening and reading a file is no change; taking it for one would make each reading cause the next.
fn is_change(kind: EventKind) -> bool {
    !matches!(kind, EventKind::Access(access) if access != AccessKind::Close(AccessMode::Write))
}

/// All `.wgsl` files below the folder. A file that vanishes meanwhile is left out; bytes that are no UTF-8 are
/// replaced, and the compiler then names their line.
pub(super) fn read_shaders(dir: &Path) -> std::io::Result<Sources> {
    let mut sources = Sources::new();
    read_folder(dir, dir, &mut sources)?;
    Ok(sources)
}

fn read_folder(root: &Path, dir: &Path, sources: &mut Sources) -> std::io::Result<()> {
    for entry in std::fs::read_dir(dir)? {
        let path = entry?.path();
        if path.is_dir() {
            if let Err(error) = read_folder(root, &path, sources) {
                log::warn!("cannot read shader folder {}: {error}", path.display());
            }
        } else if let Some(name) = relative_name(root, &path)
            && let Ok(bytes) = std::fs::read(&path)
        {
            sources.insert(name, String::from_utf8_lossy(&bytes).into_owned());
        }
    }
    Ok(())
}

/// The file's name within the folder, with `/` on every system; none if it is no shader.
fn relative_name(dir: &Path, path: &Path) -> Option<String> {
    if path.extension()? != "wgsl" {
        return None;
    }
    let parts = path.strip_prefix(dir).ok()?.iter().map(|part| part.to_str());
    Some(parts.collect::<Option<Vec<_>>>()?.join("/"))
}
