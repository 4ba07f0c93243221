//! Edits of a world by what files would say of it.

pub(in crate::files) mod apply;
pub(in crate::files) mod context;
pub(in crate::files) mod entity;
pub(in crate::files) mod prefab;
pub(in crate::files) mod reload;
pub(in crate::files) mod scene;
pub(in crate::files) mod spawn;
