//! Errors of graphs and of passes.

use thiserror::Error;

use crate::gpu::{BindError, ShaderError};

/// An error in the declaration of a frame, or while executing it.
#[derive(Debug, Error)]
pub enum GraphError {
    /// Two resources have one name.
    #[error("two resources are named `{resource}`; names must be unique in a graph: rename one")]
    DuplicateResource {
        /// The name.
        resource: String,
    },
    /// Two passes, or a pass and a skipped one, have one name.
    #[error("two passes are named `{pass}`; names must be unique in a graph: rename one")]
    DuplicatePass {
        /// The name.
        pass: String,
    },
    /// A handle or pass of another graph was used.
    #[error(
        "{place} uses a handle of another graph; handles are only good for the graph, and so the frame, that made them"
    )]
    ForeignHandle {
        /// Where: the pass, or `output` or `order`.
        place: String,
    },
    /// A description that no device can make.
    #[error("resource `{resource}` cannot be made: {fault}")]
    BadDesc {
        /// The resource.
        resource: String,
        /// The fault.
        fault: &'static str,
    },
    /// The frame is not wanted any more: [`FramePacing::stop`](super::FramePacing::stop).
    #[error("the frame was ended before it was finished")]
    Stopped,
    /// A pass has no work.
    #[error("pass `{pass}` has nothing to execute: call `execute` on it")]
    NoWork {
        /// The pass.
        pass: String,
    },
    /// A pass reads what nobody has written.
    #[error(
        "pass `{pass}` reads `{resource}` before any pass has written it: write it first, and read the handle that `write` returns"
    )]
    ReadBeforeWrite {
        /// The reader.
        pass: String,
        /// The resource that it reads.
        resource: String,
    },
    /// An output of the graph that nobody has written.
    #[error("output `{resource}` is not written by any pass: give the handle that `write` returns")]
    OutputNeverWritten {
        /// The output.
        resource: String,
    },
    /// An output of the graph that is overwritten before the end of the frame.
    #[error("output `{resource}` is overwritten by pass `{writer}`: give the handle of the last write")]
    StaleOutput {
        /// The output.
        resource: String,
        /// The pass that overwrites it.
        writer: String,
    },
    /// A pass reads a version that is gone by the time that it can run.
    #[error(
        "pass `{pass}` reads `{resource}` as it was before pass `{writer}` overwrites it, but has to run after that pass ({path}): read the handle that `{writer}` returned, or remove that dependency"
    )]
    StaleRead {
        /// The reader.
        pass: String,
        /// The resource that it reads.
        resource: String,
        /// The pass that overwrites it.
        writer: String,
        /// The cycle of dependencies.
        path: String,
    },
    /// Two passes write the same version.
    #[error(
        "passes `{first}` and `{second}` both write `{resource}` from the same version, so their order is undefined: let `{second}` write the handle that `{first}` returned"
    )]
    DoubleWrite {
        /// The resource that they write.
        resource: String,
        /// The pass declared first.
        first: String,
        /// The pass declared second.
        second: String,
    },
    /// Passes wait for each other.
    #[error("passes wait for each other: {path}; remove one of these dependencies or `order` calls")]
    Cycle {
        /// The cycle of dependencies, with its resources.
        path: String,
    },
    /// The cache has changed between compilation and execution.
    #[error(
        "the target cache has changed since the graph was compiled: compile and execute one frame at a time, with the same cache"
    )]
    StalePlan,
    /// Found by an audit: a pass bound something else than before under the same key.
    #[error(
        "pass `{pass}` depends on {input}, which its key does not hold: add it to the pass's `key`, or it will be kept when that changes"
    )]
    Key {
        /// The pass.
        pass: String,
        /// The binding, and its difference.
        input: String,
    },
    /// A pass failed. What it was writing is no longer in the cache.
    #[error("pass `{pass}` failed: {reason}")]
    Pass {
        /// The pass.
        pass: String,
        /// Why.
        reason: PassError,
    },
    /// The device refused commands. Nothing that the frame wrote is in the cache.
    #[error("the device refused {place}: {message}")]
    Device {
        /// The resource or pass that was refused.
        place: String,
        /// The message of the device.
        message: String,
    },
}

/// Why a pass failed.
#[derive(Debug, Error)]
pub enum PassError {
    /// A shader does not compile.
    #[error(transparent)]
    Shader(#[from] ShaderError),
    /// Its bindings do not fit the shader.
    #[error(transparent)]
    Bind(#[from] BindError),
    /// A graph that it runs itself failed.
    #[error(transparent)]
    Graph(Box<GraphError>),
    /// It asked for a resource that it has not declared.
    #[error("it uses {resource} without having declared it: call `read` or `write` on the pass")]
    Undeclared {
        /// The resource.
        resource: String,
    },
    /// The frame is not wanted any more, see [`FramePacing`](super::FramePacing).
    #[error("it was stopped")]
    Stopped,
    /// Anything else.
    #[error("{0}")]
    Message(String),
}

impl PassError {
    /// An error with a message: what is wrong, and what to do about it.
    pub fn message(message: impl Into<String>) -> Self {
        Self::Message(message.into())
    }
}

impl From<GraphError> for PassError {
    fn from(error: GraphError) -> Self {
        Self::Graph(Box::new(error))
    }
}
