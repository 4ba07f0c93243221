//! Settings of stochastic light culling.

use bevy_ecs::prelude::Component;
use serde::{Deserialize, Serialize};

/// The error bound δ of stochastic light culling: an irradiance. A light is dropped by chance where it would contribute less.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Delta {
    /// Over the mean irradiance of the surfaces that the lights see, ΣΦ/ΣA: the same share of the light, and the same
    /// cost, whatever the scale of the scene and its lights. 1e-12 to 1e6.
    Relative(f32),
    /// [W/m²], above 0; the paper has 0.001.
    Absolute(f32),
}

/// Bounds of the points that may accept a light. All give the same image; they differ in the lights that are tested in
/// vain.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum LightBounds {
    /// A spheroid around the GGX lobe, a sphere around the diffuse one that touches the light (2017). Fewest lights.
    #[default]
    Ellipsoid,
    /// Spheres centred on the light, whose radius is the largest reach of the lobe (2016).
    CentredSphere,
    /// As [`LightBounds::Ellipsoid`], with the sphere around the spheroid: the paper's second rival (2017, figure 9).
    EnclosingSphere,
}

/// How the lights of a pixel are found. All ways but `None` take the same lights.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum LightCulling {
    /// Tiles of 16 × 16 pixels, each with two depth slices (HalfZ).
    #[default]
    Tiled,
    /// Tiles with 32 depth slices, as clustered shading has them; the masks of lights take 16 times the memory. To
    /// compare.
    Clustered,
    /// Each light is drawn over the pixels that its range covers, as 80 triangles (Dachsbacher and Stamminger 2006). Needs
    /// an adapter that blends 32-bit floats, and casts no shadow rays. Adds in the blending unit, so that the last bits may
    /// differ from those of tiles. To compare.
    Splatting,
    /// All lights at every pixel, without chance: the sum of which the others give an estimate. Slow.
    None,
}

/// The lobes of the virtual lights that shine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum LightLobes {
    /// Both.
    #[default]
    Both,
    /// The diffuse ones alone: "diffuse VPLs only" of the paper's table 2.
    Diffuse,
    /// The GGX ones alone: "glossy VPLs only".
    Specular,
}

/// The random numbers ξ of the lights.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum LightChances {
    /// Evenly spread over the lights of a subset, by the golden ratio: less noise.
    #[default]
    Even,
    /// One for each light, independent of all others, as in the papers.
    Independent,
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
    /// The lobes of the lights that shine; to measure one of them alone.
    pub lobes: LightLobes,
    /// Interleaved sampling: of n × n pixels each takes another n²-th part of the lights. 1, 2, 4, 8 or 16.
    /// Software drivers end long loops, which with shadow rays makes 1 and 2 too dark there.
    pub interleave: u32,
    /// Radius of the cross bilateral filter \[pixels\], 0 to 64; 0: none. A multiple of `interleave` leaves no pattern.
    pub filter_radius: u32,
    /// Whether surfaces stop the light of virtual lights.
    pub visibility: LightVisibility,
    /// How the random numbers ξ are spread over the lights.
    pub chances: LightChances,
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
            lobes: LightLobes::Both,
            interleave: 8,
            filter_radius: 8,
            visibility: LightVisibility::None,
            chances: LightChances::Even,
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
