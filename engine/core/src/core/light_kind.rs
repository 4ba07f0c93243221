//! Kinds of light sources.

use serde::{Deserialize, Serialize};
use std::ops::RangeInclusive;

/// Kind of light with the parameters that only it has.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum LightKind {
    /// Parallel light along the entity's −Z. Intensity: irradiance E [W/m²].
    Directional,
    /// All directions alike. Intensity: radiant intensity I [W/sr].
    Point,
    /// A cone along −Z. Intensity: radiant intensity I on the axis [W/sr].
    Spot {
        /// Half angle of full intensity \[degrees\].
        inner: f32,
        /// Half angle beyond which there is no light \[degrees\].
        outer: f32,
    },
    /// Parallel light along −Z, but for the width of a disc in the sky: shadows are soft. Intensity: irradiance E [W/m²].
    Sun {
        /// Angle under which the disc is seen \[degrees\]; 0.53 for the sun as seen from the earth.
        angle: f32,
    },
    /// A sphere. Intensity: radiant intensity I [W/sr], of a point light that is as bright from afar.
    Sphere {
        /// Radius \[m\].
        radius: f32,
    },
    /// A disc that shines along −Z, on one side. Intensity: radiant intensity I along −Z [W/sr].
    Disc {
        /// Radius \[m\].
        radius: f32,
    },
    /// A rectangle that shines along −Z, on one side. Intensity: radiant intensity I along −Z [W/sr].
    Rectangle {
        /// Edge along X \[m\].
        width: f32,
        /// Edge along Y \[m\].
        height: f32,
    },
    /// A tube along X, dark at its ends. Intensity: radiant intensity I at right angles to it [W/sr].
    Tube {
        /// Length \[m\].
        length: f32,
        /// Radius \[m\].
        radius: f32,
    },
}

impl LightKind {
    /// Sizes that a light may have \[m\]. As small as that it is a point light.
    pub const SIZES: RangeInclusive<f32> = 1e-6..=1e6;
    /// Angles under which a sun may be seen \[degrees\].
    pub const ANGLES: RangeInclusive<f32> = 1e-3..=90.0;
}
