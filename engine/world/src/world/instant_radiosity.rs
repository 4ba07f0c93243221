//! Settings of instant radiosity, `--gi vpl`.

use super::Bounces;
use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

/// How many particles go on after each reflection. ρ is the scene's mean reflectance, N the number of particles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Schedule {
    /// Keller 1997: the first ⌊ρN⌋ are shot, and the first ⌊ρʲN⌋ make the j-th hit. All N start points on surfaces
    /// that emit stay as lights.
    Keller,
    /// The report's: all N are shot, and the first ⌊ρʲ⁻¹N⌋ make the j-th hit. N = 10 and ρ = ½ leave 18 lights.
    #[default]
    Report,
}

/// Where a particle goes after a reflection.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum ParticleBounce {
    /// Around the normal with density cosθ/π, as light does that a diffuse surface reflects (Keller).
    #[default]
    Diffuse,
    /// As from a mirror (the report): every hit still becomes a light that shines diffusely.
    Mirror,
}

/// How a virtual light lights a surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum VirtualShading {
    /// f·Φ/π·cos·cos/max(d², d_min²)·V with the material's whole reflection f.
    #[default]
    Physical,
    /// As the report prints it: (1/N)·(ρ/π)·L·max(n·l, 0), where L loses ρ/π a bounce; without distance and without
    /// visibility, and the main lights divided by N in the same way. To compare, not to believe.
    AsPublished,
}

/// How the lights are summed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Accumulation {
    /// All lights in one pass over the G-buffer.
    #[default]
    Batched,
    /// The report's: for each light the scene is drawn once more, blended additively where the depth is equal. With
    /// a cube shadow map and the main pass these are (7 + M)·B draws for M lights and B objects.
    ByTheLetter,
}

/// Whether virtual lights are shadowed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum VirtualVisibility {
    /// They shine through everything (the report).
    None,
    /// A ray for each pixel and light through the hierarchy of the scene (Keller's full method).
    #[default]
    ShadowRays,
}

/// Where the lights come from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum VirtualPlacement {
    /// From particles that are shot from the lights and reflected.
    #[default]
    Particles,
    /// From texels of the lights' reflective shadow maps: one bounce, further ones are ignored, and so are surfaces
    /// that emit and the sky.
    Rsm,
}

/// Numbers that decide where particles go.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum ParticleSequence {
    /// The Sobol' (0, 2)-sequence, scrambled (Owen 1995): even coverage at every number of particles.
    #[default]
    LowDiscrepancy,
    /// Independent numbers.
    Random,
}

/// How particles find what they hit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum ParticleCasts {
    /// Through the hierarchy over all triangles.
    #[default]
    Hierarchy,
    /// Every object in its own space, as in the report: squares and boxes by formula, all others triangle by
    /// triangle. O(B·N/(1−ρ)); to compare.
    BruteForce,
    /// The same with the oriented box around every object in place of its triangles (the report's "Improving the
    /// particle simulation"): position and normal are those of the box. Rays that start within an object's box
    /// test its triangles, since such a box tells nothing about what is in their way.
    Bounds,
}

/// What bias and random offsets of the main lights' shadow maps are measured in, where they are shaded as published.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum ShadowLookup {
    /// Texels of the map: the same settings fit scenes and maps of all sizes. Offsets lie in the plane of the map.
    #[default]
    Texels,
    /// Metres, as the report has it: ‖l‖ − bias is compared with the distance that the map holds along −l + off·oᵢ.
    AsPublished,
}

/// Instant radiosity: indirect light from many virtual point lights (Keller 1997, "Instant Radiosity"). What is called
/// the report is Emanuele Franchi and Lorenzo Ferrante, "Virtual Point Lights".
#[derive(Component, Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct InstantRadiosity {
    /// Particles N of all lights together, dealt out by flux and at least one each. With reflectance ρ they leave up
    /// to N/(1−ρ) lights. Time and noise: cost grows with the number of lights times the pixels, the error falls with
    /// its square root or faster. Limited by memory alone, 80 bytes a light.
    pub particles: u32,
    /// So many times as many particles are shot, 1 to 64, and of the lights that they leave those are kept which contribute most
    /// to what the camera sees. To shoot is cheap, to shade is not: for images of a part of a scene. While lights or
    /// camera move, lights come and go. 1: all are kept, whatever the camera sees.
    pub candidates: u32,
    /// How many particles go on.
    pub schedule: Schedule,
    /// Where they go after a reflection.
    pub bounce: ParticleBounce,
    /// How often light is reflected on its way; one: camera, surface, surface, light.
    pub bounces: Bounces,
    /// How a virtual light lights a surface.
    pub shading: VirtualShading,
    /// How lights are summed.
    pub accumulation: Accumulation,
    /// Whether they are shadowed. Rays cost by far the most.
    pub visibility: VirtualVisibility,
    /// Where they come from.
    pub placement: VirtualPlacement,
    /// Lights whose front nothing that is drawn lies before are left out. It changes no pixel.
    pub view_driven: bool,
    /// Near-light rule: d_min in units of the distance between neighbouring lights, and for those of a later hit no less
    /// than for those before. It bounds the bright spots around them; what it takes away is for `near_rays` to find.
    /// 0: no bound.
    pub near_bound: f32,
    /// Rays of a pixel that find what the bound takes away, 0 to 16; 0: none. Particles alone, with shadow rays.
    pub near_rays: u32,
    /// Radius of the filter over what they find \[pixels\], 0 to 32; 0: none.
    pub near_filter: u32,
    /// The numbers.
    pub sequence: ParticleSequence,
    /// Seed of the numbers.
    pub seed: u32,
    /// How hits are found.
    pub casts: ParticleCasts,
    /// Main lights as published: the unit of `shadow_bias`, `shadow_slope_bias` and `shadow_offset`.
    pub shadow_lookup: ShadowLookup,
    /// Main lights as published: static bias b_s of the shadow map, in texels or metres.
    pub shadow_bias: f32,
    /// Main lights as published: b_dmax, the bias added at grazing light, b_dmax·(1 − n·l), in texels or metres.
    pub shadow_slope_bias: f32,
    /// Main lights as published: S, shadow-map lookups a pixel at random offsets; 1: none.
    pub shadow_samples: u32,
    /// Main lights as published: off, the largest random offset along each axis, in texels or metres.
    pub shadow_offset: f32,
}

impl Default for InstantRadiosity {
    fn default() -> Self {
        Self {
            particles: 512,
            candidates: 1,
            schedule: Schedule::default(),
            bounce: ParticleBounce::default(),
            bounces: Bounces::Converged,
            shading: VirtualShading::default(),
            accumulation: Accumulation::default(),
            visibility: VirtualVisibility::default(),
            placement: VirtualPlacement::default(),
            view_driven: true,
            near_bound: 1.0,
            near_rays: 4,
            near_filter: 8,
            sequence: ParticleSequence::default(),
            seed: 0,
            casts: ParticleCasts::default(),
            shadow_lookup: ShadowLookup::default(),
            shadow_bias: 1.0,
            shadow_slope_bias: 16.0,
            shadow_samples: 4,
            shadow_offset: 1.5,
        }
    }
}
