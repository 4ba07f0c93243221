//! What files hold: the types of scenes, prefabs and components, and which values they may have.

pub(in crate::files) mod canonical;
pub(in crate::files) mod custom_components;
pub(in crate::files) mod described;
pub(in crate::files) mod parts;
pub(in crate::files) mod repeat;
pub(in crate::files) mod scene_data;
pub(in crate::files) mod scene_file;
pub(in crate::files) mod validate;
