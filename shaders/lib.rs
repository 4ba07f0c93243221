//! The WGSL of Lightwell, as it is built into programs. `lightwell::gpu` reads a folder in its place where there is one.

/// All WGSL files: the name within the folder, with `/` on every system, and the text.
pub const FILES: &[(&str, &str)] = include!(concat!(env!("OUT_DIR"), "/files.rs"));
