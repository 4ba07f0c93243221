//! How the views of the last frame were drawn, of lights and of the camera: those in which something moves keep what
//! stands still apart.

use std::collections::HashMap;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::{Mutex, PoisonError};

/// How the views of the last frame were drawn.
#[derive(Debug, Default)]
pub struct Views {
    then: HashMap<String, Drawn>,
    now: Mutex<HashMap<String, Drawn>>,
}

/// How a view was drawn.
#[derive(Clone, Copy, Debug)]
struct Drawn {
    view: u64,
    moving: u64,
    apart: bool,
}

impl Views {
    /// A frame begins: what was drawn is what the last one drew.
    pub fn begin_frame(&mut self) {
        self.then = std::mem::take(self.now.get_mut().unwrap_or_else(PoisonError::into_inner));
    }

    /// Whether to draw dynamic objects apart: from when one first changes in a view that rests, until the view changes.
    pub(super) fn are_apart(&self, name: &str, view: u64, moving: &[[u64; 3]]) -> bool {
        let changes = hash(&moving);
        let apart = match self.then.get(name) {
            Some(then) if then.view == view => !moving.is_empty() && (then.apart || then.moving != changes),
            _ => false,
        };
        let mut now = self.now.lock().unwrap_or_else(PoisonError::into_inner);
        now.insert(name.to_owned(), Drawn { view, moving: changes, apart });
        apart
    }
}

pub(super) fn hash(value: &impl Hash) -> u64 {
    let mut hasher = DefaultHasher::new();
    value.hash(&mut hasher);
    hasher.finish()
}
