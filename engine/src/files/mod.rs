//! Scene and prefab files.
//!
//! A scene is a `.scene.ron` file: settings, materials and a tree of named entities with their components. A prefab,
//! `.prefab.ron`, is such a tree to be instanced; an instance may override components by the path of an entity.
//! `.gltf`, `.glb` and `.prefab.ron` files open as scenes too.
//!
//! ```ron
//! Scene(
//!     description: "A red ball over a floor",
//!     settings: (duration: 4),
//!     materials: { "red": (color: (0.6, 0.05, 0.05), specular: 0) },
//!     entities: [
//!         (name: "Camera", transform: (translation: (0, 1, 4), look_at: (0, 0.5, 0)), camera: (fov: 45)),
//!         (name: "Sun", transform: (rotation: (-60, 30, 0)), light: (kind: Directional, intensity: 3)),
//!         (name: "Ball", transform: (translation: (0, 1, 0)), mesh: Sphere(radius: 0.5), material: "red"),
//!         (name: "Lamp", prefab: "../prefabs/lamp.prefab.ron", overrides: {
//!             "Head/Bulb": (light: (kind: Point, intensity: 2)),
//!         }),
//!         (name: "Hall", model: (path: "sponza/Sponza.gltf", source: "https://…", stand_in: "courtyard")),
//!     ],
//! )
//! ```
//!
//! Components of a game stand under their names, `components: {"Coin": (value: 5)}`, see [`SceneData`].
//!
//! Angles are degrees, lengths metres, colours linear Rec. 709. `Some(…)` need not be written. Paths of prefabs and
//! images start at the folder of the file that names them; those of models at the folder given by `--models`, or
//! else at the file's. No file is read outside of the scene's project ([`project_root`]), the folder of models and
//! the folders that the user trusts ([`LoadOptions::trusted`]).
//!
//! Every error names file, line and column, what is wrong and what to do ([`FileError`]). A load makes a new world,
//! so that one that fails leaves the running one alone.
//!
//! [`save_scene`] writes the rest pose and not the animated one, replaces the file in one step, and keeps the one
//! before as `NAME.bak`. It edits the file's text: what has not changed keeps its comments, order and layout byte for
//! byte. Entities that come from a glTF model are not written, nor what was changed of them: the file
//! names the model. Nor are values that were changed for this run alone ([`override_values`]).

mod apply;
mod canonical;
mod convert;
mod custom_components;
mod describe;
mod described;
mod document;
mod edit;
mod edit_context;
mod edit_prefab;
mod edit_scene;
mod error;
mod format;
mod instantiate;
mod load;
mod merge;
mod model;
mod opened;
mod overridden;
mod parts;
mod paths;
mod prefabs;
mod preserve;
mod reload;
mod repeat;
mod rewrite;
mod save;
mod save_as;
mod scan;
mod scene_data;
mod source;
mod spawn;
mod steps;
mod suggest;
mod surfaces;
mod temporary_files;
mod track_fields;
mod tracks;
mod tree;
mod trust;
mod validate;
mod write;

#[cfg(test)]
mod tests;

pub use crate::core::{look_rotation, replace_file};
pub use apply::apply_to_prefab;
pub use custom_components::*;
pub use describe::*;
pub use described::DESCRIBED;
pub use document::{Document, ron_options};
pub use edit::*;
pub use edit_context::EditContext;
pub use edit_prefab::*;
pub use edit_scene::edit_scene;
pub use error::{FileError, FileErrorKind, Place};
pub use format::*;
pub use instantiate::*;
pub use overridden::{Overridden, override_values};
pub use reload::{follow_scene, read_scene};
pub use repeat::{MAX_COPIES, Repeat};
pub use save::save_scene;
pub use save_as::{rewrite_paths, save_scene_as};
pub use scene_data::*;
pub use source::{Origin, SceneInfo, Source};
pub use suggest::suggestion;
pub use temporary_files::remove_leftovers;
pub use tree::Step;
pub(crate) use trust::Roots;
pub use trust::project_root;
pub use write::write_atomically;

use crate::assets::{AssetLibrary, LightUnits, LoadBudget};
use crate::world::GameWorld;
use opened::Opened;
use std::path::{Path, PathBuf};

/// How scenes are loaded.
#[derive(Clone, Debug, Default)]
pub struct LoadOptions {
    /// Folder of third-party models (`--models`).
    pub models: Option<PathBuf>,
    /// Folders that files are read from beside that of models and the scene's project, see [`project_root`] (`--trust`).
    pub trusted: Vec<PathBuf>,
    /// Limits of a load (`--budget`).
    pub budget: LoadBudget,
    /// Units of the lights of models whose import settings name none (`--light-units`).
    pub light_units: LightUnits,
    /// Whether a model of which something is broken is refused, in place of a warning (`--strict`).
    pub strict: bool,
    /// Components of a game that scenes may hold.
    pub types: ComponentTypes,
}

/// Loads a scene: a `.scene.ron` file, or a glTF or `.prefab.ron` file as a scene of its own.
///
/// # Errors
/// Whatever is wrong with the file, a prefab or an asset that it names. No world is changed.
pub fn load_scene(path: &Path, library: &mut AssetLibrary, options: &LoadOptions) -> Result<GameWorld, FileError> {
    match Opened::of(path) {
        Opened::Gltf => model::load_gltf_scene(path, library, options),
        Opened::Prefab => opened::load_prefab_scene(path, library, options),
        Opened::Scene => load::load(path, library, options),
    }
}
