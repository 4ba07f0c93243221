//! Animation as data: tracks that say where an entity is at a time, as scene files hold them.
//!
//! An animation is a function of the clock alone. It never adds to what it wrote before: frame t is the same however
//! it was reached, and the pose without animation is kept in [`super::RestPose`].

mod key;
mod target;
mod validate;

pub use key::{KeyValue, rotation_from_degrees};
pub use target::Target;
pub(super) use target::{Meaning, Part, SurfaceField};
pub use validate::AnimationError;

use super::rest_pose::RestPose;
use bevy_ecs::prelude::*;
use glam::Vec3;
use serde::{Deserialize, Serialize};

/// Moves an entity, or changes its light, camera or material, as a function of the clock.
///
/// The track's time is `speed · clock + offset`. Later tracks act on what earlier ones made.
#[derive(Component, Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
#[require(RestPose)]
pub struct Animation {
    /// The tracks, in the order in which they act.
    pub tracks: Vec<Track>,
    /// Whether it plays. The entity is in its rest pose otherwise.
    pub playing: bool,
    /// Seconds of the tracks in a second of the clock; negative runs backwards.
    pub speed: f64,
    /// Time of the tracks when the clock is at zero \[s\].
    pub offset: f64,
}

impl Default for Animation {
    fn default() -> Self {
        Self { tracks: Vec::new(), playing: true, speed: 1.0, offset: 0.0 }
    }
}

/// One motion.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum Track {
    /// Turns about an axis through the entity's origin, on top of its rotation.
    Spin {
        /// Axis in the entity's own space; need not be of unit length.
        axis: Vec3,
        /// Angular speed [degrees/s], counter-clockwise seen from the axis's tip. The time of a turn is rounded to
        /// flicks (1/705,600,000 s), so that whole turns close exactly.
        degrees_per_second: f64,
    },
    /// Moves along a circle, instead of the entity's translation.
    Orbit {
        /// Centre in the parent's space \[m\].
        #[serde(default)]
        center: Vec3,
        /// Axis in the parent's space; need not be of unit length.
        #[serde(default = "up")]
        axis: Vec3,
        /// Radius \[m\].
        radius: f32,
        /// Time of one round \[s\]; negative runs backwards.
        period: f64,
        /// Angle at time zero \[degrees\]. Angle 0 is towards +X (towards +Z if the axis is ±X), and it grows
        /// counter-clockwise seen from the axis's tip.
        #[serde(default)]
        phase: f32,
        /// Turns the entity so that −Z looks at the centre and +Y along the axis, instead of its rotation.
        #[serde(default)]
        look_at_center: bool,
    },
    /// Values at times, and what lies between.
    Keys {
        /// Whose values they are: an entity below this one, such as a node of its model, by its name or by the path of
        /// names from here, `hip/knee`. The entity itself if it is left out.
        #[serde(default, skip_serializing_if = "String::is_empty")]
        node: String,
        /// The animated value; keys replace the entity's own value.
        target: Target,
        /// Time \[s\], from 0, growing; and value: a number, (x, y, z), (x, y, z, w) or true, as the target wants it.
        keys: Vec<(f64, KeyValue)>,
        /// Interpolation between keys.
        #[serde(default)]
        interpolation: Interpolation,
        /// Values after the last key. Before the first key its value holds.
        #[serde(default)]
        wrap: Wrap,
    },
    /// Plays a clip of the model that the entity holds.
    Clip {
        /// Name of the clip; the first if it is left out.
        #[serde(default, skip_serializing_if = "String::is_empty")]
        name: String,
        /// Seconds of the clip in a second of the tracks; negative runs backwards.
        #[serde(default = "one")]
        speed: f64,
        /// Time of the clip when the tracks are at zero \[s\].
        #[serde(default)]
        offset: f64,
        /// Values after the clip's last key.
        #[serde(default)]
        wrap: Wrap,
    },
}

fn one() -> f64 {
    1.0
}

fn up() -> Vec3 {
    Vec3::Y
}

/// Interpolation between two keys.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Interpolation {
    /// The value of the last key that has passed.
    Step,
    /// A straight line; the shortest arc for rotations.
    #[default]
    Linear,
    /// A cubic Hermite spline with tangents from the neighbouring keys (Catmull-Rom over uneven times); smooth over
    /// the seam of a loop whose last value equals its first. Where no key of a field is negative the spline is not.
    Cubic,
}

/// Behaviour of a key-framed track after its last key.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Wrap {
    /// Holds the last value.
    Once,
    /// Starts again: the time of the last key is the time of the first round's end.
    #[default]
    Loop,
    /// Runs back, then forth again.
    PingPong,
}
