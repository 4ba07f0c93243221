//! Tables of actions.

use super::super::GameError;
use super::keys::{Button, Stick};
use crate::files::{Document, FileError, FileErrorKind, Step};
use serde::de::{self, Deserializer, MapAccess, Visitor};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt;
use std::marker::PhantomData;
use std::path::Path;

/// Which buttons and sticks mean what.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Actions {
    /// Buttons of each action; any of them does.
    #[serde(deserialize_with = "unique")]
    pub buttons: BTreeMap<String, Vec<Button>>,
    /// The bindings of each axis; they add up.
    #[serde(deserialize_with = "unique")]
    pub axes: BTreeMap<String, Vec<AxisBinding>>,
}

/// A binding of an axis.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum AxisBinding {
    /// Two buttons.
    Buttons {
        /// Towards −1.
        negative: Button,
        /// Towards 1.
        positive: Button,
    },
    /// A stick of any gamepad.
    Stick(Stick),
}

impl Actions {
    /// Reads a table from its file.
    ///
    /// # Errors
    /// When there is no such file, a name is unknown or given twice, or an action has no button; with line and column.
    pub fn read(path: &Path) -> Result<Self, GameError> {
        Ok(Self::checked(Document::read::<Self>(path)?)?)
    }

    /// Reads a table from a text; `path` names it in errors.
    ///
    /// # Errors
    /// As [`Actions::read`].
    pub fn parse(path: &Path, text: &str) -> Result<Self, GameError> {
        Ok(Self::checked(Document::parse::<Self>(path, text.to_owned())?)?)
    }

    fn checked((document, actions): (Document, Self)) -> Result<Self, FileError> {
        let at = |table: &str, name: &String| [Step::Key(table.to_owned()), Step::Key(name.clone())];
        let empty_button = actions.buttons.iter().find(|(_, b)| b.is_empty()).map(|(name, _)| ("buttons", name));
        let empty_axis = actions.axes.iter().find(|(_, b)| b.is_empty()).map(|(name, _)| ("axes", name));
        if let Some((table, name)) = empty_button.or(empty_axis) {
            let message = format!("nothing is bound to `{name}`");
            let error = document.error(&at(table, name), FileErrorKind::BadValue, message);
            return Err(error.with_help("bind something, such as `Key(Space)` or `Stick(LeftX)`, or take it out"));
        }
        Ok(actions)
    }
}

/// A map in which no key comes twice.
fn unique<'de, D: Deserializer<'de>, V: Deserialize<'de>>(deserializer: D) -> Result<BTreeMap<String, V>, D::Error> {
    struct Unique<V>(PhantomData<V>);
    impl<'de, V: Deserialize<'de>> Visitor<'de> for Unique<V> {
        type Value = BTreeMap<String, V>;
        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("a map of names, { \"jump\": [Key(Space)] }")
        }
        fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
            let mut found = BTreeMap::new();
            while let Some(name) = map.next_key::<String>()? {
                let value = map.next_value()?;
                if found.contains_key(&name) {
                    return Err(de::Error::custom(format!("`{name}` is given twice: keep one of them")));
                }
                found.insert(name, value);
            }
            Ok(found)
        }
    }
    deserializer.deserialize_map(Unique(PhantomData))
}
