//! Enums with variants that files of earlier versions may name. They load, and no list of variants names them: neither
//! errors nor the inspector suggest what is gone, as they would with serde's `alias`.

use serde::de::{DeserializeSeed, Deserializer, EnumAccess, Error, VariantAccess, Visitor};
use std::fmt;

/// An enum of unit variants.
#[derive(Clone, Copy)]
pub(super) struct Variants<T: 'static> {
    /// The name of the type.
    pub name: &'static str,
    /// The variants of this version.
    pub names: &'static [&'static str],
    /// The values of these names and of former ones.
    pub values: &'static [(&'static str, T)],
}

impl<T: Copy + 'static> Variants<T> {
    /// Reads a variant by its name or a former one.
    pub fn read<'de, D: Deserializer<'de>>(self, deserializer: D) -> Result<T, D::Error> {
        deserializer.deserialize_enum(self.name, self.names, self)
    }
}

impl<'de, T: Copy + 'static> Visitor<'de> for Variants<T> {
    type Value = T;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "enum {}", self.name)
    }

    fn visit_enum<A: EnumAccess<'de>>(self, data: A) -> Result<T, A::Error> {
        let (value, variant) = data.variant_seed(Name(self))?;
        variant.unit_variant()?;
        Ok(value)
    }
}

/// The name of a variant.
struct Name<T: 'static>(Variants<T>);

impl<'de, T: Copy + 'static> DeserializeSeed<'de> for Name<T> {
    type Value = T;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<T, D::Error> {
        deserializer.deserialize_identifier(self)
    }
}

impl<T: Copy + 'static> Visitor<'_> for Name<T> {
    type Value = T;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("variant identifier")
    }

    fn visit_str<E: Error>(self, name: &str) -> Result<T, E> {
        let found = self.0.values.iter().find(|(known, _)| *known == name);
        found.map(|(_, value)| *value).ok_or_else(|| E::unknown_variant(name, self.0.names))
    }
}
