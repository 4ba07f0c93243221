//! Instant radiosity: virtual point lights where particles from the lights hit (Keller 1997, "Instant radiosity").
//!
//! ```text
//! particles (shot on the CPU, kept while lights and surfaces stay) ─ choice ─ reach (per view) ─ shade ─ near ─ compose
//! rsm ─ place ─────────────────────────────────────────────────────────────────────────────────────┘
//! ```
//! The image is f·Φ/π·cosθ·cosθ_i/max(d², d_min²)·V summed over all lights. d_min is the distance between neighbouring
//! lights, which bounds the bright spots around them: within about that distance a surface is lit by few lights, and
//! their 1/d² would be all that is seen. What that leaves out is found by short rays (`near`).

mod beam;
mod casts;
mod choice;
mod error;
mod letter;
mod main_light;
mod near;
mod particles;
mod paths;
mod place;
mod random;
mod schedule;
mod shade;
mod simulate;
mod source;
mod surface;
mod view_points;

pub use casts::{CastCounts, CastHit, Caster, intersect_square, intersect_unit_box};
pub use error::VplError;
pub(super) use main_light::declare as declare_main_lights;
pub use particles::VirtualLights;
pub(super) use paths::declare as declare_paths;
pub use simulate::{MAX_PATHS, Particles, VirtualLight};
#[cfg(test)]
pub(crate) use {
    letter::LetterUniform, main_light::MainLightUniform, near::NearUniform, place::MapPlaceUniform, shade::ShadeUniform,
};

use super::frame::Frame;
use super::gbuffer::GBuffer;
use crate::graph::{Graph, Handle, Texture};
use crate::world::{Accumulation, VirtualPlacement, VirtualShading};

/// Declares everything from the lights to the reflected radiance. None where nothing can leave a light, with the
/// reason in the report.
pub(super) fn declare<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    gbuffer: &GBuffer,
) -> Result<Option<Handle<Texture>>, VplError> {
    let Some(state) = frame.virtual_lights else { return Ok(None) };
    let published = state.settings.shading == VirtualShading::AsPublished;
    let lights = match state.settings.placement {
        VirtualPlacement::Rsm if published => return Err(VplError::PublishedRsm),
        VirtualPlacement::Rsm => place::declare(graph, frame, state),
        VirtualPlacement::Particles => particles::declare(graph, frame, state),
    };
    let Some(lights) = lights else { return Ok(None) };
    let summed = match state.settings.accumulation {
        Accumulation::Batched => shade::declare(graph, frame, gbuffer, state, lights),
        Accumulation::ByTheLetter => letter::declare(graph, frame, gbuffer, state, lights),
    };
    Ok(Some(near::declare(graph, frame, gbuffer, state, lights, summed)))
}
