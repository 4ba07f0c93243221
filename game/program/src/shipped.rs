//! The scenes and prefabs that come with the program, for machines without the source tree.

use anyhow::{Context, Result};
use std::path::{Path, PathBuf};
use xxhash_rust::xxh3::Xxh3;

/// Names with `/` on every system, and texts.
const FILES: &[(&str, &str)] = include!(concat!(env!("OUT_DIR"), "/shipped.rs"));

/// The folder of shipped scenes in the user's own folder of data. What was edited there stays until the program is
/// another.
pub fn scenes() -> Option<PathBuf> {
    let folders = directories::ProjectDirs::from("", "", "lightwell")?;
    let folder = folders.data_local_dir().join(format!("shipped-{:016x}", hash()));
    match unpack(&folder) {
        Ok(()) => Some(folder.join("scenes")),
        Err(error) => {
            log::warn!("the shipped scenes cannot be unpacked: {error:#}");
            None
        }
    }
}

fn hash() -> u64 {
    let mut hash = Xxh3::new();
    for (name, text) in FILES {
        hash.update(name.as_bytes());
        hash.update(text.as_bytes());
    }
    hash.digest()
}

/// Writes all files into a new folder in one step, unless it is there.
fn unpack(folder: &Path) -> Result<()> {
    if folder.is_dir() {
        return Ok(());
    }
    let parent = folder.parent().context("no folder")?;
    std::fs::create_dir_all(parent)?;
    let aside = tempfile::tempdir_in(parent)?;
    for (name, text) in FILES {
        let path = aside.path().join(name);
        std::fs::create_dir_all(path.parent().context("no folder")?)?;
        std::fs::write(&path, text).with_context(|| format!("cannot write {}", path.display()))?;
    }
    match std::fs::rename(aside.path(), folder) {
        // Another program may have been quicker.
        Err(_) if folder.is_dir() => {}
        result => {
            result?;
            let _ = aside.keep();
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use lightwell::assets::AssetLibrary;
    use lightwell::files::{LoadOptions, load_scene};

    #[test]
    fn shipped_scenes_can_be_loaded_without_the_source_tree() {
        let place = tempfile::tempdir().unwrap();
        let folder = place.path().join("shipped");
        unpack(&folder).unwrap();
        for name in ["cornell", "courtyard", "studio"] {
            let path = folder.join("scenes").join(format!("{name}.scene.ron"));
            load_scene(&path, &mut AssetLibrary::new(), &LoadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
        }
        // What was edited stays.
        let edited = folder.join("scenes/cornell.scene.ron");
        std::fs::write(&edited, "Scene()").unwrap();
        unpack(&folder).unwrap();
        assert_eq!(std::fs::read_to_string(&edited).unwrap(), "Scene()");
        assert_eq!(std::fs::read_dir(place.path()).unwrap().count(), 1);
    }
}
