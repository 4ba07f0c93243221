//! Errors of assets.

use std::path::{Path, PathBuf};

/// An asset that could not be made or loaded. Every message names the file or shape, the place, and the problem.
#[derive(Debug, thiserror::Error)]
pub enum AssetError {
    /// A file could not be read.
    #[error("{}: cannot be read: {reason}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        reason: std::io::Error,
    },
    /// A file is there, but its content is not what it should be.
    #[error("{}: {place}: {problem}", path.display())]
    Format {
        /// The file.
        path: PathBuf,
        /// The part of the file, such as `mesh 3 "lamp", primitive 0`.
        place: String,
        /// The fault, and help where there is any.
        problem: String,
    },
    /// More than the load as a whole may take, see [`LoadBudget`](super::LoadBudget).
    #[error("{}: the load would take {total} {limit}, and at most {most} are allowed", path.display())]
    Budget {
        /// The file that goes beyond it.
        path: PathBuf,
        /// Name of the limit.
        limit: &'static str,
        /// The amount that the load would take with it.
        total: u64,
        /// The limit.
        most: u64,
    },
    /// Parameters of a procedural shape that make no shape.
    #[error("shape {shape}: {field} {problem}")]
    Shape {
        /// Name of the shape.
        shape: &'static str,
        /// The parameter.
        field: &'static str,
        /// The fault.
        problem: String,
    },
}

impl AssetError {
    /// A fault in the content of a file.
    pub(super) fn format(path: &Path, place: impl Into<String>, problem: impl Into<String>) -> Self {
        Self::Format { path: path.to_path_buf(), place: place.into(), problem: problem.into() }
    }

    /// A failure to read a file.
    pub(super) fn io(path: &Path, reason: std::io::Error) -> Self {
        Self::Io { path: path.to_path_buf(), reason }
    }
}
