//! The folder of shaders that takes the place of those built into the program.

use crate::packed;
use std::path::{Path, PathBuf};

/// The folder of the WGSL files: `LIGHTWELL_SHADERS`, else `shaders` in the current folder or above it, else beside the
/// program or above it, else in the source tree that the program was built from. A packed game looks only at
/// `LIGHTWELL_SHADERS` and beside its program. Without such a folder the shaders built into the program are used.
pub fn default_shader_dir() -> Option<PathBuf> {
    if let Some(dir) = std::env::var_os("LIGHTWELL_SHADERS") {
        return Some(dir.into());
    }
    let is_whole = |dir: &PathBuf| dir.join("geometry/gbuffer.wgsl").is_file();
    if let Some(packed) = packed::game() {
        return Some(packed.folder().join("shaders")).filter(is_whole);
    }
    let starts = [std::env::current_dir().ok(), std::env::current_exe().ok()];
    let above = starts.iter().flatten().flat_map(|start| start.ancestors().map(|dir| dir.join("shaders")));
    above.chain([Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shaders")]).find(is_whole)
}
