//! What a window remembers of its scenes.

use super::memory;
use super::player::Player;

impl Player {
    /// Takes over what an earlier run remembered.
    pub(super) fn recall(&mut self) {
        if let Some(layout) = &self.memory.layout {
            self.editor.restore_layout(layout);
        }
        self.editor.hidden = self.memory.hidden;
        self.ui.context.set_zoom_factor(self.memory.zoom);
    }

    /// A scene was opened: what is remembered of it comes back.
    pub(super) fn opened(&mut self) {
        let key = memory::key(self.session.path());
        self.camera.go(self.memory.cameras.get(&key).copied());
        self.editor.view.bookmarks = self.memory.bookmarks.get(&key).copied().unwrap_or_default();
        self.memory.played(&key);
        self.editor.recent.clone_from(&self.memory.recent);
        self.set_title();
    }

    /// Notes what is to be remembered of the scene.
    pub(super) fn note(&mut self) {
        let key = memory::key(self.session.path());
        // While a game plays, its camera is looked through.
        let camera = self.play.as_ref().map_or(&self.camera, |play| &play.camera);
        match camera.place() {
            Some(place) => drop(self.memory.cameras.insert(key.clone(), place)),
            None => drop(self.memory.cameras.remove(&key)),
        }
        if self.editor.view.bookmarks.iter().any(Option::is_some) {
            self.memory.bookmarks.insert(key, self.editor.view.bookmarks);
        }
    }

    /// Writes what is to be remembered.
    pub fn remember(&mut self) {
        self.note();
        self.memory.layout = self.editor.layout_text();
        self.memory.hidden = self.editor.hidden;
        self.memory.zoom = self.ui.context.zoom_factor();
        self.memory.window = self.screen.size();
        if let Some(file) = &self.memory_file
            && let Err(error) = self.memory.write(file)
        {
            log::warn!("{}: {error}; layout and recent files are not remembered", file.display());
        }
    }
}
