//! Copies of a prefab in grids, in rings and along lines.

use super::parts::{Rotation, TransformFile};
use glam::Vec3;
use serde::{Deserialize, Serialize};

/// Where the copies of a prefab stand, relative to the entity that instances it. Each is an entity of its own named by
/// its number from 1 on, which holds the prefab's entities: overrides find them as `"3/Pole/Bulb"`, and the copy itself
/// as `"3"`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum Repeat {
    /// Rows, layers and columns around the entity's place, counted along x first, then y, then z.
    Grid {
        /// Copies along x, y and z.
        count: [u32; 3],
        /// Distance between neighbours along x, y and z (m).
        spacing: Vec3,
    },
    /// On a circle around the entity's y axis, anticlockwise seen from above, the first towards +z.
    Ring {
        /// Copies.
        count: u32,
        /// Radius (m).
        radius: f32,
        /// Direction of the first, and of the end (degrees). Over a whole turn the last copy does not stand on the
        /// first; over less it stands at the end.
        #[serde(default = "whole_turn")]
        angles: [f32; 2],
        /// Turns each copy with the circle, so that +z points away from the centre.
        #[serde(default = "yes")]
        turn: bool,
    },
    /// Along a line through points, at equal distances on it and at both ends.
    Line {
        /// Copies.
        count: u32,
        /// Corners of the line (m), two or more.
        points: Vec<Vec3>,
        /// Turns each copy so that +z points along the line.
        #[serde(default)]
        turn: bool,
    },
}

fn whole_turn() -> [f32; 2] {
    [0.0, 360.0]
}

fn yes() -> bool {
    true
}

/// Most copies of one instance.
pub const MAX_COPIES: u64 = 10_000;

/// A value that makes no copies: the field, what is wrong and what to do.
pub(in crate::files) type RepeatFault = (&'static str, String, &'static str);

impl Repeat {
    /// Number of copies.
    pub fn count(&self) -> u64 {
        match self {
            Self::Grid { count, .. } => count.iter().fold(1, |product: u64, &n| product.saturating_mul(u64::from(n))),
            Self::Ring { count, .. } | Self::Line { count, .. } => u64::from(*count),
        }
    }

    /// Its fault.
    pub(in crate::files) fn fault(&self) -> Option<RepeatFault> {
        let copies = self.count();
        if copies == 0 || copies > MAX_COPIES {
            let help = "ask for 1 to 10,000 copies; more of them in several instances";
            return Some(("count", format!("`count` makes {copies} copies"), help));
        }
        match self {
            Self::Grid { spacing, .. } if !spacing.is_finite() => {
                Some(("spacing", format!("`spacing` is {spacing}"), "give three finite distances"))
            }
            Self::Ring { radius, .. } if !radius.is_finite() => {
                Some(("radius", format!("`radius` is {radius}"), "give a finite radius"))
            }
            Self::Ring { angles, .. } if angles.iter().any(|a| !a.is_finite() || a.abs() > 3600.0) => {
                Some(("angles", format!("`angles` are {angles:?}"), "give angles from -3600 to 3600 degrees"))
            }
            Self::Line { points, .. } if points.len() < 2 || points.iter().any(|p| !p.is_finite()) => {
                Some(("points", "a line needs two points or more, all finite".into(), "give its ends"))
            }
            _ => None,
        }
    }

    /// Place of a copy, by its number from 0 on.
    pub(in crate::files) fn place(&self, index: u64) -> TransformFile {
        match self {
            Self::Grid { count, spacing } => {
                let [x, y, _] = count.map(u64::from);
                let at = [index % x, index / x % y, index / (x * y)];
                let from_middle = |axis: usize| at[axis] as f32 - 0.5 * (count[axis] - 1) as f32;
                turned(Vec3::new(from_middle(0), from_middle(1), from_middle(2)) * *spacing, None)
            }
            Self::Ring { count, radius, angles: [first, end], turn } => {
                let span = end - first;
                let steps = if span.abs() >= 360.0 { *count } else { count.saturating_sub(1).max(1) };
                let degrees = first + span * index as f32 / steps as f32;
                let (sine, cosine) = degrees.to_radians().sin_cos();
                turned(Vec3::new(radius * sine, 0.0, radius * cosine), turn.then_some(degrees))
            }
            Self::Line { count, points, turn } => {
                let share = index as f32 / count.saturating_sub(1).max(1) as f32;
                let (point, along) = on_line(points, share);
                turned(point, turn.then(|| along.x.atan2(along.z).to_degrees()))
            }
        }
    }
}

fn turned(translation: Vec3, heading: Option<f32>) -> TransformFile {
    // `-0` would be written as such.
    let translation = translation + Vec3::ZERO;
    let rotation = heading.filter(|heading| *heading != 0.0);
    let rotation = rotation.map(|heading| Rotation::Euler(Vec3::new(0.0, heading, 0.0)));
    TransformFile { translation, rotation, ..Default::default() }
}

/// Point and direction at a share of a line's length.
fn on_line(points: &[Vec3], share: f32) -> (Vec3, Vec3) {
    let lengths: Vec<f32> = points.windows(2).map(|ends| ends[0].distance(ends[1])).collect();
    let mut left = share * lengths.iter().sum::<f32>();
    let last = lengths.iter().rposition(|length| *length > 0.0).unwrap_or(0);
    for (ends, (i, &length)) in points.windows(2).zip(lengths.iter().enumerate()) {
        if (left <= length && length > 0.0) || i == last {
            let along = (ends[1] - ends[0]).normalize_or_zero();
            return (ends[0] + along * left.min(length), along);
        }
        left -= length;
    }
    (points.first().copied().unwrap_or_default(), Vec3::ZERO)
}
