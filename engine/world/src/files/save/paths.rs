//! Paths in files, which start at the folder of the file: the same files named from another folder.

use crate::files::error::{FileError, FileErrorKind as Kind};
use crate::files::format::scene_file::*;
use crate::files::load::trust::real;
use crate::world::{Camera, Environment, SceneSettings};
use std::path::{Component, Path, PathBuf};

/// A path that cannot be said from another folder.
#[derive(Debug)]
pub(in crate::files) struct NoWay {
    written: String,
    to: PathBuf,
}

impl NoWay {
    /// The error of the file that would have said it.
    pub fn at_file(self, file: &Path) -> FileError {
        let message = format!("there is no relative path to `{}` from {}", self.written, self.to.display());
        FileError::new(file, Kind::Unsavable, message)
            .with_help("save it on the same drive, or name the file by its whole path")
    }
}

type Result = std::result::Result<(), NoWay>;

/// Says paths that start at one folder from another one.
pub(in crate::files) struct Rebase {
    from: PathBuf,
    to: PathBuf,
    models: Option<PathBuf>,
}

impl Rebase {
    /// From one folder to another one.
    pub fn new(from: &Path, to: &Path) -> Self {
        Self { from: real(from), to: real(to), models: None }
    }

    /// The same where models and images may lie below a folder of their own: paths to those stay.
    pub fn with_models(self, models: Option<&Path>) -> Self {
        Self { models: models.map(Path::to_owned), ..self }
    }

    /// Whether the folders are two.
    pub fn moves(&self) -> bool {
        self.from != self.to
    }

    /// All of a scene.
    pub fn scene(&self, scene: &mut SceneFile) -> Result {
        self.settings(&mut scene.settings)?;
        scene.materials.values_mut().try_for_each(|material| self.material(material))?;
        scene.entities.iter_mut().try_for_each(|entity| self.entity(entity))
    }

    /// All of a prefab.
    pub fn prefab(&self, prefab: &mut PrefabFile) -> Result {
        prefab.materials.values_mut().try_for_each(|material| self.material(material))?;
        prefab.entities.iter_mut().try_for_each(|entity| self.entity(entity))
    }

    /// The sky's image.
    pub fn settings(&self, settings: &mut SceneSettings) -> Result {
        match &mut settings.environment {
            Some(Environment::Image { file, .. }) => self.path(file),
            _ => Ok(()),
        }
    }

    /// An entity with all below it.
    pub fn entity(&self, entity: &mut EntityFile) -> Result {
        self.surface(&mut entity.model, &mut entity.material)?;
        self.camera(&mut entity.camera)?;
        entity.prefab.iter_mut().try_for_each(|prefab| self.path(prefab))?;
        entity.overrides.values_mut().try_for_each(|patch| self.patch(patch))?;
        entity.children.iter_mut().try_for_each(|child| self.entity(child))
    }

    /// The overrides of an instance.
    pub fn patch(&self, patch: &mut OverrideFile) -> Result {
        self.surface(&mut patch.model, &mut patch.material)?;
        self.camera(&mut patch.camera)?;
        patch.children.iter_mut().try_for_each(|child| self.entity(child))
    }

    /// The colour table of a camera.
    pub fn camera(&self, camera: &mut Option<Camera>) -> Result {
        match camera.as_mut().and_then(|camera| camera.lens.grading.as_mut()) {
            Some(table) => self.asset(table),
            None => Ok(()),
        }
    }

    fn surface(&self, model: &mut Option<ModelFile>, material: &mut Option<MaterialRef>) -> Result {
        self.model(model)?;
        self.material_ref(material)
    }

    /// A model.
    pub fn model(&self, model: &mut Option<ModelFile>) -> Result {
        match model {
            Some(ModelFile::Path(path) | ModelFile::Detailed(ModelDetails { path, .. })) => self.asset(path),
            None => Ok(()),
        }
    }

    /// A material that is written out.
    pub fn material_ref(&self, material: &mut Option<MaterialRef>) -> Result {
        match material {
            Some(MaterialRef::Inline(material)) => self.material(material),
            _ => Ok(()),
        }
    }

    /// The images of a material.
    pub fn material(&self, material: &mut MaterialFile) -> Result {
        let images = [
            &mut material.color_texture,
            &mut material.metallic_roughness_texture,
            &mut material.normal_texture,
            &mut material.emissive_texture,
            &mut material.transmission_texture,
        ];
        images.into_iter().flatten().try_for_each(|image| self.texture(image))
    }

    /// An image.
    pub fn texture(&self, image: &mut TextureFile) -> Result {
        let (TextureFile::Path(path) | TextureFile::Sampled(SampledTexture { path, .. })) = image;
        self.asset(path)
    }

    /// A model or an image. One that does not lie where the path leads to is found by it elsewhere: below the folder of
    /// models.
    fn asset(&self, written: &mut String) -> Result {
        let is_model = self.models.as_ref().is_some_and(|models| models.join(&*written).is_file());
        match is_model || !self.from.join(&*written).is_file() {
            true => Ok(()),
            false => self.path(written),
        }
    }

    /// A path; a whole one stays.
    pub fn path(&self, written: &mut String) -> Result {
        if Path::new(&*written).has_root() || !self.moves() {
            return Ok(());
        }
        let target = real(&self.from.join(&*written));
        // What is a link is named by its own name.
        let target = if target.ends_with(written_name(written)) { target } else { plain(&self.from.join(&*written)) };
        match relative(&target, &self.to) {
            Some(path) => *written = path,
            None => return Err(NoWay { written: written.clone(), to: self.to.clone() }),
        }
        Ok(())
    }
}

fn written_name(written: &str) -> PathBuf {
    Path::new(written).file_name().map(PathBuf::from).unwrap_or_default()
}

/// The path without `.` and `..`, as it is written.
fn plain(path: &Path) -> PathBuf {
    let mut plain = PathBuf::new();
    for part in path.components() {
        match part {
            Component::ParentDir => drop(plain.pop()),
            Component::CurDir => {}
            part => plain.push(part),
        }
    }
    plain
}

/// The way from a folder to a file, whatever links lead to either; one that is a link itself keeps its name. None between
/// drives.
pub(in crate::files) fn way_to(file: &Path, folder: &Path) -> Option<String> {
    let file = std::path::absolute(file).ok()?;
    relative(&real(file.parent()?).join(file.file_name()?), &real(folder))
}

/// The way from a folder to a file, with `/` on every system; none between drives.
fn relative(file: &Path, folder: &Path) -> Option<String> {
    let (file, folder): (Vec<_>, Vec<_>) = (file.components().collect(), folder.components().collect());
    let common = file.iter().zip(&folder).take_while(|(a, b)| a == b).count();
    if common == 0 {
        return None;
    }
    let up = std::iter::repeat_n("..".into(), folder.len() - common);
    let down = file[common..].iter().map(|part| part.as_os_str().to_string_lossy());
    Some(up.chain(down).collect::<Vec<_>>().join("/"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ways_go_up_and_down() {
        let way = |file: &str| relative(Path::new(file), Path::new("/a/b"));
        assert_eq!(way("/a/b/c.ron").as_deref(), Some("c.ron"));
        assert_eq!(way("/a/d/c.ron").as_deref(), Some("../d/c.ron"));
        assert_eq!(way("/x.ron").as_deref(), Some("../../x.ron"));
        assert_eq!(way("x.ron"), None);
    }
}
