//! Figures of a window that measured itself: see `play --measure`.

use anyhow::{Context, Result};
use lightwell::profile::Profiler;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;

/// Frames of a view at rest whose time is told.
pub const RESTED: [u32; 3] = [1, 16, 64];

/// Figures of one window. Times are seconds.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct WindowFigures {
    /// The graphics adapter.
    pub adapter: String,
    /// Size of the picture in the window \[pixels\].
    pub view: [u32; 2],
    /// From the start of the program to the first picture, of direct light.
    pub first_picture: f64,
    /// From the start of the program to the first picture with indirect light.
    pub first_indirect: f64,
    /// Times from one picture to the next while the scene plays.
    pub frames: Vec<f64>,
    /// Size of the last picture while it played \[pixels\].
    pub played_size: [u32; 2],
    /// What a picture takes while the scene plays, in the mean: on the render thread, in the interface, and on the device by
    /// pass (`gpu/…`) \[ms\].
    #[serde(default)]
    pub spent: BTreeMap<String, f64>,
    /// Times from a turn of the camera to the picture that shows it, while the scene plays.
    pub answers: Vec<f64>,
    /// The same of a view that rests, whose picture is being refined.
    pub answers_at_rest: Vec<f64>,
    /// Times from a pause to a picture of so many frames: see [`RESTED`].
    pub rested: Vec<f64>,
}

impl WindowFigures {
    /// Reads them from a file.
    ///
    /// # Errors
    /// If it cannot be read, or holds something else.
    pub fn read(file: &Path) -> Result<Self> {
        let text = std::fs::read_to_string(file).with_context(|| format!("cannot read {}", file.display()))?;
        ron::from_str(&text).with_context(|| format!("{} holds no figures of a window", file.display()))
    }

    /// Writes them into a file.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn write(&self, file: &Path) -> Result<()> {
        let text = ron::ser::to_string_pretty(self, ron::ser::PrettyConfig::default())?;
        std::fs::write(file, text).with_context(|| format!("cannot write {}", file.display()))
    }

    /// Takes up what the last pictures that were counted took, in the mean of them.
    pub fn note_spent(&mut self, profiler: &Profiler) {
        let count = self.frames.len().min(profiler.frames().len());
        for frame in profiler.frames().rev().take(count) {
            for span in &frame.spans {
                *self.spent.entry(span.path.clone()).or_default() += span.duration / count as f64;
            }
        }
    }

    /// Pictures a second while the scene plays.
    pub fn rate(&self) -> f64 {
        self.frames.len() as f64 / self.frames.iter().sum::<f64>().max(1e-9)
    }
}
