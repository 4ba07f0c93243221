//! The thesis's transport: light is injected from reflective shadow maps and propagated from cell to cell (Šefčík 2016,
//! chapters 3.10 and 5; Kaplanyan and Dachsbacher 2010). In come the lights' maps, out go four SH coefficients a cell and
//! colour channel, and what the visible surfaces reflect of them.
//!
//! ```text
//! rsm (a light) ─┬─ inject (a cascade) ───┬─ propagate (a cascade) ─ relight
//!                └─ blockers (a cascade) ─┘
//! ```
//! Light is kept as I/h² [W/(m² sr)] in 32-bit floats.

mod blockers;
mod inject;
mod propagate;
pub(super) mod relight;

#[cfg(test)]
pub(crate) use self::{blockers::CameraSamplesUniform, propagate::PropagationUniform};

use super::volume::volumes;
use super::{Field, Indirect};
use crate::graph::Graph;
use crate::render::error::RenderError;
use crate::render::frame::Frame;
use crate::render::geometry::GBuffer;
use crate::render::indirect::Scattered;
use crate::render::shadows::reflective::{self, Rsm};
use crate::scene::{Aabb, SceneClpv};

/// Bytes of a cell of light: three channels of four coefficients.
const LIGHT_BYTES: u64 = 48;

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
    if rsms.is_empty() {
        graph.skip("clpv", "no light feeds indirect light");
        return Ok(None);
    }
    let settings = &clpv.settings;
    let mut lit = Vec::with_capacity(volumes.len());
    for (level, volume) in volumes.iter().enumerate() {
        let injected = inject::declare(graph, frame, &rsms, level, volume);
        let blockers = if settings.occlusion {
            Some(blockers::declare(graph, frame, &rsms, settings.camera_blockers.then_some(gbuffer), level, volume))
        } else {
            graph.skip(format!("blockers, cascade {level}"), "occlusion is switched off");
            None
        };
        lit.push(propagate::declare(graph, settings, injected, blockers, level, volume));
    }
    let uniform = relight::uniform(settings, &volumes);
    let radiance = relight::declare(graph, frame, gbuffer, settings, &volumes, &lit);
    Ok(Some(Indirect {
        radiance,
        mirrored: None,
        is_glossy: false,
        field: Field::Propagated { uniform, lit },
        sky: None,
        scattered: Scattered::default(),
        change: None,
    }))
}
