//! Notices changed files in a folder.

use notify_debouncer_full::notify::{RecommendedWatcher, RecursiveMode};
use notify_debouncer_full::{DebounceEventResult, Debouncer, RecommendedCache, new_debouncer};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

/// Watches a folder and all below it: watching folders instead of files survives editors that save by rename.
pub(super) struct Watcher {
    _debouncer: Debouncer<RecommendedWatcher, RecommendedCache>,
    events: Receiver<DebounceEventResult>,
}

impl Watcher {
    pub(super) fn new(dir: &Path) -> Result<Self, notify_debouncer_full::notify::Error> {
        let (sender, events) = channel();
        let mut debouncer = new_debouncer(Duration::from_millis(100), None, sender)?;
        debouncer.watch(dir, RecursiveMode::Recursive)?;
        Ok(Self { _debouncer: debouncer, events })
    }

    /// Files that changed since the last call and exist.
    pub(super) fn changed(&self) -> BTreeSet<PathBuf> {
        let mut paths = BTreeSet::new();
        for result in self.events.try_iter() {
            match result {
                Ok(events) => paths.extend(events.into_iter().flat_map(|event| event.event.paths)),
                Err(errors) => errors.iter().for_each(|error| log::warn!("watching files: {error}")),
            }
        }
        paths.retain(|path| path.is_file());
        paths
    }
}
