//! Measurements of growth, as `results.json` holds them.

use crate::bench::results::Spread;
use serde::{Deserialize, Serialize};

/// Cost over the number of something.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Growth {
    /// The axis.
    pub axis: String,
    /// How it is drawn.
    pub series: String,
    /// By their numbers, rising.
    pub points: Vec<GrowthPoint>,
}

impl Growth {
    /// Whether it is that curve.
    pub fn is(&self, axis: &str, series: &str) -> bool {
        self.axis == axis && self.series == series
    }
}

/// A scene that holds so many of something.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct GrowthPoint {
    /// How many.
    pub count: u64,
    /// Why there is no figure.
    pub refused: Option<String>,
    /// Time to load the scene [ms].
    pub load_ms: f64,
    /// Time of a frame in which everything is computed, from start to end [ms].
    pub frame: Spread,
    /// Its time on the device [ms].
    pub device: Spread,
    /// Time to record its commands [ms].
    pub record: Spread,
    /// Time of a frame in which nothing has changed [ms].
    pub still: Spread,
    /// Time of a frame before which one object was moved, with the scene's update [ms].
    pub moved: Spread,
    /// Draw calls of the whole frame.
    pub draws: u64,
    /// Triangles drawn in it.
    pub triangles: u64,
    /// Memory of the frame's targets and buffers [bytes].
    pub target_bytes: u64,
    /// Growth of the process since the curve began [bytes].
    pub process_bytes: Option<u64>,
}

/// Two scenes, drawn alternately.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Pair {
    /// Name.
    pub name: String,
    /// Their description; the first must cost at most `bound` times the second.
    pub of: [String; 2],
    /// The greatest ratio that is good.
    pub bound: f64,
    /// Time of a frame in which everything is computed, from start to end [ms].
    pub frame: [Spread; 2],
    /// Its time on the device [ms].
    pub device: [Spread; 2],
    /// Time to record its commands [ms].
    pub record: [Spread; 2],
    /// Draw calls.
    pub draws: [u64; 2],
}
