//! Instant radiosity: virtual point lights where particles from the lights hit (Keller 1997, "Instant Radiosity"). The
//! report is Emanuele Franchi and Lorenzo Ferrante, "Virtual Point Lights".
//!
//! ```text
//! particles (shot on the CPU, kept while lights and surfaces stay) ─ choice ─ reach (per view) ─ shade ─ near ─ compose
//! rsm ─ place ─────────────────────────────────────────────────────────────────────────────────────┘
//! ```
//! The image is f·Φ/π·cosθ·cosθ_i/max(d², d_min²)·V summed over all lights. d_min is the distance between neighbouring
//! lights, which bounds the bright spots around them: within about that distance a surface is lit by few lights, and
//! their 1/d² would be all that is seen. What that leaves out is found by short rays (`near`).

mod beam;
mod error;
mod intersection;
mod main_light;
mod method;
mod near;
mod particles;
mod paths;
mod place;
mod presets;
mod published;
mod random;
mod resampling;
mod schedule;
mod shade;
mod source;
mod surface;
mod trace_particles;
mod view_points;
mod warnings;

pub use error::VplError;
pub use intersection::{CastHit, Caster, IntersectionCounts, intersect_square, intersect_unit_box};
pub use method::{InstantRadiosityMethod, virtual_lights};
pub use particles::VirtualLights;
pub use trace_particles::{MAX_PATHS, Particles, VirtualLight};
#[cfg(test)]
pub(crate) use {
    main_light::MainLightUniform, near::NearUniform, place::MapPlaceUniform, published::LetterUniform,
    shade::ShadeUniform,
};

use crate::graph::{Graph, Handle, Texture};
use crate::render::frame::Frame;
use crate::render::geometry::gbuffer::GBuffer;
use crate::world::{Accumulation, VirtualPlacement, VirtualShading};

/// Declares everything from the lights to the reflected radiance. None where nothing can leave a light, with the
/// reason in the report.
fn declare<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    gbuffer: &GBuffer,
    state: &'a VirtualLights,
) -> Result<Option<Handle<Texture>>, VplError> {
    let published = state.settings.shading == VirtualShading::AsPublished;
    let lights = match state.settings.placement {
        VirtualPlacement::Rsm if published => return Err(VplError::PublishedRsm),
        VirtualPlacement::Rsm => place::declare(graph, frame, state),
        VirtualPlacement::Particles => particles::declare(graph, frame, state),
    };
    let Some(lights) = lights else { return Ok(None) };
    let summed = match state.settings.accumulation {
        Accumulation::Batched => shade::declare(graph, frame, gbuffer, state, lights),
        Accumulation::ByTheLetter => published::declare(graph, frame, gbuffer, state, lights),
    };
    Ok(Some(near::declare(graph, frame, gbuffer, state, lights, summed)))
}
