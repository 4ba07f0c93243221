//! Instant radiosity: virtual point lights where particles from the lights hit (Keller 1997, "Instant radiosity").
//!
//! ```text
//! particles (shot on the CPU, kept while lights and surfaces stay) ─ reach (per view) ─ shade ─ compose
//! rsm ─ place ────────────────────────────────────────────────────────────────────────────┘
//! ```
//! The image is f·Φ/π·cosθ·cosθ_i/max(d², d_min²)·V summed over all lights. d_min is the distance between neighbouring
//! lights, which bounds the bright spots around them: within about that distance a surface is lit by few lights, and
//! their 1/d² would be all that is seen.

mod casts;
mod error;
mod particles;
mod random;
mod schedule;
mod shade;
mod simulate;
mod source;
mod surface;

pub use casts::{CastCounts, CastHit, Caster, intersect_square, intersect_unit_box};
pub use error::VplError;
pub use particles::VirtualLights;
#[cfg(test)]
pub(crate) use shade::ShadeUniform;
pub use simulate::{MAX_PATHS, Particles, VirtualLight};

use super::frame::Frame;
use super::gbuffer::GBuffer;
use crate::graph::{Graph, Handle, Texture};

/// Declares everything from the lights to the reflected radiance. None where nothing can leave a light, with the
/// reason in the report.
pub(super) fn declare<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    gbuffer: &GBuffer,
) -> Result<Option<Handle<Texture>>, VplError> {
    let Some(state) = frame.virtual_lights else { return Ok(None) };
    let Some(lights) = particles::declare(graph, frame, state)? else { return Ok(None) };
    Ok(Some(shade::declare(graph, frame, gbuffer, state, lights)))
}
