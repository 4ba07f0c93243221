//! The rest pose of an entity: its values without animation.

use super::components::{LightKind, Projection, Transform};
use super::fields::HeldFields;
use crate::assets::Material;
use bevy_ecs::prelude::*;
use glam::{Quat, Vec3};
use std::sync::Arc;

/// The entity's own values of what its [`Animation`](super::Animation) has taken over. It comes with the animation,
/// and when a value is no longer animated it goes back to its component.
///
/// Read and edit through [`GameWorld::rest_transform`](super::GameWorld::rest_transform) and its like.
#[derive(Component, Clone, Debug, Default)]
pub struct RestPose {
    pub(super) translation: Option<Vec3>,
    pub(super) rotation: Option<Quat>,
    pub(super) scale: Option<Vec3>,
    pub(super) intensity: Option<f32>,
    pub(super) color: Option<Vec3>,
    pub(super) range: Option<Option<f32>>,
    pub(super) kind: Option<LightKind>,
    pub(super) fov: Option<f32>,
    pub(super) projection: Option<Projection>,
    pub(super) visible: Option<bool>,
    pub(super) casts_shadow: Option<bool>,
    pub(super) weights: Option<Vec<f32>>,
    pub(super) material: Option<Arc<Material>>,
    /// The material that the animation made last; another one in its place was put there by someone else.
    pub(super) animated_material: Option<Arc<Material>>,
    /// Whether the animation cannot be played.
    pub(super) faulty: bool,
    /// Fields that tracks change by their paths.
    pub(super) fields: HeldFields,
}

impl RestPose {
    pub(super) fn transform(&self, current: &Transform) -> Transform {
        Transform {
            translation: self.translation.unwrap_or(current.translation),
            rotation: self.rotation.unwrap_or(current.rotation),
            scale: self.scale.unwrap_or(current.scale),
        }
    }
}
