//! The scene as the renderer sees it: flat arrays in world space, ordered by persistent identity.
//!
//! The scene knows no entities, and it knows no GPU. [`Extractor`] keeps it current from the world by change
//! detection. Every change takes a new value of one counter, so that equal revisions mean equal content.

mod bvh;
mod extract;
mod light;
mod medium;
mod probe;
mod surfels;
mod view;

pub use crate::core::{Aabb, Frustum, SceneId, ViewProjection, orthographic, perspective};
pub use bvh::{Movers, RayKind, SceneBvh, SceneHit, ScenePart, SceneTriangle, Updated};
#[doc(hidden)]
pub use bvh::{corner_indices, is_mirrored, is_nearer, normal_matrix, turned_normal, vertex_indices, world_normal};
pub use extract::Extractor;
pub use light::{LightShape, MAX_RSM_SIZE, SceneLight};
pub use medium::{MAX_MEDIA, MediumShape, SceneMedium};
pub use probe::ProbePoint;
pub use surfels::{MAX_SURFELS, NO_PATCH, Patches, Surfel, SurfelCloud, cells_from_world};
#[doc(hidden)]
pub use surfels::{texel, wall_extent};
pub use view::{SceneCamera, SceneView};

use crate::assets::{Material, Mesh, SkyMap};
use crate::world::{Clpv, InstantRadiosity, MethodSettings, StochasticLightCulling};
use glam::{Affine3A, DVec3, Vec3};
use std::sync::Arc;

/// One mesh with one material at one place.
#[derive(Clone, Debug)]
pub struct Primitive {
    /// Persistent identity; the order of [`Scene::primitives`]. Drawn into the id target as its low 32 bits.
    pub id: SceneId,
    /// Geometry.
    pub mesh: Arc<Mesh>,
    /// Surface.
    pub material: Arc<Material>,
    /// World from object space; may mirror, may be singular.
    pub world_from_object: Affine3A,
    /// World bounds.
    pub bounds: Aabb,
    /// Whether it casts shadows (and takes part in RSMs and blockers).
    pub casts_shadow: bool,
    /// Whether it is animated or has changed lately. What such primitives cover in a view that rests is drawn over a
    /// kept image of all others.
    pub moving: bool,
    /// Counter value of the last change of place, mesh or visibility.
    pub geometry_revision: u64,
    /// Counter value of the last change of the material.
    pub material_revision: u64,
}

impl Primitive {
    /// Whether it is an obstacle for light: it casts shadows, and is not of glass, which takes only a part.
    pub fn blocks_light(&self) -> bool {
        self.casts_shadow && !self.material.is_glass()
    }

    /// Whether it stands for light-emitting particles, which cameras see as soft discs and lights not at all.
    pub fn is_particles(&self) -> bool {
        self.mesh.balls.is_some()
    }
}

/// Counter values of the last change of each kind, anywhere in the scene.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Revisions {
    /// Any primitive's place, mesh or existence.
    pub geometry: u64,
    /// Any primitive's material.
    pub materials: u64,
    /// Any light.
    pub lights: u64,
    /// Any medium.
    pub media: u64,
    /// Any camera.
    pub cameras: u64,
    /// The CLPV settings.
    pub clpv: u64,
    /// The settings of a game's methods.
    pub methods: u64,
    /// Scene settings (sky).
    pub settings: u64,
    /// Which primitives there are, which of them are moving, and anything of those that are not. 0 in scenes put
    /// together by hand, which do not tell.
    pub statics: u64,
}

/// The CLPV component and where its entity stands.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneClpv {
    /// Its settings.
    pub settings: Clpv,
    /// World position of its entity \[m\]: the centre of a fixed volume.
    pub center: Vec3,
}

/// Everything that the renderer sees. Arrays are sorted by [`SceneId`].
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// Distinguishes scenes in cache keys; each extractor takes a fresh one.
    pub identity: u64,
    /// World position of the origin of all places in the scene \[m\]: zero, unless the primary camera stands so far
    /// from the world's that single precision would show.
    pub origin: DVec3,
    /// Primitives that are visible.
    pub primitives: Vec<Primitive>,
    /// Lights.
    pub lights: Vec<SceneLight>,
    /// Participating media, at most [`MAX_MEDIA`].
    pub media: Vec<SceneMedium>,
    /// Cameras.
    pub cameras: Vec<SceneCamera>,
    /// Light propagation volumes, if the world asks for them. The first by SceneId wins.
    pub clpv: Option<SceneClpv>,
    /// Settings of instant radiosity, if the world holds them. The first by SceneId wins.
    pub vpl: Option<InstantRadiosity>,
    /// Settings of stochastic light culling, if the world has any; without them the default is used. The first by
    /// SceneId wins. They have no revision: passes take them into their keys as they are.
    pub slc: Option<StochasticLightCulling>,
    /// Settings of a game's methods, by their type. The first of each type by SceneId wins.
    pub method_settings: MethodSettings,
    /// Radiance of the sky behind everything [W/(m² sr)], linear RGB; the mean over all directions where there is
    /// a map.
    pub sky: Vec3,
    /// Radiance of the sky by direction, if it is not the same everywhere.
    pub sky_map: Option<Arc<SkyMap>>,
    /// The sun as it is seen in a physical sky, if it has a disc. It is no part of the map: it is a light.
    pub sun_disc: Option<SunDisc>,
    /// Whether the sky lights the scene where the method of indirect light has no light of it.
    pub sky_light: bool,
    /// Warnings of requests that make no sense, with the entity's name and the consequence.
    pub warnings: Vec<String>,
    /// Names of the entities that hold the settings of methods, for messages.
    pub settings_names: SettingsNames,
    /// Revisions.
    pub revisions: Revisions,
}

/// The sun in the sky.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SunDisc {
    /// Unit direction towards it.
    pub toward: Vec3,
    /// Half the angle under which it is seen \[rad\].
    pub half_angle: f32,
    /// Radiance [W/(m² sr)].
    pub radiance: Vec3,
}

/// Names of the entities that hold the settings of methods; empty without such an entity.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SettingsNames {
    /// Name of the entity with the light propagation volumes.
    pub clpv: String,
    /// Name of the entity with instant radiosity.
    pub vpl: String,
    /// Name of the entity with stochastic light culling.
    pub slc: String,
}

impl Scene {
    /// World bounds of all primitives but particles, which volumes of light and cameras are not to follow.
    pub fn bounds(&self) -> Aabb {
        let fixed = self.primitives.iter().filter(|primitive| !primitive.is_particles());
        fixed.fold(Aabb::EMPTY, |bounds, primitive| bounds.union(&primitive.bounds))
    }
}
