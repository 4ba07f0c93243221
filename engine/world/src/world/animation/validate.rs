//! Validation of animations.

use super::target::Meaning;
use super::{Animation, KeyValue, Target, Track};
use glam::Vec3;

/// Longest period and latest key \[s\].
const MAX_TIME: f64 = 1e9;
/// Shortest period \[s\].
const MIN_PERIOD: f64 = 1e-6;
/// Highest number of a morph target.
const MAX_MORPH_TARGET: u32 = 65_535;

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
        /// The required form.
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
    /// A path names nothing.
    #[error("track {track}: `{path}` is no path of a field: write COMPONENT.FIELD, such as light.casts_shadow")]
    Path {
        /// The track.
        track: usize,
        /// Its path.
        path: String,
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
        /// The type that it takes.
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
            Self::Keys { target, keys, .. } => {
                if let &Target::MorphWeight(index) = target {
                    let expected = "the number of a morph target, 0 to 65535";
                    number("MorphWeight", index.into(), index <= MAX_MORPH_TARGET, expected)?;
                }
                if let Target::Field(path) = target
                    && path.split('.').any(|word| word.is_empty() || word.contains(char::is_whitespace))
                {
                    return Err(AnimationError::Path { track, path: path.clone() });
                }
                check_keys(track, target, keys)
            }
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

fn check_keys(track: usize, target: &Target, keys: &[(f64, KeyValue)]) -> Result<(), AnimationError> {
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
        let first = keys.first().map(|(_, first)| *first);
        target.check(*value, first).map_err(|expected| AnimationError::Value {
            track,
            key,
            target: target.clone(),
            expected,
        })?;
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
    fn is_number(&self) -> bool {
        match self {
            Self::LightIntensity
            | Self::LightRange
            | Self::LightInner
            | Self::LightOuter
            | Self::CameraFov
            | Self::CameraHeight
            | Self::MaterialAlpha
            | Self::MaterialMetallic
            | Self::MaterialRoughness
            | Self::MorphWeight(_)
            | Self::Visible => true,
            Self::Translation
            | Self::Rotation
            | Self::Scale
            | Self::LightColor
            | Self::MaterialEmissive
            | Self::MaterialColor
            | Self::Field(_) => false,
        }
    }

    /// Whether a value fits, of a track whose first value is given.
    fn check(&self, value: KeyValue, first: Option<KeyValue>) -> Result<(), &'static str> {
        let is_finite = value.numbers().iter().all(|v| v.is_finite());
        let (valid, expected) = match self.meaning() {
            Meaning::Named(target) => return target.check_named(value),
            Meaning::Lane(..) => (is_finite && matches!(value, KeyValue::Scalar(_)), "a finite number"),
            Meaning::Surface(field) if field.is_color() => (is_finite && value.count() == 3, "(r, g, b)"),
            Meaning::Surface(_) => (is_finite && value.count() == 1, "one number, true or false"),
            // What the field wants is known where the entity is.
            Meaning::Text(_) if !is_finite => (false, "finite numbers"),
            Meaning::Text(_) => {
                let alike = first.is_none_or(|first| std::mem::discriminant(&first) == std::mem::discriminant(&value));
                (alike, "values of one kind")
            }
        };
        if valid { Ok(()) } else { Err(expected) }
    }

    fn check_named(&self, value: KeyValue) -> Result<(), &'static str> {
        let (valid, expected) = match (self, value) {
            (Self::Rotation, KeyValue::Quaternion(q)) => {
                let length = q.length_squared();
                (length.is_finite() && length > 1e-20, "a quaternion that is finite and not zero")
            }
            (Self::Rotation, KeyValue::Vector(v)) => (v.is_finite(), "finite numbers"),
            (Self::Rotation, _) => (false, "(x, y, z) in degrees or a quaternion (x, y, z, w)"),
            (Self::Visible, KeyValue::Flag(_)) => (true, ""),
            (target, KeyValue::Scalar(v)) if target.is_number() || *target == Self::Scale => {
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
