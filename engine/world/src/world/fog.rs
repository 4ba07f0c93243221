//! Haze, fog and smoke: air that absorbs and scatters light.

use bevy_ecs::prelude::*;
use glam::Vec3;
use serde::{Deserialize, Serialize};
use std::ops::RangeInclusive;

/// The space that a [`Fog`] fills.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum FogShape {
    /// All of it, whatever the entity's place and size. The sky is seen through it only where [`Fog::falloff`] thins it out
    /// upwards.
    #[default]
    Everywhere,
    /// A box around the entity's origin, turned, moved and scaled with it.
    Box {
        /// Edges \[m\], 1e-6..1e6.
        size: Vec3,
    },
    /// A ball around the entity's origin; the entity's scale makes it an ellipsoid.
    Sphere {
        /// Radius \[m\], 1e-6..1e6.
        radius: f32,
    },
}

/// A participating medium: a volume of air with particles that absorb and scatter light (Chandrasekhar 1960; Pharr, Jakob and
/// Humphreys 2023, chapter 11). Light over a distance d falls by exp(−extinction·d). Where several overlap, their particles
/// add up.
#[derive(Component, Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Fog {
    /// The space that it fills.
    pub shape: FogShape,
    /// Extinction coefficient σₜ \[1/m\], 0..1e6: the share of light that a thin layer absorbs or scatters, over its thickness. In a fog
    /// of 0.1 one sees 10 m far, up to a contrast of 1/e.
    pub extinction: f32,
    /// Share of that light which is scattered and not absorbed, linear RGB, 0..1: near 1 for mist, less for smoke.
    pub albedo: Vec3,
    /// Mean cosine g of the angle by which light is scattered (Henyey and Greenstein 1941), −0.95..0.95: above 0 onward, as mist
    /// does with about 0.8; 0: to all sides alike.
    pub anisotropy: f32,
    /// How fast it thins out with the height above the entity's origin, along the entity's Y axis \[1/m\], 0..1e6: the extinction there
    /// is that at the origin times exp(−falloff·height). Below the origin it is even. 0: it is even everywhere.
    pub falloff: f32,
}

impl Fog {
    /// Extinctions that a fog may have \[1/m\].
    pub const EXTINCTIONS: RangeInclusive<f32> = 0.0..=1e6;
    /// Anisotropies that a fog may have.
    pub const ANISOTROPIES: RangeInclusive<f32> = -0.95..=0.95;
    /// Falloffs that a fog may have \[1/m\].
    pub const FALLOFFS: RangeInclusive<f32> = 0.0..=1e6;
    /// Sizes that a fog may have \[m\].
    pub const SIZES: RangeInclusive<f32> = 1e-6..=1e6;
}

impl Default for Fog {
    fn default() -> Self {
        Self { shape: FogShape::Everywhere, extinction: 0.02, albedo: Vec3::splat(0.95), anisotropy: 0.0, falloff: 0.0 }
    }
}
