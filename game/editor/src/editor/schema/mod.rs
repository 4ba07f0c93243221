//! What a type that `serde` can read is made of, found by reading it from nothing: names of fields and variants,
//! numbers, options. A component describes itself by its `Deserialize` alone.

mod tracer;

use serde::Deserialize;
use tracer::Tracer;

/// The shape of a type's values.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Shape {
    /// Not looked at, or read by code that does not say what it wants.
    #[default]
    Unknown,
    /// Read by code of its own: any of several forms, of the named Rust type.
    Custom(String),
    /// True or false.
    Bool,
    /// A whole number; whether it may be negative.
    Integer(bool),
    /// A float; whether it has 32 bits.
    Float(bool),
    /// Text.
    Text,
    /// Nothing at all.
    Unit,
    /// There or not.
    Option(Box<Shape>),
    /// So many values in a row.
    Tuple(Vec<Shape>),
    /// Any number of values in a row.
    List(Box<Shape>),
    /// Values by name.
    Map(Box<Shape>),
    /// Fields.
    Struct(String, Vec<(&'static str, Shape)>),
    /// One of several variants: a [`Shape::Unit`], a struct, or a single value.
    Enum(String, Vec<(&'static str, Shape)>),
}

impl Shape {
    /// The shape of a type; [`Shape::Unknown`] where its code cannot be followed.
    pub fn of<'de, T: Deserialize<'de>>() -> Self {
        let mut shape = Self::Unknown;
        // Each pass follows one variant of each enum; the bound is far above what any type needs.
        for _ in 0..256 {
            let failed = T::deserialize(Tracer::of(&mut shape, None)).is_err();
            if failed || shape.is_complete() {
                break;
            }
        }
        shape
    }

    /// The fields of a structure whose fields are all optional, each followed by itself, so that one that cannot be
    /// followed hides no other. Some may be left out.
    pub fn fields_of<'de, T: Deserialize<'de>>(without: &[&str]) -> Vec<(&'static str, Self)> {
        let mut names = Self::Unknown;
        let _ = T::deserialize(Tracer::of(&mut names, Some("")));
        let Self::Struct(_, fields) = names else { return Vec::new() };
        let field = |(name, _): (&'static str, Self)| {
            let mut shape = Self::Unknown;
            for _ in 0..256 {
                let tracer = Tracer::of(&mut shape, Some(name));
                let failed = T::deserialize(tracer).is_err();
                let Self::Struct(_, fields) = &shape else { break };
                let done = fields.iter().all(|(n, shape)| *n != name || shape.is_complete());
                if failed || done {
                    break;
                }
            }
            let found = match shape {
                Self::Struct(_, fields) => fields.into_iter().find(|(n, _)| *n == name).map(|(_, shape)| shape),
                _ => None,
            };
            (name, found.unwrap_or_default())
        };
        fields.into_iter().filter(|(name, _)| !without.contains(name)).map(field).collect()
    }

    fn is_complete(&self) -> bool {
        match self {
            Self::Unknown => false,
            Self::Option(inner) | Self::List(inner) | Self::Map(inner) => inner.is_complete(),
            Self::Tuple(items) => items.iter().all(Self::is_complete),
            Self::Struct(_, fields) | Self::Enum(_, fields) => fields.iter().all(|(_, shape)| shape.is_complete()),
            _ => true,
        }
    }

    /// The shape inside of options.
    pub fn inner(&self) -> &Self {
        match self {
            Self::Option(inner) => inner.inner(),
            other => other,
        }
    }

    /// A value of the shape, in RON: zeros, empty lists, first variants.
    pub fn sample(&self) -> String {
        match self {
            Self::Unknown | Self::Unit => "()".into(),
            Self::Custom(_) | Self::Text => "\"\"".into(),
            Self::Bool => "false".into(),
            Self::Integer(_) => "0".into(),
            Self::Float(_) => "0.0".into(),
            Self::Option(_) => "None".into(),
            Self::List(_) => "[]".into(),
            Self::Map(_) => "{}".into(),
            Self::Tuple(items) => {
                format!("({})", items.iter().map(Self::sample).collect::<Vec<_>>().join(","))
            }
            Self::Struct(_, fields) => format!("({})", sample_fields(fields)),
            Self::Enum(_, variants) => variants.first().map_or("()".into(), |(name, shape)| shape.variant(name)),
        }
    }

    /// A value of a variant of that content.
    pub fn variant(&self, name: &str) -> String {
        match self {
            Self::Unit => name.to_owned(),
            Self::Struct(_, fields) => format!("{name}({})", sample_fields(fields)),
            other => format!("{name}({})", other.sample()),
        }
    }
}

fn sample_fields(fields: &[(&'static str, Shape)]) -> String {
    fields.iter().map(|(name, shape)| format!("{name}:{}", shape.sample())).collect::<Vec<_>>().join(",")
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use lightwell::files::OverrideFile;
    use lightwell::world::{Clpv, Fog, Light};

    #[test]
    fn a_light_says_what_it_is_made_of() {
        let Shape::Struct(name, fields) = Shape::of::<Light>() else { panic!("no struct") };
        assert_eq!(name, "Light");
        let field = |name: &str| &fields.iter().find(|(n, _)| *n == name).unwrap().1;
        assert_eq!(field("intensity"), &Shape::Float(true));
        assert_eq!(field("range"), &Shape::Option(Box::new(Shape::Float(true))));
        assert_eq!(field("color"), &Shape::Tuple(vec![Shape::Float(true); 3]));
        let Shape::Enum(_, kinds) = field("kind") else { panic!("no enum") };
        assert_eq!(
            kinds.iter().map(|(n, _)| *n).collect::<Vec<_>>(),
            ["Directional", "Point", "Spot", "Sun", "Sphere", "Disc", "Rectangle", "Tube"]
        );
        assert_eq!(kinds[2].1.variant("Spot"), "Spot(inner:0.0,outer:0.0)");
        assert!(matches!(Shape::of::<Clpv>(), Shape::Struct(..)));
    }

    #[test]
    fn every_component_of_scene_files_is_followed() {
        let fields = Shape::fields_of::<OverrideFile>(&["children"]);
        for name in ["transform", "mesh", "material", "light", "camera", "clpv", "fog", "animation", "visible"] {
            let shape = &fields.iter().find(|(n, _)| *n == name).unwrap_or_else(|| panic!("{name} is missing")).1;
            assert!(shape.is_complete(), "{name}: {shape:?}");
        }
    }

    #[test]
    fn samples_can_be_read_back() {
        let sample = Shape::of::<Light>().sample();
        assert!(ron::from_str::<Light>(&sample).is_ok(), "{sample}");
        let sample = Shape::of::<Clpv>().sample();
        assert!(ron::from_str::<Clpv>(&sample).is_ok(), "{sample}");
        let sample = Shape::of::<Fog>().sample();
        assert!(ron::from_str::<Fog>(&sample).is_ok(), "{sample}");
    }
}
