//! The files that are drawn: scenes, prefabs and models.

use anyhow::{Context, Result};
use lightwell_runtime::scene_path;
use std::path::{Path, PathBuf};

/// Folders deeper than this are not searched: links may lead in circles.
const MAX_DEPTH: usize = 16;

/// A model or scene.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Subject {
    /// Name of its cell: its file name, after its folder below the one that was searched.
    pub name: String,
    /// The file.
    pub path: PathBuf,
}

/// The files of all paths in their order; folders with all below them, by name. A path may be a scene's name.
///
/// # Errors
/// If a path is neither a file nor a folder nor a scene, or a folder cannot be read.
pub fn find(paths: &[PathBuf]) -> Result<Vec<Subject>> {
    let mut subjects: Vec<Subject> = Vec::new();
    for path in paths {
        let mut found = Vec::new();
        if path.is_dir() {
            search(path, "", 0, &mut found)?;
        } else {
            let path = scene_path::find(&path.to_string_lossy())?;
            found.push(Subject { name: label(&path, ""), path });
        }
        found.sort_by_key(|subject| natural(&subject.name));
        found.retain(|subject| subjects.iter().all(|known| known.path != subject.path));
        subjects.append(&mut found);
    }
    Ok(subjects)
}

fn search(folder: &Path, prefix: &str, depth: usize, found: &mut Vec<Subject>) -> Result<()> {
    let unreadable = || format!("the folder {} cannot be read", folder.display());
    for entry in std::fs::read_dir(folder).with_context(unreadable)? {
        let path = entry.with_context(unreadable)?.path();
        if path.is_dir() && depth < MAX_DEPTH {
            let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
            search(&path, &format!("{prefix}{name}/"), depth + 1, found)?;
        } else if path.is_file() && is_scene(&path) {
            found.push(Subject { name: label(&path, prefix), path });
        }
    }
    Ok(())
}

fn is_scene(path: &Path) -> bool {
    let name = path.file_name().map(|name| name.to_string_lossy().to_lowercase()).unwrap_or_default();
    [".scene.ron", ".prefab.ron", ".gltf", ".glb"].iter().any(|ending| name.ends_with(ending))
}

/// The name without its ending; a folder that only repeats it is left out.
fn label(path: &Path, prefix: &str) -> String {
    let name = scene_path::name_of(path);
    let folders: Vec<&str> = prefix.split('/').filter(|part| !part.is_empty() && *part != name).collect();
    folders.into_iter().chain([name.as_str()]).collect::<Vec<_>>().join("/")
}

/// Key by which 2 comes before 10.
fn natural(name: &str) -> Vec<(u64, String)> {
    let mut parts = vec![(0u64, String::new())];
    let mut was_digit = false;
    for c in name.chars() {
        let digit = c.to_digit(10);
        if digit.is_some() && !was_digit {
            parts.push((0, String::new()));
        }
        if let Some(last) = parts.last_mut() {
            match digit {
                Some(digit) => last.0 = last.0.saturating_mul(10).saturating_add(u64::from(digit)),
                None => last.1.extend(c.to_lowercase()),
            }
        }
        was_digit = digit.is_some();
    }
    parts
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn folders_are_walked_in_natural_order() {
        let dir = tempfile::tempdir().unwrap();
        for file in
            ["b/model 10.glb", "b/model 2.gltf", "a/a.scene.ron", "a/notes.txt", "b/model.bin", "b/box.prefab.ron"]
        {
            let path = dir.path().join(file);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, b"").unwrap();
        }
        let found = find(&[dir.path().to_owned(), dir.path().join("a")]).unwrap();
        let names: Vec<&str> = found.iter().map(|subject| subject.name.as_str()).collect();
        assert_eq!(names, ["a", "b/box", "b/model 2", "b/model 10"]);
        assert!(find(&[dir.path().join("nothing")]).is_err());
    }
}
