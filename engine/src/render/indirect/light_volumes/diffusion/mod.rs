//! The thesis's transport: light is injected from reflective shadow maps and propagated from cell to cell (Petr
//! Šefčík 2016, "Computing global illumination in real-time using Cascaded Light Propagation Volumes", chapters 3.10
//! and 5; Kaplanyan and Dachsbacher 2010). In come the lights' maps, out go four SH coefficients a cell and
//! colour channel, and what the visible surfaces reflect of them.
//!
//! ```text
//! surfels that emit ───┐
//! rsm (a light) ─┬─ inject (a cascade) ───┬─ propagate (a cascade) ─ relight ─ gloss march
//!                └─ blockers (a cascade) ─┘
//! ```
//! Light is kept as I/h² [W/(m² sr)] in 32-bit floats.

mod ambient_occlusion;
mod blockers;
mod gloss_march;
mod inject;
mod propagate;
pub(super) mod relight;

#[cfg(test)]
pub(crate) use self::{
    ambient_occlusion::OcclusionUniform, blockers::CameraSamplesUniform, inject::EmissionUniform,
    propagate::PropagationUniform, relight::RelitRegionUniform,
};

use super::sweep::surfels;
use super::volume::volumes;
use super::{Field, Indirect};
use crate::graph::Graph;
use crate::render::error::RenderError;
use crate::render::frame::Frame;
use crate::render::geometry::GBuffer;
use crate::render::indirect::{Scattered, Subject};
use crate::render::shadows::reflective::{self, Rsm};
use crate::scene::{Aabb, SceneClpv};
use crate::world::{Clpv, Transport};
use glam::Vec3;

/// Bytes of a cell of light: three channels of four coefficients.
const LIGHT_BYTES: u64 = 48;

/// Whether other texels are drawn in each of the frames that are averaged.
pub(super) fn varies(settings: &Clpv) -> bool {
    settings.transport == Transport::Diffusion && settings.rsm_samples > 0
}

/// How far apart the samples of emissive surfaces may be \[m\]: `None` where nothing is emissive.
///
/// # Errors
/// Settings that make no volume.
pub(super) fn surfel_spacing(clpv: &SceneClpv, subject: &Subject) -> Result<Option<f32>, RenderError> {
    let is_emissive = subject.scene.primitives.iter().any(|primitive| primitive.material.emissive != Vec3::ZERO);
    if !is_emissive {
        return Ok(None);
    }
    let volumes = volumes(clpv, subject.bounds, subject.view)?;
    Ok(volumes.first().map(|volume| volume.cell))
}

/// Declares all passes; none, with the reason in the report, if no light feeds the volumes.
///
/// # Errors
/// Settings that make no volume.
pub(super) fn declare<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    gbuffer: &GBuffer,
    clpv: &SceneClpv,
) -> Result<Option<Indirect>, RenderError> {
    let volumes = volumes(clpv, &frame.bounds, frame.view)?;
    let reach = volumes.iter().fold(Aabb::EMPTY, |reach, volume| reach.union(&volume.bounds()));
    let lights = frame.scene.lights.iter().zip(0..);
    let rsms: Vec<Rsm> =
        lights.filter_map(|(light, index)| reflective::declare(graph, frame, light, index, &reach)).collect();
    let settings = &clpv.settings;
    let emitters = emitters(graph, frame);
    if rsms.is_empty() && emitters.is_none() {
        graph.skip("clpv", "no light feeds indirect light");
        return Ok(None);
    }
    let samples = inject::samples(graph, frame, &rsms, reach, settings.rsm_samples);
    let sources = inject::Sources { rsms: &rsms, samples, emitters };
    let mut lit = Vec::with_capacity(volumes.len());
    for (level, volume) in volumes.iter().enumerate() {
        let injected = inject::declare(graph, &sources, level, volume);
        let blockers = if settings.occlusion {
            let camera = settings.camera_blockers.then_some(gbuffer);
            Some(blockers::declare(graph, frame, &rsms, camera, level, volume, settings.formulas))
        } else {
            graph.skip(format!("blockers, cascade {level}"), "occlusion is switched off");
            None
        };
        lit.push(propagate::declare(graph, settings, injected, blockers, level, volume));
    }
    let uniform = relight::uniform(settings, &volumes);
    let diffuse = relight::declare(graph, frame, gbuffer, settings, &volumes, &lit);
    let marched = gloss_march::declare(graph, frame, gbuffer, settings, diffuse, (&volumes, &lit));
    Ok(Some(Indirect {
        radiance: marched.unwrap_or(diffuse),
        mirrored: None,
        is_glossy: marched.is_some(),
        field: Field::Propagated { uniform, lit },
        sky: None,
        scattered: Scattered::default(),
        change: None,
    }))
}

/// Samples of the emissive surfaces.
fn emitters<'a>(graph: &mut Graph<'a>, frame: &Frame<'a>) -> Option<inject::Emitters> {
    let is_emissive = frame.scene.primitives.iter().any(|primitive| primitive.material.emissive != Vec3::ZERO);
    if !is_emissive || !frame.surfels.is_emissive() {
        return None;
    }
    let surfels = surfels::declare(graph, frame);
    Some(inject::Emitters { surfels, count: frame.surfels.count(), flux: frame.surfels.emitted() })
}
