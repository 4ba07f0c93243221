//! Where entities and assets come from, kept in the world so that a save writes them as they were described.

use crate::assets::{AssetId, Material};
use crate::core::GiMethod;
use crate::files::format::scene_file::{
    MaterialFile, MaterialRef, OverrideFile, Repeat, SceneFile, Shape, TextureFile,
};
use crate::files::ron::document::Document;
use bevy_ecs::prelude::{Component, Resource};
use std::collections::{BTreeMap, HashMap};
use std::path::PathBuf;
use std::sync::Arc;

/// How a file described the entity. What has changed since is written by its present value, all else as described.
#[derive(Component, Clone, Debug)]
pub struct Source {
    /// The components, overrides of prefab instances included.
    pub components: OverrideFile,
    /// The material that loading made from `components.material`.
    pub material: Option<Arc<Material>>,
    /// The prefab that the entity is an instance of, as the file names it.
    pub prefab: Option<String>,
    /// The copies that it makes of the prefab, if it is not one alone.
    pub repeat: Option<Repeat>,
    /// For an instance in the scene file: what the file says to change in it.
    pub overrides: BTreeMap<String, OverrideFile>,
    /// For an instance in the scene file: the paths of all of the prefab's entities below it.
    pub members: Vec<String>,
    /// Where the entity stands in the files.
    pub origin: Origin,
}

/// Which file an entity is described in.
#[derive(Clone, Debug)]
pub enum Origin {
    /// In the scene file itself.
    File,
    /// In a prefab.
    Prefab {
        /// Names from the instance in the scene file down to it.
        path: String,
        /// Its components without the overrides of the scene file.
        base: Box<OverrideFile>,
        /// Whether the scene file overrides its material.
        material_overridden: bool,
    },
    /// Made from a node of a glTF model; never written.
    Model,
}

/// What belongs to a scene file as a whole, besides its settings; and the descriptions of the assets it uses.
#[derive(Resource, Clone, Debug)]
pub struct SceneInfo {
    /// Version of the format that the file says.
    pub version: Option<u32>,
    /// What the scene shows, for people.
    pub description: String,
    /// Method of indirect light that it asks for.
    pub gi: GiMethod,
    /// Sets of changes by name, as `--set` writes them.
    pub presets: BTreeMap<String, Vec<String>>,
    /// Named materials.
    pub materials: BTreeMap<String, MaterialFile>,
    /// Shapes by the identity of their mesh. A world edited by code may add what it has made of shapes.
    pub shapes: HashMap<AssetId, Shape>,
    /// Material of shapes that are given none.
    pub default_material: Arc<Material>,
    /// Comments at the start of the file.
    pub(in crate::files) header: String,
    /// The file, and its text as it was read.
    pub(in crate::files) file: Option<(PathBuf, Arc<str>)>,
    pub(in crate::files) materials_by_id: HashMap<AssetId, MaterialRef>,
    pub(in crate::files) textures_by_id: HashMap<AssetId, TextureFile>,
}

impl Default for SceneInfo {
    fn default() -> Self {
        Self {
            version: None,
            description: String::new(),
            gi: GiMethod::default(),
            presets: BTreeMap::new(),
            materials: BTreeMap::new(),
            shapes: HashMap::new(),
            default_material: Arc::new(Material::new("default")),
            header: String::new(),
            file: None,
            materials_by_id: HashMap::new(),
            textures_by_id: HashMap::new(),
        }
    }
}

impl SceneInfo {
    pub(in crate::files) fn new(document: &Document, file: &SceneFile) -> Self {
        Self {
            version: file.version,
            description: file.description.clone(),
            gi: file.gi,
            presets: file.presets.clone(),
            materials: file.materials.clone(),
            header: document.header().to_owned(),
            file: Some((document.path.clone(), (&*document.whole_text()).into())),
            ..Self::default()
        }
    }
}
