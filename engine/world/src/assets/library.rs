//! The cache of loaded assets.

use super::{AssetError, Gltf, ImportFault, ImportSettings, LoadBudget, Mesh, Meter, Sampling, Shape, Texture};
use std::collections::{BTreeSet, HashMap};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Identity and settings of a texture file.
type TextureKey = (PathBuf, bool, Sampling);

/// Loads assets and keeps them: asking twice for the same file with the same settings gives the same `Arc`.
#[derive(Clone, Debug, Default)]
pub struct AssetLibrary {
    shapes: HashMap<String, Arc<Mesh>>,
    textures: HashMap<TextureKey, Arc<Texture>>,
    models: HashMap<PathBuf, Arc<Gltf>>,
    imported: HashMap<(PathBuf, String), Arc<Gltf>>,
    noted: BTreeSet<PathBuf>,
    remarks: BTreeSet<String>,
    /// What loads before the present one looked for.
    asked: BTreeSet<PathBuf>,
    meter: Arc<Meter>,
    is_strict: bool,
}

impl AssetLibrary {
    /// An empty library.
    pub fn new() -> Self {
        Self::default()
    }

    /// Begins a load, which may take so much. A strict one refuses models of which something is broken.
    pub(crate) fn begin_load(&mut self, budget: &LoadBudget, is_strict: bool) {
        self.asked.extend(self.meter.asked());
        self.meter = Arc::new(Meter::new(budget));
        self.is_strict = is_strict;
    }

    /// The amounts that the present load has taken.
    pub(crate) fn meter(&self) -> &Meter {
        &self.meter
    }

    /// The mesh of a procedural shape.
    ///
    /// # Errors
    /// Parameters that make no shape.
    pub fn shape(&mut self, shape: &Shape) -> Result<Arc<Mesh>, AssetError> {
        let key = format!("{shape:?}");
        if let Some(mesh) = self.shapes.get(&key) {
            return Ok(mesh.clone());
        }
        let mesh = Arc::new(shape.mesh()?);
        self.meter.triangles(Path::new(&key), mesh.triangle_count() as u64)?;
        self.shapes.insert(key, mesh.clone());
        Ok(mesh)
    }

    /// The texture of a PNG or JPEG file. `srgb`: its colours are sRGB-encoded, as base colour and emission are.
    ///
    /// # Errors
    /// The file cannot be read or decoded, or is larger than [`super::MAX_IMAGE_SIZE`].
    pub fn texture(
        &mut self,
        path: impl AsRef<Path>,
        srgb: bool,
        sampling: Sampling,
    ) -> Result<Arc<Texture>, AssetError> {
        let path = path.as_ref();
        let key = (identity(path), srgb, sampling);
        if let Some(texture) = self.textures.get(&key) {
            return Ok(texture.clone());
        }
        let texture = Arc::new(load_texture(path, srgb, sampling, &self.meter)?);
        self.textures.insert(key, texture.clone());
        Ok(texture)
    }

    /// The content of a `.gltf` or `.glb` file.
    ///
    /// # Errors
    /// Those of [`Gltf::load`].
    pub fn gltf(&mut self, path: impl AsRef<Path>) -> Result<Arc<Gltf>, AssetError> {
        let path = path.as_ref();
        let key = identity(path);
        if let Some(model) = self.models.get(&key) {
            return Ok(model.clone());
        }
        let model = Arc::new(load_model(path, &self.meter, self.is_strict)?);
        self.models.insert(key, model.clone());
        Ok(model)
    }

