//! Sounds that a game asks for.

use bevy_ecs::prelude::Resource;

/// Plays sounds: files beside the scene. They are heard in a window, in programs built with the feature `sound`;
/// elsewhere they are asked for in vain, so that a game is the same everywhere.
#[derive(Resource, Clone, Debug, Default, PartialEq)]
pub struct Sounds(Vec<(String, f32)>);

impl Sounds {
    /// Plays a file (`.ogg` or `.wav`, its path relative to the scene's folder) once, 0: silent, 1: as it is.
    pub fn play(&mut self, path: impl Into<String>, volume: f32) {
        self.0.push((path.into(), volume));
    }

    /// What was asked for since the last frame.
    pub fn asked_for(&self) -> &[(String, f32)] {
        &self.0
    }

    pub(super) fn take(&mut self) -> Vec<(String, f32)> {
        std::mem::take(&mut self.0)
    }
}
