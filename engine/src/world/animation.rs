//! Animation as data: tracks that say where an entity is at a time, as scene files hold them.
//!
//! An animation is a function of the clock alone. It never adds to what it wrote before: frame t is the same however
//! it was reached, and the pose without animation is kept in [`super::RestPose`].

use super::rest::RestPose;
use bevy_ecs::prelude::*;
use glam::{EulerRot, Quat, Vec3};
use serde::de::{Error, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Longest period and latest key \[s\].
const MAX_TIME: f64 = 1e9;
/// Shortest period \[s\].
const MIN_PERIOD: f64 = 1e-6;

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
        /// What the values are for; it takes the place of the entity's own value.
        target: Target,
        /// Time \[s\], from 0, growing; and value: a number, (x, y, z) or (x, y, z, w), as the target wants it.
        keys: Vec<(f64, KeyValue)>,
        /// What lies between keys.
        #[serde(default)]
        interpolation: Interpolation,
        /// What comes after the last key. Before the first key its value holds.
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
        /// What comes after the clip's last key.
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

/// What a key-framed track changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Target {
    /// Translation \[m\], (x, y, z).
    Translation,
    /// Rotation: (x, y, z) in degrees, applied Z first, then X, then Y; or a quaternion (x, y, z, w).
    Rotation,
    /// Scale: (x, y, z), or one number for all three.
    Scale,
    /// Intensity of the entity's light, a number.
    LightIntensity,
    /// Colour of the entity's light, linear (r, g, b).
    LightColor,
    /// Distance beyond which the entity's light does not reach \[m\], a number.
    LightRange,
    /// Half angle of full intensity of the entity's spot light \[degrees\], a number.
    LightInner,
    /// Half angle beyond which the entity's spot light does not shine \[degrees\], a number.
    LightOuter,
    /// Vertical field of view of the entity's camera \[degrees\], a number.
    CameraFov,
    /// Radiance that the entity's own material emits [W/(m² sr)], linear (r, g, b).
    MaterialEmissive,
    /// Base colour of the entity's own material, linear (r, g, b).
    MaterialColor,
    /// Alpha of the entity's own material, a number.
    MaterialAlpha,
    /// Metallic of the entity's own material, a number.
    MaterialMetallic,
    /// Roughness of the entity's own material, a number.
    MaterialRoughness,
    /// Whether the entity's own mesh is drawn: where the number is ½ or more.
    Visible,
}

/// What lies between two keys.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Interpolation {
    /// The value of the last key that has passed.
    Step,
    /// A straight line; the shortest arc for rotations.
    #[default]
    Linear,
    /// A cubic Hermite spline with tangents from the neighbouring keys (Catmull-Rom over uneven times); smooth over
    /// the seam of a loop whose last value equals its first.
    Cubic,
}

/// What a key-framed track does after its last key.
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

/// Value of a key.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum KeyValue {
    /// A number.
    Scalar(f32),
    /// (x, y, z), (r, g, b) or Euler angles \[degrees\].
    Vector(Vec3),
    /// A quaternion (x, y, z, w); need not be of unit length.
    Quaternion(Quat),
}

impl Serialize for KeyValue {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Scalar(v) => v.serialize(serializer),
            Self::Vector(v) => v.to_array().serialize(serializer),
            Self::Quaternion(q) => q.to_array().serialize(serializer),
        }
    }
}

impl<'de> Deserialize<'de> for KeyValue {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(KeyValueVisitor)
    }
}

struct KeyValueVisitor;

impl<'de> Visitor<'de> for KeyValueVisitor {
    type Value = KeyValue;

