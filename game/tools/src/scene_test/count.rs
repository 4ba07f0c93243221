//! Bounds on what a pass does, in numbers that do not depend on the machine.

use lightwell::graph::Counts;
use serde::de::value::MapAccessDeserializer;
use serde::de::{MapAccess, Visitor};
use serde::{Deserialize, Deserializer};
use std::fmt;

/// Bounds on the counts of a pass; those not given are not checked.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct CountBounds {
    draws: Option<Count>,
    dispatches: Option<Count>,
    triangles: Option<Count>,
    texels: Option<Count>,
    cells: Option<Count>,
    lights: Option<Count>,
    injections: Option<Count>,
    merges: Option<Count>,
    paths: Option<Count>,
    bytes: Option<Count>,
}

impl CountBounds {
    fn named(&self) -> [(&'static str, Option<Count>); 10] {
        [
            ("draws", self.draws),
            ("dispatches", self.dispatches),
            ("triangles", self.triangles),
            ("texels", self.texels),
            ("cells", self.cells),
            ("lights", self.lights),
            ("injections", self.injections),
            ("merges", self.merges),
            ("paths", self.paths),
            ("bytes", self.bytes),
        ]
    }

    /// A bound that nothing can keep: the name of its count, and what is wrong.
    pub fn fault(&self) -> Option<(&'static str, String)> {
        self.named().into_iter().find_map(|(name, count)| match count? {
            Count::Between { min: Some(min), max: Some(max) } if min > max => {
                Some((name, format!("no number is at least {min} and at most {max}")))
            }
            _ => None,
        })
    }

    /// The counts that are out of their bounds, each in words.
    pub fn violations(&self, counts: &Counts) -> Vec<String> {
        let bounds = self.named().into_iter().zip(counts.named());
        let broken = bounds.filter_map(|((name, bound), (same_name, value))| {
            debug_assert_eq!(name, same_name);
            bound.filter(|bound| !bound.holds(value)).map(|bound| format!("{value} {name}, not {bound}"))
        });
        broken.collect()
    }
}

/// A bound on a count: `7` exactly, or `(min: 5, max: 9)` with either left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Count {
    Exactly(u64),
    Between { min: Option<u64>, max: Option<u64> },
}

impl Count {
    fn holds(self, value: u64) -> bool {
        match self {
            Self::Exactly(count) => value == count,
            Self::Between { min, max } => min.is_none_or(|min| value >= min) && max.is_none_or(|max| value <= max),
        }
    }
}

impl fmt::Display for Count {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Exactly(count) => write!(f, "{count}"),
            Self::Between { min: Some(min), max: Some(max) } => write!(f, "{min} to {max}"),
            Self::Between { min: Some(min), max: None } => write!(f, "{min} or more"),
            Self::Between { min: None, max: Some(max) } => write!(f, "{max} or fewer"),
            Self::Between { min: None, max: None } => f.write_str("any number"),
        }
    }
}

impl<'de> Deserialize<'de> for Count {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(CountVisitor)
    }
}

struct CountVisitor;

impl<'de> Visitor<'de> for CountVisitor {
    type Value = Count;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a whole number or (min: …, max: …)")
    }

    fn visit_u64<E>(self, value: u64) -> Result<Count, E> {
        Ok(Count::Exactly(value))
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Count, A::Error> {
        #[derive(Deserialize)]
        #[serde(deny_unknown_fields, default)]
        #[derive(Default)]
        struct Between {
            min: Option<u64>,
            max: Option<u64>,
        }
        let Between { min, max } = Between::deserialize(MapAccessDeserializer::new(map))?;
        Ok(Count::Between { min, max })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn bounds(text: &str) -> CountBounds {
        let (_, bounds) = lightwell::files::Document::parse("t".as_ref(), text.to_owned()).unwrap();
        bounds
    }

    #[test]
    fn counts_are_exact_or_bounded() {
        let counts = Counts { draws: 7, cells: 10, ..Counts::default() };
        for (text, broken) in [
            ("(draws: 7, cells: (min: 10, max: 10))", 0),
            ("(draws: 6, cells: (min: 11))", 2),
            ("(draws: (max: 6), bytes: 0)", 1),
            ("(triangles: (max: 0))", 0),
        ] {
            let violations = bounds(text).violations(&counts);
            assert_eq!(violations.len(), broken, "{text}: {violations:?}");
        }
        assert_eq!(bounds("(draws: (min: 8, max: 9))").violations(&counts), ["7 draws, not 8 to 9"]);
    }

    #[test]
    fn impossible_bounds_are_found() {
        assert!(bounds("(draws: (min: 3, max: 2))").fault().is_some_and(|(name, _)| name == "draws"));
        assert_eq!(bounds("(draws: (min: 2, max: 2))").fault(), None);
    }
}
