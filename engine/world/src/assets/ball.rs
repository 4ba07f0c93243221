//! Balls of light, which the triangles of a mesh may stand for.

use bytemuck::{Pod, Zeroable};

/// A ball, as `Ball` of `transparency/particles.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Ball {
    /// Middle in object space \[m\].
    pub position: [f32; 3],
    /// Radius \[m\]; 0: there is none.
    pub radius: f32,
    /// Emitted radiance [W/(m² sr)].
    pub radiance: [f32; 3],
    /// Share of its life that is over, 0..1.
    pub age: f32,
}

impl Ball {
    /// No ball.
    pub const NONE: Self = Self { position: [0.0; 3], radius: 0.0, radiance: [0.0; 3], age: 0.0 };
}
