//! Settings of stochastic light culling.

use super::former_variants::Variants;
use bevy_ecs::prelude::Component;
use serde::{Deserialize, Deserializer, Serialize};

/// The error bound δ of stochastic light culling: an irradiance. A light is dropped by chance where it would contribute less.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Delta {
    /// Over the mean irradiance of the surfaces that the lights see, ΣΦ/ΣA: the same share of the light, and the same
    /// cost, whatever the scale of the scene and its lights. 1e-12 to 1e6.
    Relative(f32),
    /// [W/m²], above 0; the paper has 0.001.
    Absolute(f32),
}

/// Bounds of the points that may accept a light. Files may also say `EnclosingSphere`, of an earlier version: it is
/// `CentredSphere`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize)]
pub enum LightBounds {
    /// A spheroid around the GGX lobe, a sphere around the diffuse one that touches the light (2017). Fewest lights.
    #[default]
    Ellipsoid,
    /// Spheres centred on the light, whose radius is the largest reach of the lobe (2016).
    CentredSphere,
}

impl<'de> Deserialize<'de> for LightBounds {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let values = &[
            ("Ellipsoid", Self::Ellipsoid),
            ("CentredSphere", Self::CentredSphere),
            ("EnclosingSphere", Self::CentredSphere),
        ];
        Variants { name: "LightBounds", names: &["Ellipsoid", "CentredSphere"], values }.read(deserializer)
    }
}

/// How the lights of a pixel are found. Files may also say `Clustered` or `Splatting`, of an earlier version, which were
/// other ways to the same image: both are `Tiled`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize)]
pub enum LightCulling {
    /// Tiles of 16 × 16 pixels, each with two depth slices (HalfZ).
    #[default]
    Tiled,
    /// All lights at every pixel, without chance: the sum of which tiles give an estimate. Slow.
    None,
}

impl<'de> Deserialize<'de> for LightCulling {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let values =
            &[("Tiled", Self::Tiled), ("None", Self::None), ("Clustered", Self::Tiled), ("Splatting", Self::Tiled)];
        Variants { name: "LightCulling", names: &["Tiled", "None"], values }.read(deserializer)
    }
}

/// Visibility between a virtual light and a surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum LightVisibility {
    /// Nothing: light passes through walls, as in the papers. Fastest, and too bright.
    #[default]
    None,
    /// A shadow ray to every accepted light, through the scene's hierarchy of bounding volumes, and some to the sky.
    ShadowRays,
}

/// What is shown as indirect light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum LightShow {
    /// The light.
    #[default]
    Light,
    /// Number of lights tested at each pixel: black 0, blue 171, green 341, red 512 or more.
    Candidates,
    /// Number of lights tested in vain, in the same colours.
    FalsePositives,
}

/// Stochastic light culling: one bounce of indirect light from the texels of reflective shadow maps as virtual point
/// lights, of which each pixel takes those that matter, and the others by chance.
///
/// Yusuke Tokuyoshi and Takahiro Harada, "Stochastic Light Culling" (2016) and "Stochastic Light Culling for VPLs on
/// GGX Microsurfaces" (2017). Used by `--gi slc`; a scene without it gets the default. All its counts are limited by
/// memory alone: what does not fit is an error that says how much it would take. With shadow rays the sky lights what
/// sees it (its radiance by direction, reflected diffusely). Not covered: emissive surfaces, and light that was reflected more
/// than once on its way.
#[derive(Component, Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct StochasticLightCulling {
    /// Edge of a square map of as many texels as there are virtual lights, 8 to 4096: 256 are 65,536 lights. Lights
    /// share them evenly, and a point light its share over six faces. More lights: less blur of what is near a
    /// reflecting surface; the cost of shading depends on δ alone, that of culling grows.
    pub rsm_size: u32,
    /// Error bound: a third of it is about twice the time. The default is where the error of the box scenes hardly falls
    /// any more, since the blur of interleaving and filter is left.
    pub delta: Delta,
    /// Bounds of a light's range. They change the cost and no pixel.
    pub bounds: LightBounds,
    /// How the lights of a pixel are found.
    pub culling: LightCulling,
    /// Interleaved sampling: of n × n pixels each takes another n²-th part of the lights. 1, 2, 4, 8 or 16.
    /// Software drivers end long loops, which with shadow rays makes 1 and 2 too dark there.
    pub interleave: u32,
    /// Radius of the cross bilateral filter \[pixels\], 0 to 64; 0: none. A multiple of `interleave` leaves no pattern.
    pub filter_radius: u32,
    /// Whether surfaces stop the light of virtual lights.
    pub visibility: LightVisibility,
    /// Seed of the random numbers ξ. Shifted pixel grids (`--aa`) take further ones.
    pub seed: u32,
    /// What is shown as indirect light.
    pub show: LightShow,
}

impl Default for StochasticLightCulling {
    fn default() -> Self {
        Self {
            rsm_size: 256,
            delta: Delta::Relative(3e-4),
            bounds: LightBounds::Ellipsoid,
            culling: LightCulling::Tiled,
            interleave: 8,
            filter_radius: 8,
            visibility: LightVisibility::None,
            seed: 0,
            show: LightShow::Light,
        }
    }
}

impl StochasticLightCulling {
    /// The settings in the ranges that their fields name; the default for numbers that are not finite.
    pub fn sanitized(&self) -> Self {
        let default = Self::default();
        let delta = match self.delta {
            Delta::Relative(x) if x > 0.0 && x.is_finite() => Delta::Relative(x.clamp(1e-12, 1e6)),
            Delta::Absolute(x) if x > 0.0 && x.is_finite() => self.delta,
            _ => default.delta,
        };
        Self {
            rsm_size: self.rsm_size.clamp(8, 4096),
            delta,
            interleave: self.interleave.clamp(1, 16).next_power_of_two(),
            filter_radius: self.filter_radius.min(64),
            ..self.clone()
        }
    }
}
