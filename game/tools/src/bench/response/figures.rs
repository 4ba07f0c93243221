//! What `bench --response` finds: `response.json`.

use crate::bench::results::Header;
use serde::{Deserialize, Serialize};

/// All results in a folder.
#[derive(Debug, Default, Serialize, Deserialize)]
pub struct Results {
    /// Where and with what they were measured.
    pub header: Header,
    /// The changes.
    pub cases: Vec<CaseFigures>,
    /// The same view twice.
    pub same_view: Option<SameView>,
    /// A closed box in the sun.
    pub sealed: Option<Sealed>,
}

/// How a window follows a change. Lists have a value for each of the frames that are judged.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CaseFigures {
    /// Its name.
    pub name: String,
    /// Its name with the nearest rival.
    pub rival: Option<String>,
    /// How it was measured.
    pub course: String,
    /// Frames until all further ones are near the converged picture; none: the last is not.
    pub within: Option<u32>,
    /// Error of means of 13×13, relative to the mean of the converged picture.
    pub errors: Vec<f64>,
    /// Frames after the change.
    pub frames: u32,
    /// The part of the change of indirect light that is left; empty where the camera moves.
    pub left: Vec<f64>,
    /// 95th percentile of the pixels' distance from the converged picture \[255ths\].
    pub residue: Vec<f64>,
    /// The 99th.
    pub nearly_all: Vec<f64>,
    /// The 95th of the pixels that the change changed; empty where the camera moves.
    pub where_changed: Vec<f64>,
    /// The residue of a window that saw no change, after as many frames as the last that is judged \[255ths\].
    pub rested: f64,
    /// File of a picture.
    pub picture: String,
}

/// The same view twice: 95th percentile and greatest difference of pixels \[255ths\].
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SameView {
    /// How it was measured.
    pub course: String,
    /// Of a window that looked elsewhere in between.
    pub window: [f64; 2],
    /// Of single images.
    pub single: [f64; 2],
}

/// A closed box in the sun: the brightest value \[255ths\], and its radiance [W/(m² sr)].
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Sealed {
    /// How it was measured.
    pub course: String,
    /// In a window.
    pub window: [f64; 2],
    /// In single images.
    pub single: [f64; 2],
}
