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

impl SceneMedium {
    /// Share of light from infinitely far in a unit direction that arrives at a point. All of it, where the medium does not
    /// reach so far.
    pub fn passes_from_afar(&self, point: Vec3, toward: Vec3) -> f32 {
        if self.shape != MediumShape::Everywhere {
            return 1.0;
        }
        let (rise, height) = (self.up.dot(toward), self.up.dot(point - self.base));
        if self.falloff <= 0.0 || rise <= 0.0 {
            return 0.0;
        }
        // Even up to the height 0, and from there the integral of the exponential.
        let above = (-self.falloff * height.max(0.0)).exp() / self.falloff;
        (-self.extinction * ((-height).max(0.0) + above) / rise).exp()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sky_is_seen_through_what_thins_out_upwards() {
        let mut medium = SceneMedium {
            id: SceneId(1),
            name: String::new(),
            shape: MediumShape::Everywhere,
            local_from_world: Affine3A::IDENTITY,
            base: Vec3::ZERO,
            up: Vec3::Y,
            extinction: 0.5,
            albedo: Vec3::ONE,
            anisotropy: 0.0,
            falloff: 0.25,
        };
        // 1 m below the height 0, and 1/0.25 m above it.
        let found = medium.passes_from_afar(Vec3::NEG_Y, Vec3::Y);
        assert!((found - (-0.5_f32 * 5.0).exp()).abs() < 1e-6, "{found}");
        assert_eq!(medium.passes_from_afar(Vec3::Y, Vec3::NEG_Y), 0.0);
        medium.falloff = 0.0;
        assert_eq!(medium.passes_from_afar(Vec3::Y, Vec3::Y), 0.0);
        medium.shape = MediumShape::Box;
        assert_eq!(medium.passes_from_afar(Vec3::Y, Vec3::Y), 1.0);
    }
}
