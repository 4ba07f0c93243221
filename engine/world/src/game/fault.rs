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

/// The errors since the last call.
pub fn take() -> Vec<String> {
    FAULTS.take()
}

/// bevy's way to tell of errors. A system that panicked has left the world half changed: its panic goes on.
pub fn handle(mut error: BevyError, context: ErrorContext) {
    if let Some(payload) = error.take_payload() {
        std::panic::resume_unwind(payload);
    }
    let text = error.to_string();
    // bevy's own help comes after the first line, and ours says it for this engine.
    let ends = ["\nIf this is an expected state", "\nNote that interacting"].iter().filter_map(|end| text.find(end));
    let text = text[..ends.min().unwrap_or(text.len())].trim();
    let help = help(text).map(|help| format!("\n  help: {help}")).unwrap_or_default();
    let name = context.name().to_string();
    let name = if context.kind() == "command" { command_name(&name) } else { name };
    note(format!("{} `{name}` failed: {text}{help}", context.kind()));
}

/// A command's name without modules and wrappers: `insert<Light>`.
fn command_name(name: &str) -> String {
    let name = name.split(" as ").next().unwrap_or(name).trim_start_matches('<').replace("::{{closure}}", "");
    let parts = name.split_inclusive(|c: char| !c.is_alphanumeric() && c != '_' && c != ':');
    parts.map(|part| part.rsplit("::").next().unwrap_or(part)).collect()
}

/// Help for the usual mistakes.
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

#[cfg(test)]
mod tests {
    use super::command_name;

    #[test]
    fn commands_are_named_briefly() {
        let long = "<bevy_ecs::system::entity_command::insert<my_game::Light, (f32, std::vec::Vec<u8>)>::{{closure}} as \
                    bevy_ecs::system::EntityCommand>::with_entity::{{closure}}";
        assert_eq!(command_name(long), "insert<Light, (f32, Vec<u8>)>");
        assert_eq!(command_name("my_game::ring"), "ring");
    }
}
