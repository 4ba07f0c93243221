//! The format of scene and prefab files, as `serde` reads and writes it.
//!
//! Everything has a default that can have one, so that hand-written files say only what matters.

pub use super::custom_components::CustomComponents;
pub use super::parts::*;
pub use super::repeat::Repeat;
pub use crate::assets::Shape;
use crate::core::GiMethod;
pub use crate::files::ron::document::VERSION;
use crate::world::{
    Animation, Camera, Clpv, Fog, InstantRadiosity, Light, Particles, SceneSettings, StochasticLightCulling,
};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A scene file: `Scene(entities: […])`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default, rename = "Scene")]
pub struct SceneFile {
    /// Version of the format, 1 if not said. A file of a later version than [`VERSION`] is refused.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub version: Option<u32>,
    /// Description of the scene, for people.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub description: String,
    /// Method of indirect light, unless the command line says otherwise: one of the engine or of the game.
    pub gi: GiMethod,
    /// Sky, exposure, clock.
    pub settings: SceneSettings,
    /// Sets of changes by name, each written as for `--set`: `--set preset=NAME` makes them.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub presets: BTreeMap<String, Vec<String>>,
    /// Materials that entities refer to by name.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub materials: BTreeMap<String, MaterialFile>,
    /// The entities without a parent.
    pub entities: Vec<EntityFile>,
}

/// A prefab file: `Prefab(entities: […])`. Its entities become children of the entity that instances it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default, rename = "Prefab")]
pub struct PrefabFile {
    /// Version of the format, 1 if not said. A file of a later version than [`VERSION`] is refused.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub version: Option<u32>,
    /// Description, for people.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub description: String,
    /// Materials that entities of this file refer to by name.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub materials: BTreeMap<String, MaterialFile>,
    /// The entities.
    pub entities: Vec<EntityFile>,
}

/// An entity with its components and children.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename = "Entity")]
pub struct EntityFile {
    /// Name, unique among its siblings; no `/`.
    pub name: String,
    /// Place relative to the parent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub transform: Option<TransformFile>,
    /// A primitive shape.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mesh: Option<Shape>,
    /// A glTF model, whole or one node with what hangs on it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub model: Option<ModelFile>,
    /// Surface of the shape, or of the whole model in place of the model's own materials.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub material: Option<MaterialRef>,
    /// Whether the shape or model casts shadows; yes if not said.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub casts_shadow: Option<bool>,
    /// Whether the shape or model is drawn; yes if not said.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub visible: Option<bool>,
    /// A light.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub light: Option<Light>,
    /// A camera.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub camera: Option<Camera>,
    /// Light propagation volumes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub clpv: Option<Clpv>,
    /// Instant radiosity.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub vpl: Option<InstantRadiosity>,
    /// Settings of stochastic light culling.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub slc: Option<StochasticLightCulling>,
    /// Haze, fog or smoke.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fog: Option<Fog>,
    /// Light-emitting particles.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub particles: Option<Particles>,
    /// Animation of the transform.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub animation: Option<Animation>,
    /// Components of the game, by their names.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub components: CustomComponents,
    /// A prefab whose entities become children; its path is relative to this file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub prefab: Option<String>,
    /// Copies of the prefab in place of one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub repeat: Option<Repeat>,
    /// Changes to the prefab's entities by their path below this one, such as `"Pole/Bulb"`.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub overrides: BTreeMap<String, OverrideFile>,
    /// Children.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub children: Vec<EntityFile>,
}

/// What an instance changes of one entity of its prefab. Each component given here replaces the prefab's whole.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default, rename = "Override")]
pub struct OverrideFile {
    /// Leaves the entity out, with everything below it.
    #[serde(skip_serializing_if = "is_false")]
    pub remove: bool,
    /// Place relative to the parent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub transform: Option<TransformFile>,
    /// Shape.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mesh: Option<Shape>,
    /// Model.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub model: Option<ModelFile>,
    /// Surface; names are those of the file that holds the override.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub material: Option<MaterialRef>,
    /// Whether it casts shadows.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub casts_shadow: Option<bool>,
    /// Whether it is drawn.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub visible: Option<bool>,
    /// Light.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub light: Option<Light>,
    /// Camera.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub camera: Option<Camera>,
    /// Light propagation volumes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub clpv: Option<Clpv>,
    /// Instant radiosity.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub vpl: Option<InstantRadiosity>,
    /// Settings of stochastic light culling.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub slc: Option<StochasticLightCulling>,
    /// Haze, fog or smoke.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fog: Option<Fog>,
    /// Light-emitting particles.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub particles: Option<Particles>,
    /// Animation.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub animation: Option<Animation>,
    /// Components of the game, by their names; each one given replaces the prefab's.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub components: CustomComponents,
    /// Components that the prefab gives and the instance does not want.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub without: Vec<ComponentKind>,
    /// Children besides those of the prefab.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub children: Vec<EntityFile>,
}

/// A component that an override can take away.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum ComponentKind {
    /// The shape with its material.
    Mesh,
    /// The light.
    Light,
    /// The camera.
    Camera,
    /// The light propagation volumes.
    Clpv,
    /// Instant radiosity.
    Vpl,
    /// The settings of stochastic light culling.
    Slc,
    /// The haze, fog or smoke.
    Fog,
    /// The light-emitting particles.
    Particles,
    /// The animation.
    Animation,
    /// A component of the game, by its name.
    Own(String),
}
