//! Paths to values in a file, and the errors of the values that they lead to.

use super::document::Document;
use super::error::FileError;
use super::tree::Step;
use super::validate::Fault;

/// The error of a fault, with its place in the file.
pub(super) fn fault_error(document: &Document, fault: Fault) -> FileError {
    let error = document.error(&fault.path, fault.kind, fault.message);
    match fault.help {
        Some(help) => error.with_help(help),
        None => error,
    }
}

/// The path with more steps.
pub(super) fn extended(path: &[Step], steps: &[Step]) -> Vec<Step> {
    path.iter().chain(steps).cloned().collect()
}

pub(super) fn key(name: &str) -> Step {
    Step::Key(name.to_owned())
}
