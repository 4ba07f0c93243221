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
            Ok(mut device) => {
                device.log_on_drop(false);
                Self(Some(device))
            }
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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn without_a_device_a_game_is_silent_and_goes_on() {
        assert!(Speaker(None).play(Path::new("any.wav"), 1.0).is_ok());
    }

    #[test]
    fn the_sounds_of_the_example_can_be_read() {
        for name in ["lit.wav", "won.wav"] {
            let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/lamplight").join(name);
            let decoder = rodio::Decoder::try_from(File::open(path).unwrap()).unwrap();
            assert!(decoder.map(f32::abs).fold(0.0, f32::max) > 0.05, "{name} can be heard");
        }
    }
}
