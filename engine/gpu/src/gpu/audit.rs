//! A debug check of cache keys: what passes bind is written down, so that the graph can prove that equal keys stand for
//! equal inputs.
//!
//! A retained result is reused where its key is the same as before. That is right only if the key holds everything that
//! the pass depends on. While an audit runs, every uniform, every buffer filled from the host and every pipeline that a
//! pass uses leaves a note, and the graph compares the notes of passes with equal keys
//! (see [`crate::graph::TargetCache::set_audit`]).

use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

/// Something that a pass bound: its name, and a hash of its content.
#[doc(hidden)]
pub type Note = (String, u64);

/// The notes of the pass that is being recorded. Costs one load where nothing is audited.
#[derive(Default)]
#[doc(hidden)]
pub struct Audit {
    is_on: AtomicBool,
    notes: Mutex<Vec<Note>>,
}

impl Audit {
    /// Starts or stops taking notes; those before are dropped.
    pub fn set(&self, is_on: bool) {
        self.is_on.store(is_on, Ordering::Relaxed);
        self.take();
    }

    /// Whether notes are taken, for what would cost something to find out.
    pub fn is_on(&self) -> bool {
        self.is_on.load(Ordering::Relaxed)
    }

    /// Notes something that the pass being recorded depends on.
    pub fn note(&self, name: &str, content: &impl Hash) {
        if self.is_on() {
            let mut hasher = DefaultHasher::new();
            content.hash(&mut hasher);
            self.lock().push((name.to_owned(), hasher.finish()));
        }
    }

    /// Runs work that is cut into parts by the time that it takes, or that continues earlier work: none of it is noted.
    pub fn unnoted<T>(&self, work: impl FnOnce() -> T) -> T {
        let was_on = self.is_on.swap(false, Ordering::Relaxed);
        let result = work();
        self.is_on.store(was_on, Ordering::Relaxed);
        result
    }

    /// The notes since the last call.
    pub fn take(&self) -> Vec<Note> {
        std::mem::take(&mut self.lock())
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, Vec<Note>> {
        self.notes.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
