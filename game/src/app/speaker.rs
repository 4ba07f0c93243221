//! Sounds made heard.

use anyhow::{Context, Result};
use rodio::{DeviceSinkBuilder, MixerDeviceSink};
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

/// The sound device; none where there is no such, which is said once.
pub struct Speaker(Option<MixerDeviceSink>);

impl Speaker {
    /// Opens the device.
    pub fn open() -> Self {
        match DeviceSinkBuilder::open_default_sink() {
            Ok(device) => Self(Some(device)),
            Err(error) => {
                log::warn!("no sound: {error}");
                Self(None)
            }
        }
    }

    /// Plays a file once, beside what is playing.
    ///
    /// # Errors
    /// If it cannot be read or is no sound.
    pub fn play(&self, path: &Path, volume: f32) -> Result<()> {
        let Some(device) = &self.0 else { return Ok(()) };
        let file = File::open(path).with_context(|| format!("the sound {} cannot be read", path.display()))?;
        let player = rodio::play(device.mixer(), BufReader::new(file))
            .with_context(|| format!("{} is no sound that can be played", path.display()))?;
        player.set_volume(volume.clamp(0.0, 1.0));
        player.detach();
        Ok(())
    }
}
