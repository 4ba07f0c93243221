//! Where files of a game lie in the packed folder: as in the source tree, from the folder that holds all of them.

use anyhow::{Context, Result, bail};
use lightwell::files::project_root;
use lightwell::packed::{ASSETS, MODELS};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// A file that is packed.
#[derive(Debug, PartialEq)]
pub struct Packed {
    pub from: PathBuf,
    /// Path in the packed folder, with `/` on every system.
    pub to: String,
    /// Whether the game itself has loaded it, and so has to load it where it is packed.
    pub is_loaded: bool,
}

/// All files of a game, its first scene first.
#[derive(Debug)]
pub struct Layout {
    pub files: Vec<Packed>,
}

impl Layout {
    /// The layout of files that a game loads, its first scene first, and of more files. All paths are absolute; `models`
    /// is the folder of third-party models.
    ///
    /// # Errors
    /// If files lie in folders that have nothing to do with each other.
    pub fn new(loaded: &[PathBuf], more: &[PathBuf], models: Option<&Path>) -> Result<Self> {
        let scene = loaded.first().context("the game names no scene")?;
        let is_model = |path: &Path| models.is_some_and(|models| path.starts_with(models));
        let known: BTreeSet<&PathBuf> = loaded.iter().collect();
        let more = more.iter().filter(|path| !known.contains(path)).map(|path| (path.as_path(), false));
        let all: Vec<(&Path, bool)> = loaded.iter().map(|path| (path.as_path(), true)).chain(more).collect();
        let own: Vec<&Path> = all.iter().map(|(path, _)| *path).filter(|path| !is_model(path)).collect();
        let root = common_folder(&own).unwrap_or_default();
        if !is_game_folder(&root) {
            let project = project_root(scene);
            let away = own.iter().find(|path| !path.starts_with(&project)).copied().unwrap_or(scene);
            bail!(
                "{} lies outside of {}, the folder of the game; move it there, or pass --models with its folder",
                away.display(),
                project.display()
            );
        }
        let to = |path: &Path| -> Result<String> {
            match models.filter(|_| is_model(path)) {
                Some(models) => Ok(format!("{ASSETS}/{MODELS}/{}", below(path, models)?)),
                None => Ok(format!("{ASSETS}/{}", below(path, &root)?)),
            }
        };
        let files = all
            .iter()
            .map(|(path, is_loaded)| Ok(Packed { from: path.to_path_buf(), to: to(path)?, is_loaded: *is_loaded }));
        Ok(Self { files: files.collect::<Result<_>>()? })
    }

    /// Where a file lies in the packed folder.
    pub fn packed(&self, from: &Path) -> Option<&str> {
        self.files.iter().find(|file| file.from == from).map(|file| file.to.as_str())
    }

    /// Copies all files into a folder.
    ///
    /// # Errors
    /// If one cannot be read or written.
    pub fn copy(&self, folder: &Path) -> Result<()> {
        self.files.iter().try_for_each(|file| super::copy(&file.from, &folder.join(&file.to)))
    }
}

/// The deepest folder that holds all files.
fn common_folder(files: &[&Path]) -> Option<PathBuf> {
    let folders = files.iter().filter_map(|path| path.parent());
    folders
        .map(Path::to_owned)
        .reduce(|a, b| a.components().zip(b.components()).take_while(|(a, b)| a == b).map(|(part, _)| part).collect())
}

/// Whether it is not the folder of all files of a system or a user.
fn is_game_folder(folder: &Path) -> bool {
    let home = std::env::home_dir().and_then(|home| home.canonicalize().ok());
    folder.parent().is_some() && home.is_none_or(|home| !home.starts_with(folder))
}

fn below(path: &Path, folder: &Path) -> Result<String> {
    let rest = path.strip_prefix(folder)?;
    let parts = rest.iter().map(|part| part.to_str()).collect::<Option<Vec<_>>>();
    let written = parts.with_context(|| format!("the name of {} is not Unicode", path.display()))?.join("/");
    if written.contains('\n') {
        bail!("the name of {written:?} has two lines");
    }
    Ok(written)
}

/// The files that the user names, and all below the folders among them, as absolute paths.
///
/// # Errors
/// If there is no such file.
pub fn included(paths: &[PathBuf]) -> Result<Vec<PathBuf>> {
    let mut found = Vec::new();
    for path in paths {
        let path =
            path.canonicalize().with_context(|| format!("--include {}: there is no such file", path.display()))?;
        collect(&path, &mut found)?;
    }
    found.sort();
    found.dedup();
    Ok(found)
}

fn collect(path: &Path, found: &mut Vec<PathBuf>) -> Result<()> {
    if !path.is_dir() {
        found.push(path.to_owned());
        return Ok(());
    }
    let entries = std::fs::read_dir(path).with_context(|| format!("cannot read the folder {}", path.display()))?;
    for entry in entries {
        let entry = entry?;
        // What is hidden belongs to tools, and links may lead in circles.
        if !entry.file_name().to_string_lossy().starts_with('.') && !entry.file_type()?.is_symlink() {
            collect(&entry.path(), found)?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn paths(root: &Path, names: &[&str]) -> Vec<PathBuf> {
        names.iter().map(|name| root.join(name)).collect()
    }

    #[test]
    fn files_keep_their_places_and_models_get_one() {
        let folder = tempfile::tempdir().unwrap();
        let root = folder.path();
        let loaded = paths(root, &["game/scenes/a.scene.ron", "game/prefabs/b.prefab.ron", "models/hall/hall.glb"]);
        let more = paths(root, &["game/sounds/c.wav", "game/scenes/a.scene.ron"]);
        let layout = Layout::new(&loaded, &more, Some(&root.join("models"))).unwrap();
        let to: Vec<_> = layout.files.iter().map(|file| (file.to.as_str(), file.is_loaded)).collect();
        let expected = [
            ("assets/scenes/a.scene.ron", true),
            ("assets/prefabs/b.prefab.ron", true),
            ("assets/third_party/hall/hall.glb", true),
            ("assets/sounds/c.wav", false),
        ];
        assert_eq!(to, expected);
        assert_eq!(layout.packed(&more[0]), Some("assets/sounds/c.wav"));
        let alone = Layout::new(&loaded[..1], &[], None).unwrap();
        assert_eq!(alone.files[0].to, "assets/a.scene.ron");
    }

    #[test]
    #[cfg(unix)]
    fn files_of_the_whole_system_are_no_game() {
        let folder = tempfile::tempdir().unwrap();
        let scene = folder.path().join("a.scene.ron");
        let error = Layout::new(&[scene, "/etc/sky.hdr".into()], &[], None).unwrap_err().to_string();
        assert!(error.starts_with("/etc/sky.hdr lies outside of"), "{error}");
        assert!(Layout::new(&[], &[], None).is_err());
    }

    #[test]
    fn folders_are_included_without_what_is_hidden() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["b.wav", "inner/a.wav", ".git/config", "inner/.hidden"] {
            std::fs::create_dir_all(folder.path().join(name).parent().unwrap()).unwrap();
            std::fs::write(folder.path().join(name), "").unwrap();
        }
        let root = folder.path().canonicalize().unwrap();
        let found = included(&[folder.path().to_owned(), folder.path().join("b.wav")]).unwrap();
        assert_eq!(found, paths(&root, &["b.wav", "inner/a.wav"]));
        let error = included(&["no/such".into()]).unwrap_err().to_string();
        assert_eq!(error, "--include no/such: there is no such file");
    }
}
