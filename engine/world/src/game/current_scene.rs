//! The scene that a game is in.

use bevy_ecs::prelude::Resource;
use std::path::{Path, PathBuf};

/// The scene that is played.
#[derive(Resource, Clone, Debug, Default, PartialEq, Eq)]
pub struct CurrentScene {
    /// Its file.
    pub path: PathBuf,
    /// The step of the game in which it was entered.
    pub since: u64,
}

impl CurrentScene {
    /// A path that is relative to the scene's folder.
    pub fn beside(&self, path: impl AsRef<Path>) -> PathBuf {
        self.path.parent().unwrap_or(Path::new("")).join(path)
    }

    /// The file's name without `.scene.ron`.
    pub fn name(&self) -> String {
        let name = self.path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        name.strip_suffix(".scene.ron").map_or(name.clone(), str::to_owned)
    }
}
