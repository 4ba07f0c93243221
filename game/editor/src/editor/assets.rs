//! Files to pick from.

use std::path::{Path, PathBuf};

/// Most files that are listed.
const MOST: usize = 300;
/// How deep folders are looked into.
const DEPTH: usize = 3;

/// Files of some endings in and below some folders, as paths from the first folder that has them.
pub fn find(folders: &[PathBuf], endings: &[&str]) -> Vec<String> {
    let mut found = Vec::new();
    for folder in folders {
        collect(folder, folder, endings, DEPTH, &mut found);
    }
    found.sort();
    found.dedup();
    found
}

fn collect(root: &Path, folder: &Path, endings: &[&str], depth: usize, found: &mut Vec<String>) {
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    for path in entries.flatten().map(|entry| entry.path()) {
        if found.len() >= MOST {
            return;
        }
        let name = path.file_name().map(|n| n.to_string_lossy().to_lowercase()).unwrap_or_default();
        if path.is_dir() && depth > 0 && !name.starts_with('.') {
            collect(root, &path, endings, depth - 1, found);
        } else if endings.iter().any(|ending| name.ends_with(&format!(".{ending}"))) {
            found.push(path.strip_prefix(root).unwrap_or(&path).display().to_string());
        }
    }
}
