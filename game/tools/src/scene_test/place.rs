//! Files that a scene test names.

use anyhow::Result;
use lightwell_runtime::cli::Common;
use lightwell_runtime::scene_path;
use std::path::{Path, PathBuf};

/// Where a file is, or why there cannot be one.
#[derive(Debug, PartialEq, Eq)]
pub enum Place {
    /// The file, which may still not be there.
    File(PathBuf),
    /// It lies in a folder that was not given.
    NotGiven(String),
}

/// The file of a path: below `$LIGHTWELL_MODELS/` or `$LIGHTWELL_REFERENCE/` if it begins so, else from the folder on.
pub fn file(written: &str, folder: &Path, common: &Common) -> Place {
    let reference = || std::env::var_os("LIGHTWELL_REFERENCE").map(PathBuf::from);
    if let Some(rest) = written.strip_prefix("$LIGHTWELL_REFERENCE/") {
        return below(
            reference(),
            rest,
            "LIGHTWELL_REFERENCE is not set: reference images are not part of the project",
        );
    }
    if let Some(rest) = written.strip_prefix("$LIGHTWELL_MODELS/") {
        return below(common.models.clone(), rest, "neither --models nor LIGHTWELL_MODELS is given");
    }
    Place::File(folder.join(written))
}

fn below(folder: Option<PathBuf>, rest: &str, why_not: &str) -> Place {
    folder.map_or(Place::NotGiven(why_not.to_owned()), |folder| Place::File(folder.join(rest)))
}

/// The file of a scene: as [`file`], or a shipped scene by name.
///
/// # Errors
/// If there is no such scene.
pub fn scene(written: &str, folder: &Path, common: &Common) -> Result<Place> {
    match file(written, folder, common) {
        Place::File(path) if !path.is_file() && !written.starts_with('$') => scene_path::find(written).map(Place::File),
        place => Ok(place),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn paths_start_where_they_say() {
        let with = Common { models: Some("models".into()), ..Common::default() };
        let without = Common::default();
        let folder = Path::new("tests");
        assert_eq!(file("a.exr", folder, &without), Place::File("tests/a.exr".into()));
        assert_eq!(file("$LIGHTWELL_MODELS/x/y.glb", folder, &with), Place::File("models/x/y.glb".into()));
        let Place::NotGiven(reason) = file("$LIGHTWELL_MODELS/y.glb", folder, &without) else { panic!("a place") };
        assert!(reason.contains("--models"), "{reason}");
    }

    #[test]
    fn scenes_go_by_file_or_name() {
        let dir = tempfile::tempdir().unwrap();
        std::fs::write(dir.path().join("cornell"), "").unwrap();
        let common = Common::default();
        assert_eq!(scene("cornell", dir.path(), &common).unwrap(), Place::File(dir.path().join("cornell")));
        let Place::File(shipped) = scene("cornell", Path::new("nowhere"), &common).unwrap() else { panic!("no place") };
        assert!(shipped.ends_with("cornell.scene.ron"), "{}", shipped.display());
        let none = scene("corn", dir.path(), &common).unwrap_err().to_string();
        assert!(none.contains("cornell"), "{none}");
    }
}
