//! What was logged, kept for the console panel.

use std::collections::VecDeque;
use std::sync::{Mutex, PoisonError};

/// Most messages that are kept.
const MOST: usize = 1000;

static RECORDS: Mutex<VecDeque<Record>> = Mutex::new(VecDeque::new());

/// A message.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    /// How grave.
    pub level: log::Level,
    /// Which part of the program.
    pub target: String,
    /// What.
    pub text: String,
    /// How often in a row.
    pub times: u32,
}

/// Keeps a message that was logged, if it is grave enough to be printed or is one of our own.
pub fn hear(record: &log::Record, printed: bool) {
    // Traces are for other programs.
    if record.level() < log::Level::Trace && (printed || is_ours(record.metadata())) {
        keep(record.level(), record.target(), record.args().to_string());
    }
}

/// Our own messages are kept where the terminal shows only warnings.
fn is_ours(metadata: &log::Metadata) -> bool {
    metadata.level() <= log::Level::Info && metadata.target().starts_with("lightwell")
}

/// Adds a message.
pub fn keep(level: log::Level, target: &str, text: String) {
    let mut records = RECORDS.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(last) = records.back_mut().filter(|r| r.level == level && r.text == text && r.target == target) {
        last.times += 1;
        return;
    }
    if records.len() == MOST {
        records.pop_front();
    }
    records.push_back(Record { level, target: target.to_owned(), text, times: 1 });
}

/// All messages that are kept, oldest first.
pub fn records() -> Vec<Record> {
    RECORDS.lock().unwrap_or_else(PoisonError::into_inner).iter().cloned().collect()
}

/// Forgets all messages.
pub fn clear() {
    RECORDS.lock().unwrap_or_else(PoisonError::into_inner).clear();
}
