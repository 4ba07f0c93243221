//! The commands, one file each.

pub mod animation;
pub mod bench;
pub mod compare;
pub mod explain;
pub mod info;
pub mod render;
pub mod test;
