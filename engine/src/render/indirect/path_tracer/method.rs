//! The door of the path tracer.

use crate::gpu::Gpu;
use crate::graph::Graph;
use crate::render::error::RenderError;
use crate::render::frame::Frame;
use crate::render::geometry::GBuffer;
use crate::render::indirect::{GiMethod, IndirectLight, IndirectMethod, Preset, Runs};
use crate::render::settings::RenderSettings;
use crate::scene::Scene;

/// The path tracer as a method. It makes whole frames; the renderer keeps its samples.
pub(in crate::render) struct PathTracing;

impl IndirectMethod for PathTracing {
    fn id(&self) -> GiMethod {
        GiMethod::REFERENCE
    }

    fn title(&self) -> &'static str {
        "Path tracer"
    }

    fn about(&self) -> &'static str {
        "Path tracing, the reference: slow, and right but for noise"
    }

    fn presets(&self) -> &'static [Preset] {
        &[Preset { name: "reference", sets: &[], about: "path tracing on the device", runs: Runs::Always }]
    }

    fn has_sky_light(&self, _: &Scene) -> bool {
        true
    }

    fn is_whole_frame(&self, _: &RenderSettings) -> bool {
        true
    }

    /// Layers that show no light are drawn, not traced: there is nothing to declare for them.
    fn declare<'a>(
        &'a self,
        graph: &mut Graph<'a>,
        _: &Frame<'a>,
        _: &GBuffer,
        _: &Gpu,
    ) -> Result<Option<IndirectLight>, RenderError> {
        graph.skip("indirect", "the path tracer makes whole frames");
        Ok(None)
    }
}
