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

impl Packed {
    /// Where it lies if the packed folder is this one.
    pub fn within(&self, folder: &Path) -> PathBuf {
        let mut path = folder.to_owned();
        path.extend(self.to.split('/'));
        path
    }
}

/// Folders that files of a game lie in, beside the project of its first scene. All paths are absolute.
#[derive(Debug, Default)]
pub struct Folders {
    /// The one that the game's paths start at, then what the user trusts.
    pub own: Vec<PathBuf>,
    /// That of third-party models.
    pub models: Option<PathBuf>,
}

/// All files of a game, its first scene first.
#[derive(Debug)]
pub struct Layout {
    pub files: Vec<Packed>,
}

impl Layout {
    /// The layout of files that a game loads, its first scene first, and of more files. All paths are absolute.
    ///
    /// # Errors
    /// If a file lies outside of the game's folders.
    pub fn new(loaded: &[PathBuf], more: &[PathBuf], folders: &Folders) -> Result<Self> {
        let scene = loaded.first().context("the game names no scene")?;
        let known: BTreeSet<&PathBuf> = loaded.iter().collect();
        let more = more.iter().filter(|path| !known.contains(path)).map(|path| (path.as_path(), false));
        let all: Vec<(&Path, bool)> = loaded.iter().map(|path| (path.as_path(), true)).chain(more).collect();
        let models = folders.models.as_deref();
        let is_model = |path: &Path| models.is_some_and(|models| path.starts_with(models));
        let own: Vec<&Path> = all.iter().map(|(path, _)| *path).filter(|path| !is_model(path)).collect();
        let project = project_root(scene);
        let allowed: Vec<&Path> = std::iter::once(&project).chain(&folders.own).map(PathBuf::as_path).collect();
        if let Some(away) = own.iter().find(|path| !allowed.iter().any(|folder| path.starts_with(folder))) {
            bail!(
                "{} lies outside of the game's folder {}; move it there, or pass its folder with --trust, or with --models \
                 if scenes name it from there",
                away.display(),
                folders.own.first().unwrap_or(&project).display()
            );
        }
        let root = common_folder(&own).unwrap_or_default();
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
    pub fn packed(&self, from: &Path) -> Option<&Packed> {
        self.files.iter().find(|file| file.from == from)
    }

    /// Copies all files into a folder.
    ///
    /// # Errors
    /// If one cannot be read or written.
    pub fn copy(&self, folder: &Path) -> Result<()> {
        self.files.iter().try_for_each(|file| super::copy(&file.from, &file.within(folder)))
    }
}

/// The deepest folder that holds all files.
fn common_folder(files: &[&Path]) -> Option<PathBuf> {
    let folders = files.iter().filter_map(|path| path.parent());
    folders
        .map(Path::to_owned)
        .reduce(|a, b| a.components().zip(b.components()).take_while(|(a, b)| a == b).map(|(part, _)| part).collect())
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
        let folders = Folders { own: vec![root.join("game")], models: Some(root.join("models")) };
        let layout = Layout::new(&loaded, &more, &folders).unwrap();
        let to: Vec<_> = layout.files.iter().map(|file| (file.to.as_str(), file.is_loaded)).collect();
        let expected = [
            ("assets/scenes/a.scene.ron", true),
            ("assets/prefabs/b.prefab.ron", true),
            ("assets/third_party/hall/hall.glb", true),
            ("assets/sounds/c.wav", false),
        ];
        assert_eq!(to, expected);
        assert_eq!(layout.packed(&more[0]), layout.files.last());
        let alone = Layout::new(&loaded[..1], &[], &Folders::default()).unwrap();
        assert_eq!(alone.files[0].to, "assets/a.scene.ron");
    }

    #[test]
    fn files_of_other_folders_are_packed_only_if_they_are_trusted() {
        let folder = tempfile::tempdir().unwrap();
        let loaded = paths(folder.path(), &["game/a.scene.ron", "elsewhere/sky.hdr"]);
        let error = Layout::new(&loaded, &[], &Folders::default()).unwrap_err().to_string();
        assert!(error.contains("sky.hdr lies outside of") && error.contains("--trust"), "{error}");
        let folders = Folders { own: vec![folder.path().join("elsewhere")], models: None };
        let layout = Layout::new(&loaded, &[], &folders).unwrap();
        assert_eq!(layout.files[1].to, "assets/elsewhere/sky.hdr");
        assert!(Layout::new(&[], &[], &folders).is_err());
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
