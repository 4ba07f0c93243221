//! What is remembered from run to run: layout, recent files, cameras. It lies in the user's configuration folder.

use crate::editor::camera::Pose;
use lightwell::files::replace_file;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Most scenes that are remembered.
const MOST: usize = 12;

/// What is remembered.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Memory {
    /// Panels.
    pub layout: Option<String>,
    /// Whether they are hidden.
    pub hidden: bool,
    /// Scale of the interface.
    pub zoom: f32,
    /// Size of the window \[pixels\].
    pub window: Option<[u32; 2]>,
    /// Scenes, the last first.
    pub recent: Vec<PathBuf>,
    /// Where the camera of a scene was flown to.
    pub cameras: BTreeMap<PathBuf, Pose>,
    /// Bookmarks of a scene.
    pub bookmarks: BTreeMap<PathBuf, [Option<Pose>; 4]>,
}

impl Default for Memory {
    fn default() -> Self {
        Self {
            layout: None,
            hidden: false,
            zoom: 1.0,
            window: None,
            recent: Vec::new(),
            cameras: BTreeMap::new(),
            bookmarks: BTreeMap::new(),
        }
    }
}

impl Memory {
    /// The file, if the system has a place for it.
    pub fn file() -> Option<PathBuf> {
        Some(directories::ProjectDirs::from("", "", "lightwell")?.config_dir().join("play.ron"))
    }

    /// Reads it; what cannot be read is as good as nothing.
    pub fn read(file: &Path) -> Self {
        let text = std::fs::read_to_string(file).unwrap_or_default();
        if text.is_empty() {
            return Self::default();
        }
        let read = ron::from_str::<Self>(&text);
        let mut memory = read.unwrap_or_else(|error| {
            log::warn!("{}: {error}; the usual layout is used", file.display());
            Self::default()
        });
        memory.zoom = if memory.zoom.is_finite() { memory.zoom.clamp(0.5, 4.0) } else { 1.0 };
        memory
    }

    /// Writes it in one step.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write(&self, file: &Path) -> std::io::Result<()> {
        let folder = file.parent().unwrap_or(Path::new("."));
        std::fs::create_dir_all(folder)?;
        let text = ron::to_string(self).map_err(std::io::Error::other)?;
        replace_file(file, text.as_bytes())
    }

    /// Puts a scene first.
    pub fn played(&mut self, scene: &Path) {
        let scene = key(scene);
        self.recent.retain(|known| *known != scene);
        self.recent.insert(0, scene);
        self.recent.truncate(MOST);
        let recent = self.recent.clone();
        self.cameras.retain(|known, _| recent.contains(known));
        self.bookmarks.retain(|known, _| recent.contains(known));
    }
}

/// The name that a scene is remembered under.
pub fn key(scene: &Path) -> PathBuf {
    scene.canonicalize().unwrap_or_else(|_| scene.to_owned())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn what_was_written_is_read() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("deep/play.ron");
        let mut memory = Memory { zoom: 2.0, layout: Some("x".into()), ..Memory::default() };
        (0..20).for_each(|i| memory.played(Path::new(&format!("/nowhere/{i}.scene.ron"))));
        memory.write(&file).unwrap();
        assert_eq!(Memory::read(&file), memory);
        assert_eq!((memory.recent.len(), memory.recent[0].ends_with("19.scene.ron")), (MOST, true));
        std::fs::write(&file, "nonsense").unwrap();
        assert_eq!(Memory::read(&file), Memory::default());
    }
}