    fn expecting(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.write_str("a number, (x, y, z) or (x, y, z, w)")
    }
    fn visit_f64<E: Error>(self, v: f64) -> Result<KeyValue, E> {
        Ok(KeyValue::Scalar(v as f32))
    }
    fn visit_i64<E: Error>(self, v: i64) -> Result<KeyValue, E> {
        Ok(KeyValue::Scalar(v as f32))
    }
    fn visit_u64<E: Error>(self, v: u64) -> Result<KeyValue, E> {
        Ok(KeyValue::Scalar(v as f32))
    }
    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<KeyValue, A::Error> {
        let mut values: Vec<f32> = Vec::with_capacity(4);
        while let Some(value) = seq.next_element()? {
            values.push(value);
        }
        match values[..] {
            [x, y, z] => Ok(KeyValue::Vector(Vec3::new(x, y, z))),
            [x, y, z, w] => Ok(KeyValue::Quaternion(Quat::from_xyzw(x, y, z, w))),
            _ => Err(A::Error::invalid_length(values.len(), &self)),
        }
    }
}

/// The rotation of Euler angles \[degrees\], as scene files have them: Z first, then X, then Y.
pub fn rotation_from_degrees(degrees: Vec3) -> Quat {
    let r = degrees.to_array().map(f32::to_radians);
    Quat::from_euler(EulerRot::YXZ, r[1], r[0], r[2])
}

/// Why an animation cannot be played. Tracks and keys count from 0.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum AnimationError {
    /// Speed or offset is out of bounds.
    #[error("{field} is {value}: it must be a number from -1e6 to 1e6")]
    Timing {
        /// The field.
        field: &'static str,
        /// Its value.
        value: f64,
    },
    /// An axis has no direction.
    #[error("track {track}: axis {axis} has no direction: give three finite numbers that are not all zero")]
    Axis {
        /// The track.
        track: usize,
        /// Its axis.
        axis: Vec3,
    },
    /// A number is not finite or out of bounds.
    #[error("track {track}: {field} is {value}: it must be {expected}")]
    Number {
        /// The track.
        track: usize,
        /// The field.
        field: &'static str,
        /// Its value.
        value: f64,
        /// What it must be.
        expected: &'static str,
    },
    /// A track of keys has none.
    #[error("track {track} has no keys: give at least one (time, value), or remove the track")]
    NoKeys {
        /// The track.
        track: usize,
    },
    /// Key times do not grow.
    #[error(
        "track {track}, key {key}: time {time} does not come after {before}, that of the key before: sort the keys"
    )]
    Unsorted {
        /// The track.
        track: usize,
        /// The key.
        key: usize,
        /// Its time \[s\].
        time: f64,
        /// Time of the key before \[s\].
        before: f64,
    },
    /// A key's time is out of bounds.
    #[error("track {track}, key {key}: time {time} must be from 0 to 1e9 seconds")]
    Time {
        /// The track.
        track: usize,
        /// The key.
        key: usize,
        /// Its time \[s\].
        time: f64,
    },
    /// A key's value is of the wrong kind for the target, or not finite.
    #[error("track {track}, key {key}: {target:?} wants {expected}")]
    Value {
        /// The track.
        track: usize,
        /// The key.
        key: usize,
        /// The track's target.
        target: Target,
        /// What it wants.
        expected: &'static str,
    },
}

impl Animation {
    /// Checks all that would make the animation meaningless.
    ///
    /// # Errors
    /// The first fault, with its track and key. An animation that has one is not played.
    pub fn validate(&self) -> Result<(), AnimationError> {
        for (field, value) in [("speed", self.speed), ("offset", self.offset)] {
            // Written so that NaN fails.
            if !(-1e6..=1e6).contains(&value) {
                return Err(AnimationError::Timing { field, value });
            }
        }
        self.tracks.iter().enumerate().try_for_each(|(i, track)| track.validate(i))
    }
}

