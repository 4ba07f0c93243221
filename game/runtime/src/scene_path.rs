//! Scenes by file or by name.

use anyhow::{Result, bail};
use lightwell::files::suggestion;
use lightwell::packed;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

const ENDINGS: [&str; 4] = ["scene.ron", "prefab.ron", "gltf", "glb"];

static SHIPPED: OnceLock<fn() -> Option<PathBuf>> = OnceLock::new();

/// Sets where a program has scenes of its own, for where there is no source tree. It is asked when it is needed.
pub fn set_shipped(folder: fn() -> Option<PathBuf>) {
    let _ = SHIPPED.set(folder);
}

/// The scene's file: the path itself if it exists, else `scenes/NAME.scene.ron` in the current folder, above it,
/// beside the program or above that, in the source tree, or among those that the program brings along. A packed game
/// looks among its own files first, see [`packed::Packed::find`], and has no folders but its own.
///
/// # Errors
/// If there is none; lists the scenes that exist.
pub fn find(scene: &str) -> Result<PathBuf> {
    if let Some(found) = packed::game().and_then(|packed| packed.find(Path::new(scene), &ENDINGS)) {
        return Ok(found);
    }
    let path = PathBuf::from(scene);
    if path.is_file() {
        return Ok(path);
    }
    let folders = scene_folders();
    if !scene.contains(['/', '\\']) {
        for folder in &folders {
            for file in ENDINGS.map(|ending| folder.join(format!("{scene}.{ending}"))) {
                if file.is_file() {
                    return Ok(file);
                }
            }
        }
    }
    let mut known: Vec<String> = folders.iter().flat_map(|folder| names_in(folder)).collect();
    known.sort();
    known.dedup();
    let what = if path.is_dir() { "is a folder, not a scene" } else { "is neither a file nor a known scene" };
    if known.is_empty() {
        bail!("`{scene}` {what}; give a .scene.ron, .prefab.ron, .gltf or .glb file");
    }
    let all = format!("known scenes: {}", known.join(", "));
    match suggestion(scene, known.iter().map(String::as_str)).filter(|words| words.starts_with("did you mean")) {
        Some(meant) => bail!("`{scene}` {what}; {meant} {all}"),
        None => bail!("`{scene}` {what}; {all}"),
    }
}

/// The scene's name: its file name without `.scene.ron`, `.prefab.ron`, `.gltf` or `.glb`.
pub fn name_of(path: &Path) -> String {
    let file = path.file_name().map(|f| f.to_string_lossy().into_owned()).unwrap_or_default();
    let stem = ENDINGS.iter().find_map(|ending| file.strip_suffix(&format!(".{ending}")));
    stem.unwrap_or(&file).to_owned()
}

fn scene_folders() -> Vec<PathBuf> {
    if let Some(packed) = packed::game() {
        return vec![packed.assets().join("scenes"), packed.assets()];
    }
    let starts = [std::env::current_dir().ok(), std::env::current_exe().ok()];
    let above = starts.iter().flatten().flat_map(|start| start.ancestors().map(|dir| dir.join("scenes")));
    let source = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    let last = match SHIPPED.get() {
        Some(shipped) if !source.is_dir() => shipped(),
        _ => Some(source),
    };
    above.chain(last).filter(|folder| folder.is_dir()).collect()
}

fn names_in(folder: &Path) -> Vec<String> {
    let Ok(entries) = std::fs::read_dir(folder) else { return Vec::new() };
    let files = entries.flatten().map(|entry| entry.path());
    files.filter(|path| path.to_string_lossy().ends_with(".scene.ron")).map(|path| name_of(&path)).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn names_lose_their_endings() {
        assert_eq!(name_of(Path::new("a/cornell.scene.ron")), "cornell");
        assert_eq!(name_of(Path::new("a/box.glb")), "box");
    }

    #[test]
    fn files_come_before_names() {
        let dir = tempfile::tempdir().unwrap();
        let file = dir.path().join("x.glb");
        std::fs::write(&file, b"").unwrap();
        assert_eq!(find(&file.to_string_lossy()).unwrap(), file);
        let message = find("no such scene").unwrap_err().to_string();
        assert!(message.contains("`no such scene`"), "{message}");
    }
}
