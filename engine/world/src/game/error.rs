//! Errors of running games.

use crate::files::{DuplicateType, FileError};
use crate::world::WorldError;

/// Why a game does not go on as it should.
#[derive(Clone, Debug, thiserror::Error)]
pub enum GameError {
    /// A scene, prefab, table of actions, script or saved game is wrong.
    #[error(transparent)]
    File(#[from] FileError),
    /// Two types want one name in scene files.
    #[error(transparent)]
    Duplicate(#[from] DuplicateType),
    /// The world refuses an edit.
    #[error(transparent)]
    World(#[from] WorldError),
    /// Systems, observers or commands failed, in the order in which they did.
    #[error("{}", .0.join("\n"))]
    Failed(Vec<String>),
}
