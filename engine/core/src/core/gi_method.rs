//! The choice of a method of indirect light, by name: one type for scene files, command lines, settings and tools.

use serde::de::{EnumAccess, Error, VariantAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::collections::BTreeSet;
use std::fmt;
use std::sync::{Mutex, PoisonError};

/// Longest name of a method \[bytes\].
const MAX_NAME: usize = 64;

/// A method of indirect light, by its name. The command line says `constant-ambient` where scene files say
/// `ConstantAmbient`. The name alone says nothing of whether there is such a method: a renderer knows those that were
/// registered with it, and `files::ComponentTypes::methods` those that scene files may name.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct GiMethod(&'static str);

impl GiMethod {
    /// Direct light only.
    pub const NONE: Self = Self::named("none");
    /// Light propagation volumes, as the scene's `Clpv` component sets them; without one, none.
    pub const CLPV: Self = Self::named("clpv");
    /// Instant radiosity, as the scene's `InstantRadiosity` component sets it; without one, with its defaults.
    pub const VPL: Self = Self::named("vpl");
    /// Stochastic light culling, as the scene's `StochasticLightCulling` component sets it; without one, by default.
    pub const SLC: Self = Self::named("slc");
    /// Path tracing, the reference: all light, direct and indirect, as
    /// `RenderSettings::reference` sets it.
    pub const REFERENCE: Self = Self::named("reference");

    /// The methods of the engine, as scene tests write them.
    pub const BUILT_IN: &[&str] = &["None", "Clpv", "Vpl", "Slc", "Reference"];

    /// The method of a name: lower-case words of letters and digits, joined by hyphens, such as `constant-ambient`.
    pub const fn named(name: &'static str) -> Self {
        Self(name)
    }

    /// The method of a name that was read; `None` if no method can have that name.
    pub fn read(name: &str) -> Option<Self> {
        let is_word = |word: &str| {
            word.starts_with(|c: char| c.is_ascii_lowercase())
                && word.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit())
        };
        (name.len() <= MAX_NAME && name.split('-').all(is_word)).then(|| Self(interned(name)))
    }

    /// The method that a scene file names, such as `ConstantAmbient`; `None` if no method can have that name.
    pub fn read_variant(variant: &str) -> Option<Self> {
        let mut name = String::new();
        for c in variant.chars() {
            if c.is_ascii_uppercase() && !name.is_empty() {
                name.push('-');
            }
            name.push(c.to_ascii_lowercase());
        }
        Self::read(&name).filter(|method| method.variant() == variant)
    }

    /// Its name, as on the command line: `constant-ambient`.
    pub fn name(self) -> &'static str {
        self.0
    }

    /// Its name in scene files: `ConstantAmbient`.
    pub fn variant(self) -> &'static str {
        let capitalized = |word: &str| {
            let mut chars = word.chars();
            chars.next().into_iter().flat_map(char::to_uppercase).chain(chars).collect::<String>()
        };
        interned(&self.0.split('-').map(capitalized).collect::<String>())
    }
}

impl Default for GiMethod {
    /// Light propagation volumes.
    fn default() -> Self {
        Self::CLPV
    }
}

impl fmt::Debug for GiMethod {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.variant())
    }
}

/// One copy of each name for as long as the program runs. Names are short, and files hold few.
fn interned(name: &str) -> &'static str {
    static NAMES: Mutex<BTreeSet<&'static str>> = Mutex::new(BTreeSet::new());
    let mut names = NAMES.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(known) = names.get(name) {
        return known;
    }
    let name: &'static str = String::leak(name.to_owned());
    names.insert(name);
    name
}

impl Serialize for GiMethod {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_unit_variant("Gi", 0, self.variant())
    }
}

impl<'de> Deserialize<'de> for GiMethod {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_enum("Gi", Self::BUILT_IN, MethodVisitor)
    }
}

struct MethodVisitor;

impl<'de> Visitor<'de> for MethodVisitor {
    type Value = GiMethod;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a method of indirect light")
    }

    fn visit_enum<A: EnumAccess<'de>>(self, data: A) -> Result<GiMethod, A::Error> {
        let (Variant(method), access) = data.variant()?;
        access.unit_variant()?;
        Ok(method)
    }
}

/// The name of a variant, which is a word and no text in quotes.
struct Variant(GiMethod);

impl<'de> Deserialize<'de> for Variant {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_identifier(VariantVisitor)
    }
}

struct VariantVisitor;

impl Visitor<'_> for VariantVisitor {
    type Value = Variant;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the name of a method of indirect light")
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<Variant, E> {
        GiMethod::read_variant(text).map(Variant).ok_or_else(|| E::unknown_variant(text, GiMethod::BUILT_IN))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_in_both_forms() {
        for (name, variant) in [("clpv", "Clpv"), ("constant-ambient", "ConstantAmbient"), ("two2-d3", "Two2D3")] {
            let method = GiMethod::named(name);
            assert_eq!((GiMethod::read(name), GiMethod::read_variant(variant)), (Some(method), Some(method)));
            assert_eq!((method.variant(), format!("{method:?}")), (variant, variant.to_owned()));
        }
        for name in ["", "Clpv", "a--b", "-a", "a b", "2d", "ä", &"a".repeat(65)] {
            assert_eq!(GiMethod::read(name), None, "{name}");
        }
        for variant in ["", "clpv", "A_b", "Clpv ", "Ä"] {
            assert_eq!(GiMethod::read_variant(variant), None, "{variant}");
        }
    }
}
