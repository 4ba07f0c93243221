//! No indirect light: direct light and the sky's, for comparison and for slow machines.

use super::{GiMethod, IndirectLight, IndirectMethod, Preset, Runs};
use crate::gpu::Gpu;
use crate::graph::Graph;
use crate::render::error::RenderError;
use crate::render::frame::Frame;
use crate::render::geometry::GBuffer;
use crate::scene::Scene;

/// The method without any.
pub(super) struct NoIndirectLight;

impl IndirectMethod for NoIndirectLight {
    fn id(&self) -> GiMethod {
        GiMethod::NONE
    }

    fn title(&self) -> &'static str {
        "None"
    }

    fn about(&self) -> &'static str {
        "Direct light alone"
    }

    fn presets(&self) -> &'static [Preset] {
        &[Preset {
            name: "none",
            sets: &[("scene.sky_light", "false")],
            about: "direct light alone",
            runs: Runs::Always,
        }]
    }

    fn scatters_in_media(&self, _: &Scene) -> bool {
        true
    }

    fn declare<'a>(
        &'a self,
        graph: &mut Graph<'a>,
        _: &Frame<'a>,
        _: &GBuffer,
        _: &Gpu,
    ) -> Result<Option<IndirectLight>, RenderError> {
        graph.skip("indirect", "indirect light is switched off");
        Ok(None)
    }
}
