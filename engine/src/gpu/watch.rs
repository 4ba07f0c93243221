//! Reads a folder of shaders and notices when something in it changes.

use super::compose::Sources;
use notify_debouncer_full::notify::event::{AccessKind, AccessMode};
use notify_debouncer_full::notify::{self, EventKind, RecommendedWatcher, RecursiveMode};
use notify_debouncer_full::{DebounceEventResult, Debouncer, RecommendedCache, new_debouncer};
use std::path::Path;
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

/// Changes this close together are one: a save is several writes.
const DEBOUNCE: Duration = Duration::from_millis(100);

/// Watches a folder and all below it: watching folders instead of files survives editors that save by rename.
pub(super) struct Watcher {
    _debouncer: Debouncer<RecommendedWatcher, RecommendedCache>,
    events: Receiver<DebounceEventResult>,
}

impl Watcher {
    pub(super) fn new(dir: &Path) -> Result<Self, notify::Error> {
        let (sender, events) = channel();
        let mut debouncer = new_debouncer(DEBOUNCE, None, sender)?;
        debouncer.watch(dir, RecursiveMode::Recursive)?;
        Ok(Self { _debouncer: debouncer, events })
    }

    /// Whether anything in the folder changed since the last call.
    pub(super) fn changed(&self) -> bool {
        let mut changed = false;
        for result in self.events.try_iter() {
            match result {
                Ok(events) => changed |= events.iter().any(|event| is_change(event.kind)),
                Err(errors) => {
                    errors.iter().for_each(|error| log::warn!("watching files: {error}"));
                    // Events may have been lost, so that only looking tells.
                    changed = true;
                }
            }
        }
        changed
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
