//! Sounds that a game asks for.

#[cfg(feature = "sound")]
use super::speaker::Speaker;
use anyhow::Result;
use bevy_ecs::prelude::Resource;
use lightwell::game::{CurrentScene, Game};
#[cfg(not(feature = "sound"))]
use std::path::Path;

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

/// Plays what the game asked for since the last frame.
///
/// # Errors
/// If a file cannot be read or is no sound; the others are played.
pub(super) fn play_all(game: &mut Game, #[cfg(feature = "sound")] speaker: &Speaker) -> Result<()> {
    let scene = game.world.ecs.resource::<CurrentScene>().clone();
    let mut result = Ok(());
    for (path, volume) in game.world.ecs.resource_mut::<Sounds>().take() {
        let path = scene.beside(path);
        #[cfg(feature = "sound")]
        let played = speaker.play(&path, volume);
        #[cfg(not(feature = "sound"))]
        let played = ignore(&path, volume);
        result = result.and(played);
    }
    result
}

/// Says that there is no sound.
#[cfg(not(feature = "sound"))]
fn ignore(path: &Path, volume: f32) -> Result<()> {
    log::debug!("{} at {volume}: this program was built without sound", path.display());
    Ok(())
}