impl Track {
    fn validate(&self, track: usize) -> Result<(), AnimationError> {
        let number = |field, value: f64, valid, expected| {
            if valid { Ok(()) } else { Err(AnimationError::Number { track, field, value, expected }) }
        };
        match self {
            Self::Spin { axis, degrees_per_second: rate } => {
                check_axis(track, *axis)?;
                let valid = *rate == 0.0 || (360.0 / MAX_TIME..=360.0 / MIN_PERIOD).contains(&rate.abs());
                number("degrees_per_second", *rate, valid, "0, or from 3.6e-7 to 3.6e8 (or the negative of that)")
            }
            Self::Orbit { center, axis, radius, period, phase, .. } => {
                check_axis(track, *axis)?;
                for value in center.to_array() {
                    number("center", value.into(), value.is_finite(), "finite")?;
                }
                number("radius", (*radius).into(), radius.is_finite() && *radius >= 0.0, "finite and not negative")?;
                number("phase", (*phase).into(), phase.is_finite(), "finite")?;
                let valid = (MIN_PERIOD..=MAX_TIME).contains(&period.abs());
                number("period", *period, valid, "from 1e-6 to 1e9 seconds (or the negative of that)")
            }
            Self::Keys { target, keys, .. } => check_keys(track, *target, keys),
            Self::Clip { speed, offset, .. } => {
                for (field, value) in [("speed", *speed), ("offset", *offset)] {
                    number(field, value, (-1e6..=1e6).contains(&value), "a number from -1e6 to 1e6")?;
                }
                Ok(())
            }
        }
    }
}

fn check_axis(track: usize, axis: Vec3) -> Result<(), AnimationError> {
    if axis.try_normalize().is_some() { Ok(()) } else { Err(AnimationError::Axis { track, axis }) }
}

fn check_keys(track: usize, target: Target, keys: &[(f64, KeyValue)]) -> Result<(), AnimationError> {
    if keys.is_empty() {
        return Err(AnimationError::NoKeys { track });
    }
    for (key, (time, value)) in keys.iter().enumerate() {
        let time = *time;
        if !(0.0..=MAX_TIME).contains(&time) {
            return Err(AnimationError::Time { track, key, time });
        }
        if let Some((before, _)) = key.checked_sub(1).and_then(|k| keys.get(k)).filter(|(before, _)| *before >= time) {
            return Err(AnimationError::Unsorted { track, key, time, before: *before });
        }
        target.check(*value).map_err(|expected| AnimationError::Value { track, key, target, expected })?;
    }
    // Shorter than this a loop has no frames.
    let last = keys[keys.len() - 1].0;
    if keys.len() > 1 && last < MIN_PERIOD {
        return Err(AnimationError::Number {
            track,
            field: "time of the last key",
            value: last,
            expected: "at least 1e-6 seconds",
        });
    }
    Ok(())
}

impl Target {
    /// Whether its values are single numbers.
    pub fn is_number(self) -> bool {
        match self {
            Self::LightIntensity
            | Self::LightRange
            | Self::LightInner
            | Self::LightOuter
            | Self::CameraFov
            | Self::MaterialAlpha
            | Self::MaterialMetallic
            | Self::MaterialRoughness
            | Self::Visible => true,
            Self::Translation
            | Self::Rotation
            | Self::Scale
            | Self::LightColor
            | Self::MaterialEmissive
            | Self::MaterialColor => false,
        }
    }

    fn check(self, value: KeyValue) -> Result<(), &'static str> {
        let (valid, expected) = match (self, value) {
            (Self::Rotation, KeyValue::Quaternion(q)) => {
                let length = q.length_squared();
                (length.is_finite() && length > 1e-20, "a quaternion that is finite and not zero")
            }
            (Self::Rotation, KeyValue::Vector(v)) => (v.is_finite(), "finite numbers"),
            (Self::Rotation, _) => (false, "(x, y, z) in degrees or a quaternion (x, y, z, w)"),
            (target, KeyValue::Scalar(v)) if target.is_number() || target == Self::Scale => {
                (v.is_finite(), "a finite number")
            }
            (target, _) if target.is_number() => (false, "one number"),
            (_, KeyValue::Vector(v)) => (v.is_finite(), "finite numbers"),
            (Self::Scale, _) => (false, "(x, y, z) or one number"),
            _ => (false, "(x, y, z)"),
        };
        if valid { Ok(()) } else { Err(expected) }
    }
}
