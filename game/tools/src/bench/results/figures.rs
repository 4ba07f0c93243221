//! The rows of `results.json`: a measurement each.

use crate::bench::variant::SweepPoint;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// One of the things that are compared.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct VariantFigures {
    /// Name.
    pub name: String,
    /// Description.
    pub what: String,
    /// Whether it traces paths.
    pub traced: bool,
    /// The sweep that it is a point of, with the scene where its settings depend on that.
    pub sweep: Option<SweepPoint>,
    /// The only scene that it is for.
    pub scene: Option<String>,
}

/// A scene in numbers.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SceneFigures {
    /// Name.
    pub name: String,
    /// Primitives drawn.
    pub primitives: usize,
    /// Triangles of all primitives.
    pub triangles: usize,
    /// Lights in words: `1 spot`.
    pub lights: String,
    /// Light propagation volumes in words.
    pub volumes: String,
    /// Size of the light propagation volumes in cells, all cascades together.
    pub cells: Option<u64>,
    /// Propagation steps.
    pub steps: Option<u32>,
}

/// Median, least and greatest of some values.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Spread {
    /// Median.
    pub median: f64,
    /// Least.
    pub min: f64,
    /// Greatest.
    pub max: f64,
}

impl Spread {
    /// Of some values; none of no values.
    pub fn of(values: &[f64]) -> Option<Self> {
        let mut sorted = values.to_vec();
        sorted.sort_by(f64::total_cmp);
        let (&min, &max) = (sorted.first()?, sorted.last()?);
        let middle = sorted.len() / 2;
        let median = if sorted.len() % 2 == 1 { sorted[middle] } else { 0.5 * (sorted[middle - 1] + sorted[middle]) };
        Some(Self { median, min, max })
    }
}

/// The part of a frame that is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Mode {
    /// Everything, in every frame.
    Full,
    /// Changes since the frame before; the scene's clock runs.
    Animated,
    /// Effects of the shift of the pixels: an image that is averaged with others of the same scene.
    Shifted,
}

/// Counts by name.
pub type CountMap = BTreeMap<String, u64>;

/// Times of one variant in one scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Timing {
    /// All that it depends on.
    pub key: String,
    /// Scene.
    pub scene: String,
    /// Variant.
    pub variant: String,
    /// Image size [pixels].
    pub size: [u32; 2],
    /// The part that was computed.
    pub mode: Mode,
    /// Frames measured.
    pub frames: usize,
    /// Time of each stage on the device [ms].
    pub stages: BTreeMap<String, Spread>,
    /// Time of all stages on the device [ms]; of path tracing the time from start to end.
    pub total: Spread,
    /// Time of the frame from start to end [ms].
    pub wall: Spread,
    /// Counts of each stage in the first measured frame.
    pub counts: BTreeMap<String, CountMap>,
    /// Merges of blocker volumes in the first measured frame.
    pub merges: Option<u64>,
    /// Passes that the table of stages does not know.
    pub unknown_passes: Vec<String>,
    /// Memory that the frame's targets take [bytes].
    pub allocated_bytes: u64,
    /// Most memory that the whole process took so far [bytes].
    pub peak_bytes: Option<u64>,
}

/// Errors of one layer of light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LayerError {
    /// Mean of the reference [W/(m² sr)].
    pub mean: f64,
    /// Root mean square error, without the reference's noise.
    pub rmse: f64,
    /// The same, relative to the mean.
    #[serde(with = "super::finite")]
    pub nrmse: f64,
    /// The same with the reference's noise in it.
    #[serde(with = "super::finite")]
    pub noisy_nrmse: f64,
    /// Relative error of the mean.
    #[serde(with = "super::finite")]
    pub bias: f64,
    /// 95th percentile of the relative error.
    #[serde(with = "super::finite")]
    pub p95: f64,
    /// Mean FLIP.
    pub flip: f64,
    /// Noise of the reference, relative to its mean.
    #[serde(with = "super::finite")]
    pub noise: f64,
}

/// Errors of one variant in one scene at one time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ErrorFigures {
    /// All that it depends on.
    pub key: String,
    /// Scene.
    pub scene: String,
    /// Variant.
    pub variant: String,
    /// Time [s].
    pub time: f64,
    /// Image size [pixels].
    pub size: [u32; 2],
    /// Frames averaged.
    pub aa: u32,
    /// Indirect bounces of the reference; none: unlimited.
    pub bounces: Option<u32>,
    /// Samples a pixel of the reference.
    pub reference_spp: u32,
    /// All light.
    pub total: LayerError,
    /// Direct light.
    pub direct: LayerError,
    /// Indirect light.
    pub indirect: LayerError,
    /// Images, relative to the folder of the results.
    pub pictures: Vec<String>,
}

/// Flicker of one variant.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Flicker {
    /// All that it depends on.
    pub key: String,
    /// Scene.
    pub scene: String,
    /// Variant.
    pub variant: String,
    /// Frames.
    pub frames: u32,
    /// Root mean square of the frame-to-frame change of indirect light beyond the reference's, over the mean.
    #[serde(with = "super::finite")]
    pub change: f64,
    /// The reference's own change in the same measure.
    #[serde(with = "super::finite")]
    pub reference: f64,
    /// Flicker that is no steady change: second differences over √3, beyond the reference's, over the mean. Noise that is
    /// another one in each frame has as much of it as of change, a steady change none.
    #[serde(default)]
    pub tremble: Option<f64>,
    /// The reference's own in the same measure.
    #[serde(default)]
    pub reference_tremble: Option<f64>,
    /// Error of the frames, each against the reference of its time: root mean square over the mean.
    #[serde(default)]
    pub error: Option<f64>,
    /// Their mean over the reference's, less 1.
    #[serde(default)]
    pub bias: Option<f64>,
    /// Error of all light of the frames, in the same measure.
    #[serde(default)]
    pub total_error: Option<f64>,
    /// Its mean over the reference's, less 1.
    #[serde(default)]
    pub total_bias: Option<f64>,
    /// The change, where each frame is averaged over shifts by parts of a pixel.
    #[serde(default)]
    pub smooth: Option<f64>,
    /// The image of it, relative to the folder of the results.
    #[serde(default)]
    pub picture: Option<String>,
}

/// Path tracing on the device against the host over the same hierarchies.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ThroughputFigures {
    /// All that it depends on.
    pub key: String,
    /// Scene.
    pub scene: String,
    /// Paths that each traced.
    pub paths: u64,
    /// Threads of the host.
    pub threads: usize,
    /// Paths a second on the device.
    pub device: f64,
    /// Paths a second on the host.
    pub host: f64,
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn spreads() {
        assert_eq!(Spread::of(&[]), None);
        assert_eq!(Spread::of(&[3.0, 1.0, 2.0]), Some(Spread { median: 2.0, min: 1.0, max: 3.0 }));
        assert_eq!(Spread::of(&[4.0, 1.0]).unwrap().median, 2.5);
    }
}
