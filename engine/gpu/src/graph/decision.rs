//! What is compiled, and how it was decided.

/// How to compile.
#[derive(Clone, Copy, Debug, Default)]
pub struct CompileOptions {
    /// Reuse nothing from earlier frames: all passes that contribute to an output run.
    pub no_cache: bool,
}

/// The first consumer of a version.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum WantedBy {
    Output,
    Pass(usize),
}

/// The passes that run, and for which results.
pub(super) struct Decision {
    /// The version that the slot of a retained resource holds and that can be used.
    pub available: Vec<Option<usize>>,
    /// As `available`, before use: a slot whose content is overwritten before its reader is not
    /// available, and appears only here.
    pub held: Vec<Option<usize>>,
    pub runs: Vec<bool>,
    /// By resource and version.
    pub wanted: Vec<Vec<Option<WantedBy>>>,
}
