//! What can be wrong with virtual lights.

use crate::render::RayError;
use crate::render::error::RenderError;

/// Why there can be no virtual lights.
#[derive(Debug, thiserror::Error)]
pub enum VplError {
    /// The scene does not fit the device.
    #[error(transparent)]
    Scene(#[from] RayError),
    /// The report's formula knows no maps.
    #[error(
        "lights from reflective shadow maps have no published shading: set `vpl.shading` to Physical or `vpl.placement` to Particles"
    )]
    PublishedRsm,
    /// More lights than fit a buffer. Nothing but memory limits their number.
    #[error(
        "{particles} particles leave up to {lights} lights, which take {needed} MiB, and the largest buffer of this \
         adapter holds {limit} MiB: set `vpl.particles` to {possible} or less{}",
        if *.candidates > 1 { format!(", or `vpl.candidates` below {candidates}") } else { String::new() }
    )]
    TooMany {
        /// Particles asked for.
        particles: u32,
        /// Lights for each that is kept.
        candidates: u32,
        /// Lights that they can leave, those counted that are not kept.
        lights: u64,
        /// Needed \[MiB\].
        needed: u64,
        /// Possible \[MiB\].
        limit: u64,
        /// Particles whose lights fit.
        possible: u64,
    },
}

impl From<VplError> for RenderError {
    fn from(error: VplError) -> Self {
        Self::Method { what: "virtual lights cannot be made".into(), source: Some(Box::new(error)) }
    }
}
