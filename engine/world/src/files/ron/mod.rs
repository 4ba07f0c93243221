//! RON as text: where values stand in it, what is wrong with it, and edits that keep the rest of it.

pub(in crate::files) mod document;
pub(in crate::files) mod merge;
pub(in crate::files) mod preserve;
pub(in crate::files) mod renamed;
pub(in crate::files) mod scan;
pub(in crate::files) mod steps;
pub(in crate::files) mod suggest;
pub(in crate::files) mod tree;
