//! From files to a world.

pub(in crate::files) mod components;
pub(in crate::files) mod convert;
pub(in crate::files) mod instantiate;
pub(in crate::files) mod loader;
pub(in crate::files) mod model;
pub(in crate::files) mod opened;
pub(in crate::files) mod options;
pub(in crate::files) mod prefabs;
pub(in crate::files) mod source;
pub(in crate::files) mod spawn;
pub(in crate::files) mod track_fields;
pub(in crate::files) mod tracks;
pub(in crate::files) mod trust;
