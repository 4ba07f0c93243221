//! Values of keys: one to four numbers or a switch, as files write them.

use glam::{EulerRot, Quat, Vec2, Vec3};
use serde::de::{Error, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Value of a key.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum KeyValue {
    /// A number.
    Scalar(f32),
    /// On or off; changes at its key, whatever the interpolation.
    Flag(bool),
    /// (x, y).
    Pair(Vec2),
    /// (x, y, z), (r, g, b) or Euler angles \[degrees\].
    Vector(Vec3),
    /// A quaternion (x, y, z, w), which need not be of unit length; or four numbers of a field.
    Quaternion(Quat),
}

impl Serialize for KeyValue {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Scalar(v) => v.serialize(serializer),
            Self::Flag(on) => on.serialize(serializer),
            Self::Pair(v) => v.to_array().serialize(serializer),
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
        f.write_str("a number, (x, y), (x, y, z), (x, y, z, w), true or false")
    }
    fn visit_bool<E: Error>(self, on: bool) -> Result<KeyValue, E> {
        Ok(KeyValue::Flag(on))
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
            [x, y] => Ok(KeyValue::Pair(Vec2::new(x, y))),
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
