//! What `bench --noise` finds: `noise.json`.

use super::measures::{Jumps, Noise};
use crate::bench::results::{Header, finite};
use serde::{Deserialize, Serialize};

/// All results in a folder.
#[derive(Debug, Default, Serialize, Deserialize)]
pub struct Results {
    /// Where and with what they were measured.
    pub header: Header,
    /// The scenes.
    pub scenes: Vec<SceneFigures>,
}

/// The figures of a scene.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SceneFigures {
    /// Its name.
    pub name: String,
    /// How it was measured.
    pub course: String,
    /// Frames in the converged image.
    pub frames: u32,
    /// Noise of its indirect light away from edges.
    pub noise: f64,
    /// Whether the limit of frames came before that was a quarter of the least error.
    pub limited: bool,
    /// Share of the pixels that are near a geometric edge.
    pub near_edges: f64,
    /// Bias of the converged image against the path tracer: of indirect and of all light.
    pub bias: [f64; 2],
    /// The images.
    pub rows: Vec<Row>,
    /// Blocks that jump.
    pub jumps: Vec<JumpFigures>,
    /// Difference of one image from its average in flat parts \[255ths\].
    pub flat: Option<f64>,
    /// Files of pictures.
    pub pictures: Vec<String>,
    /// Time that it took [s].
    pub seconds: f64,
}

/// An image against the converged one.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// What was drawn.
    pub what: String,
    /// The number of the frame, from 1.
    pub frame: u32,
    /// Indirect light.
    pub indirect: LayerNoise,
    /// All light.
    pub total: LayerNoise,
}

/// A layer of light of an image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LayerNoise {
    /// Near geometric edges; none if there are none.
    pub edges: Option<Noise>,
    /// Elsewhere.
    pub elsewhere: Option<Noise>,
    /// Relative error of the mean against the converged image.
    #[serde(with = "finite")]
    pub shift: f64,
    /// The same against the path tracer.
    #[serde(with = "finite")]
    pub bias: f64,
    /// Mean FLIP against the converged image.
    pub flip: f64,
}

/// Jumping blocks of a row of frames.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct JumpFigures {
    /// How the frames were drawn.
    pub what: String,
    /// The blocks.
    pub jumps: Jumps,
}