    /// Warnings of what models' files hold that is changed on import, each with its file.
    pub fn warnings(&self) -> impl Iterator<Item = String> + '_ {
        let mut models: Vec<&Arc<Gltf>> = self.models.values().collect();
        models.sort_unstable_by(|a, b| a.path.cmp(&b.path));
        models
            .into_iter()
            .flat_map(|model| model.warnings.iter().map(|warning| format!("{}: {warning}", model.path.display())))
    }

    /// Whether anything of the models is broken, and was mended or left out.
    pub fn has_faults(&self) -> bool {
        self.models.values().any(|model| !model.faults.is_empty())
    }

    /// What was decided in loading models, each with its file.
    pub fn remarks(&self) -> impl Iterator<Item = &str> {
        self.remarks.iter().map(String::as_str)
    }

    /// Remembers a decision of a load for [`AssetLibrary::remarks`], and logs it the first time.
    pub fn remark(&mut self, remark: String) {
        if !self.remarks.contains(&remark) {
            log::info!("{remark}");
            self.remarks.insert(remark);
        }
    }

    /// A model as import settings want it; `model` is one of this library's.
    ///
    /// # Errors
    /// Those of [`ImportSettings::apply`].
    pub fn imported(&mut self, model: &Arc<Gltf>, settings: &ImportSettings) -> Result<Arc<Gltf>, ImportFault> {
        if *settings == ImportSettings::default() {
            return Ok(model.clone());
        }
        let key = (identity(&model.path), format!("{settings:?}"));
        if let Some(imported) = self.imported.get(&key) {
            return Ok(imported.clone());
        }
        let imported = Arc::new(settings.apply(Gltf::clone(model))?);
        self.imported.insert(key, imported.clone());
        Ok(imported)
    }

    /// Remembers a file that something was made from beside the assets, such as a prefab, for [`AssetLibrary::files`].
    pub fn note(&mut self, path: impl AsRef<Path>) {
        self.ask(path.as_ref());
        self.noted.insert(identity(path.as_ref()));
    }

    /// Remembers a file that is looked for, for [`AssetLibrary::watched`].
    pub(crate) fn ask(&self, path: &Path) {
        self.meter.ask(path);
    }

    /// All files on which depends what is made: [`AssetLibrary::files`], and those that were looked for and are not
    /// there, as a load that failed noted them. Links are in it beside the files that they lead to.
    pub fn watched(&self) -> BTreeSet<PathBuf> {
        let mut watched = self.files();
        watched.extend(self.asked.iter().cloned());
        watched.extend(self.meter.asked());
        watched
    }

    /// Takes over what another library looked for, one whose load failed.
    pub fn watch_also(&mut self, other: &Self) {
        self.asked.extend(other.watched());
    }

    /// All files that something was made from: textures, models with their buffers and images, and what was noted.
    pub fn files(&self) -> BTreeSet<PathBuf> {
        let textures = self.textures.keys().map(|(path, ..)| path.clone());
        let models = self.models.iter().flat_map(|(path, model)| {
            let beside = model.files.iter().map(|file| identity(file));
            std::iter::once(path.clone()).chain(beside)
        });
        textures.chain(models).chain(self.noted.iter().cloned()).collect()
    }

    /// Reloads everything that came from this file: textures, models, and models that refer to it as an image or
    /// buffer. Returns whether there was anything. Whoever holds an old `Arc` keeps the old content.
    ///
    /// # Errors
    /// The first fault met. The library then keeps the last good content of what could not be loaded.
    pub fn reload(&mut self, path: impl AsRef<Path>) -> Result<bool, AssetError> {
        let changed = identity(path.as_ref());
        self.begin_load(&self.meter.budget().clone(), self.is_strict);
        let (meter, is_strict) = (&self.meter, self.is_strict);
        let mut found = false;
        let mut fault = None;
        for (key, texture) in self.textures.iter_mut().filter(|(key, _)| key.0 == changed) {
            found = true;
            match load_texture(&key.0, key.1, key.2, meter) {
                Ok(new) => *texture = Arc::new(new),
                Err(e) => fault = fault.or(Some(e)),
            }
        }
        for (key, model) in &mut self.models {
            if *key != changed && !model.files.iter().any(|f| identity(f) == changed) {
                continue;
            }
            found = true;
            self.imported.retain(|(path, _), _| path != key);
            match load_model(key, meter, is_strict) {
                Ok(new) => *model = Arc::new(new),
                Err(e) => fault = fault.or(Some(e)),
            }
        }
        fault.map_or(Ok(found), Err)
    }

    /// Forgets all assets that nobody else holds.
    pub fn drop_unused(&mut self) {
        self.shapes.retain(|_, v| Arc::strong_count(v) > 1);
        self.textures.retain(|_, v| Arc::strong_count(v) > 1);
        let is_used = |model: &Arc<Gltf>| {
            let shared = |p: &super::GltfPrimitive| Arc::strong_count(&p.0) > 1 || Arc::strong_count(&p.1) > 1;
            Arc::strong_count(model) > 1 || model.nodes.iter().any(|n| n.primitives.iter().any(shared))
        };
        self.imported.retain(|_, model| is_used(model));
        self.models.retain(|_, model| is_used(model));
    }
}

/// One name for each file, however it is written; the path itself where the file is not there.
fn identity(path: &Path) -> PathBuf {
    path.canonicalize().unwrap_or_else(|_| path.to_path_buf())
}

fn load_model(path: &Path, meter: &Meter, is_strict: bool) -> Result<Gltf, AssetError> {
    let model = Gltf::load_within(path, meter)?;
    let Some(fault) = model.faults.first().filter(|_| is_strict) else { return Ok(model) };
    let more = match model.faults.len() - 1 {
        0 => String::new(),
        more => format!(" (and {more} more faults)"),
    };
    Err(AssetError::format(path, "strict", format!("{fault}{more}")))
}

fn load_texture(path: &Path, srgb: bool, sampling: Sampling, meter: &Meter) -> Result<Texture, AssetError> {
    let bytes = super::read_file(path, meter)?;
    let pixels = super::image::decode(path, "image", &bytes, meter)?;
    Ok(Texture::from_pixels(path.display().to_string(), pixels, srgb, sampling))
}
