//! Paths to values in a file, and the errors of the values that they lead to.

use super::document::Document;
use super::tree::Step;
use crate::files::error::{FileError, FileErrorKind as Kind};

/// A fault of a value, with its place.
#[derive(Debug)]
pub struct Fault {
    /// Path of the value in the file.
    pub path: Vec<Step>,
    /// Kind.
    pub kind: Kind,
    /// The fault.
    pub message: String,
    /// Help.
    pub help: Option<String>,
}

/// The error of a fault, with its place in the file.
pub(in crate::files) fn fault_error(document: &Document, fault: Fault) -> FileError {
    let error = document.error(&fault.path, fault.kind, fault.message);
    match fault.help {
        Some(help) => error.with_help(help),
        None => error,
    }
}

/// The path with more steps.
pub(in crate::files) fn extended(path: &[Step], steps: &[Step]) -> Vec<Step> {
    path.iter().chain(steps).cloned().collect()
}

pub(in crate::files) fn key(name: &str) -> Step {
    Step::Key(name.to_owned())
}
