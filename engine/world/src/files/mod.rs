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

mod edit;
mod error;
mod format;
mod load;
mod ron;
mod save;
#[cfg(test)]
mod tests;

pub use self::ron::document::{Document, ron_options};
pub use self::ron::suggest::suggestion;
pub use self::ron::tree::Step;
pub use crate::core::{look_rotation, replace_file};
pub use edit::apply::apply_to_prefab;
pub use edit::context::EditContext;
pub use edit::entity::*;
pub use edit::prefab::*;
pub use edit::reload::{follow_scene, read_scene};
pub use edit::scene::edit_scene;
pub use edit::spawn::spawn_prefab_onto;
pub use error::{FileError, FileErrorKind, Place};
pub use format::custom_components::*;
pub use format::described::DESCRIBED;
pub use format::repeat::{MAX_COPIES, Repeat};
pub use format::scene_data::*;
pub use format::scene_file::*;
pub use load::instantiate::*;
pub use load::options::LoadOptions;
pub use load::source::{Origin, SceneInfo, Source};
pub(crate) use load::trust::Roots;
pub use load::trust::project_root;
pub use save::describe::*;
pub use save::disk::{remove_leftovers, write_atomically};
pub use save::overridden::Overridden;
pub use save::override_values::override_values;
pub use save::save_as::{rewrite_paths, save_scene_as};
pub use save::scene::save_scene;
