//! Fields that tracks have taken over, with their own values.

use super::path::{ron_options, split};
use super::text;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::collections::BTreeMap;

/// A field that a track has taken over: the texts of its own value, and of the one that is shown in its place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Held {
    /// The field's own value.
    pub own: String,
    /// The value that the track wrote. A field that holds another one was set by someone else.
    pub shown: String,
}

/// Fields that tracks have taken over, by path.
pub(in crate::world) type HeldFields = BTreeMap<String, Held>;

/// The text of a component with the own values of the fields that are held.
pub(super) fn own_text(shown: &str, component: &str, held: &HeldFields) -> String {
    let mut own = shown.to_owned();
    for (path, held) in held {
        let (name, steps) = split(path);
        if name == component && text::get(shown, &steps).is_ok_and(|now| now == held.shown) {
            // A field that is not there any more has no own value either.
            own = text::replace(&own, &steps, &held.own).unwrap_or(own);
        }
    }
    own
}

/// The value without its tracks.
pub(super) fn at_rest<T: Serialize + DeserializeOwned>(shown: T, component: &str, held: &HeldFields) -> T {
    if !held.keys().any(|path| split(path).0 == component) {
        return shown;
    }
    let Ok(text) = ron_options().to_string(&shown) else { return shown };
    ron_options().from_str(&own_text(&text, component, held)).unwrap_or(shown)
}
