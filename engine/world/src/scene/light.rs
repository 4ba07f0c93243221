//! Lights as the renderer sees them.

use super::SceneId;
use glam::{Vec2, Vec3};

/// Largest edge of a reflective shadow map \[texels\]: four targets of a point light's six faces take 2.3 GiB then.
pub const MAX_RSM_SIZE: u32 = 4096;

/// Shape of a light's emission.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightShape {
    /// Parallel light; `SceneLight::intensity` is irradiance E on a perpendicular plane [W/m²].
    Directional,
    /// All directions alike; intensity is radiant intensity I [W/sr].
    Point,
    /// A cone; intensity is radiant intensity on the axis [W/sr]. Half angles \[rad\], 0 ≤ inner < outer ≤ π/2.
    Spot {
        /// Half angle of full intensity.
        inner: f32,
        /// Half angle beyond which there is no light.
        outer: f32,
    },
    /// Parallel light but for the width of a disc in the sky; intensity is irradiance E on a perpendicular plane [W/m²].
    Sun {
        /// Half the angle under which it is seen \[rad\], 0..π/4.
        half_angle: f32,
    },
    /// A sphere of even radiance; intensity is radiant intensity I [W/sr].
    Sphere {
        /// Radius \[m\].
        radius: f32,
    },
    /// A disc of even radiance on its front; intensity is radiant intensity on the axis [W/sr].
    Disc {
        /// Radius \[m\].
        radius: f32,
    },
    /// A rectangle of even radiance on its front; intensity is radiant intensity on the axis [W/sr].
    Rectangle {
        /// Half edges along `SceneLight::axis` and across it \[m\].
        half_size: Vec2,
    },
    /// A tube along `SceneLight::axis`, dark at its ends; intensity is radiant intensity across the axis [W/sr].
    Tube {
        /// Half the length \[m\].
        half_length: f32,
        /// Radius \[m\].
        radius: f32,
    },
}

impl LightShape {
    /// Whether it has a surface.
    pub fn is_area(&self) -> bool {
        !matches!(self, Self::Directional | Self::Point | Self::Spot { .. })
    }

    /// Whether all its light comes from one direction, or nearly so.
    pub fn is_distant(&self) -> bool {
        matches!(self, Self::Directional | Self::Sun { .. })
    }
}

/// A light in world space.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneLight {
    /// Persistent identity; the order of [`super::Scene::lights`].
    pub id: SceneId,
    /// Name for reports.
    pub name: String,
    /// Shape.
    pub shape: LightShape,
    /// Linear RGB; unit by shape, see [`LightShape`].
    pub intensity: Vec3,
    /// World position \[m\]; unused by directional lights.
    pub position: Vec3,
    /// Unit direction that the light travels along its axis; unused by point lights and spheres.
    pub direction: Vec3,
    /// Unit direction of a rectangle's width and of a tube, at right angles to `direction`; unused by the others.
    pub axis: Vec3,
    /// Distance beyond which there is no light \[m\], windowed as in `KHR_lights_punctual`.
    pub range: Option<f32>,
    /// Whether it casts shadows.
    pub casts_shadow: bool,
    /// Whether it feeds indirect light.
    pub indirect: bool,
    /// Edge of its shadow map \[texels\].
    pub shadow_size: u32,
    /// Edge of its reflective shadow map \[texels\].
    pub rsm_size: u32,
    /// Value of the scene's revision counter when this light last changed.
    pub revision: u64,
}

impl SceneLight {
    /// Whether it stands somewhere, unlike a directional light or the sun.
    pub fn has_position(&self) -> bool {
        !self.shape.is_distant()
    }

    /// Name and identity: unique in the scene, for the names of passes and resources.
    pub fn pass_name(&self) -> String {
        format!("{}#{}", self.name, self.id.0)
    }
}
