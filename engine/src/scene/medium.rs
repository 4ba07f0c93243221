//! Participating media, as the renderer sees them.

use super::SceneId;
use glam::{Affine3A, Vec3};

/// Most media of a scene.
pub const MAX_MEDIA: usize = 16;

/// The space that a medium fills, in its own coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MediumShape {
    /// All of it.
    Everywhere,
    /// The cube −1..1.
    Box,
    /// The ball of radius 1.
    Sphere,
}

/// A participating medium in world space, with parameters that the renderer can rely on; see [`Fog`](crate::world::Fog).
#[derive(Clone, Debug, PartialEq)]
pub struct SceneMedium {
    /// Persistent identity; the order of [`Scene::media`](super::Scene::media).
    pub id: SceneId,
    /// The entity's name, for messages.
    pub name: String,
    /// The space that it fills.
    pub shape: MediumShape,
    /// From world to its own coordinates.
    pub local_from_world: Affine3A,
    /// World position of the height 0 \[m\].
    pub base: Vec3,
    /// Unit vector along which heights are measured.
    pub up: Vec3,
    /// Extinction coefficient at and below the height 0 \[1/m\]; above 0.
    pub extinction: f32,
    /// Share of it that is scattered, linear RGB.
    pub albedo: Vec3,
    /// Mean cosine of scattering.
    pub anisotropy: f32,
    /// How fast it thins out with height \[1/m\].
    pub falloff: f32,
}
