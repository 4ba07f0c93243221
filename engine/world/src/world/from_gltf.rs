//! Components of the cameras and lights of models.

use super::{Camera, Light, LightKind, Projection};
use crate::assets::{GltfCamera, GltfLight};
use crate::core::ViewProjection;

impl GltfCamera {
    /// The component.
    pub fn camera(&self) -> Camera {
        let camera = Camera { near: self.near, far: self.far, ..Camera::default() };
        match self.projection {
            ViewProjection::Perspective { vertical_fov } => Camera { fov: vertical_fov.to_degrees(), ..camera },
            ViewProjection::Orthographic { height } => {
                Camera { projection: Projection::Orthographic { height }, ..camera }
            }
        }
    }
}

impl GltfLight {
    /// The component, with default shadow settings.
    pub fn light(&self) -> Light {
        let usual = Light::default();
        // A directional light's map spans the whole scene.
        let shadow_size = if self.kind == LightKind::Directional { 2 * usual.shadow_size } else { usual.shadow_size };
        Light { kind: self.kind, color: self.color, intensity: self.intensity, range: self.range, shadow_size, ..usual }
    }
}
