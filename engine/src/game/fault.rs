//! Where systems that fail, and questions that make no sense, are noted until the schedule is through.
//!
//! Systems run on one thread, one after the other, and bevy's error handler is a plain function: a list of the thread
//! holds what it is told.

use bevy_ecs::error::{BevyError, ErrorContext};
use std::cell::RefCell;

thread_local! {
    static FAULTS: RefCell<Vec<String>> = const { RefCell::new(Vec::new()) };
}

/// Most faults that are kept of one schedule: a system may fail for each of many entities.
const MOST: usize = 16;

/// Notes a fault. The same is noted once.
pub fn note(message: String) {
    FAULTS.with_borrow_mut(|faults| {
        if faults.len() < MOST && !faults.contains(&message) {
            faults.push(message);
        }
    });
}

/// What was noted since the last time.
pub fn take() -> Vec<String> {
    FAULTS.take()
}

/// bevy's way to tell of errors.
pub fn handle(error: BevyError, context: ErrorContext) {
    let text = error.to_string();
    // bevy's own help comes after the first line, and ours says it for this engine.
    let text = match text.trim().split_once("\nIf this is an expected state") {
        Some((first, _)) => first,
        None => text.trim(),
    };
    let help = help(text).map(|help| format!("\n  help: {help}")).unwrap_or_default();
    note(format!("{} `{}` failed: {text}{help}", context.kind(), context.name()));
}

/// What to do about the usual mistakes.
fn help(text: &str) -> Option<&'static str> {
    if text.contains("Resource does not exist") {
        Some("give the game the resource, `.resource(…)`, or take `Option<Res<…>>`")
    } else if text.contains("Message not initialized") {
        Some("make the message known to the game, `.message::<…>()`")
    } else if text.contains("despawned") || text.contains("does not exist") || text.contains("is invalid") {
        Some("the entity is gone: look it up with `Query::get` in each step, or use `try_insert`, `try_despawn`")
    } else {
        None
    }
}
