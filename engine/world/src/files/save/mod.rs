//! From a world to files.

pub(in crate::files) mod describe;
pub(in crate::files) mod disk;
pub(in crate::files) mod overridden;
pub(in crate::files) mod override_values;
pub(in crate::files) mod paths;
pub(in crate::files) mod rewrite;
pub(in crate::files) mod save_as;
pub(in crate::files) mod scene;
pub(in crate::files) mod text;
pub(in crate::files) mod writer;
