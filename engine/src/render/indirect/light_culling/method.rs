//! The door of stochastic light culling.

use super::{ACCEPTED, TESTED, casts_rays, declare, presets, settings, warnings};
use crate::gpu::Gpu;
use crate::graph::Graph;
use crate::render::error::RenderError;
use crate::render::frame::Frame;
use crate::render::geometry::GBuffer;
use crate::render::indirect::{GiMethod, IndirectLight, IndirectMethod, PointLayout, Preset, RayUse};
use crate::scene::Scene;

/// Stochastic light culling. It keeps nothing but what passes retain.
pub(in crate::render) struct LightCullingMethod;

impl IndirectMethod for LightCullingMethod {
    fn id(&self) -> GiMethod {
        GiMethod::SLC
    }

    fn title(&self) -> &'static str {
        "Stochastic light culling"
    }

    fn about(&self) -> &'static str {
        "Stochastic light culling: one bounce from virtual lights, by the scene's `slc` component or by default"
    }

    fn varies(&self, _: &Scene) -> bool {
        true
    }

    fn rays(&self, scene: &Scene) -> RayUse {
        if casts_rays(&settings(scene)) { RayUse::Required } else { RayUse::None }
    }

    fn has_sky_light(&self, scene: &Scene) -> bool {
        casts_rays(&settings(scene))
    }

    fn presets(&self) -> &'static [Preset] {
        presets::PRESETS
    }

    fn lost_light(&self, frame: &Frame) -> Vec<String> {
        warnings::lost_light(frame.scene)
    }

    fn light_counts(&self) -> Option<[&'static str; 2]> {
        Some([TESTED, ACCEPTED])
    }

    fn declare<'a>(
        &'a self,
        graph: &mut Graph<'a>,
        frame: &Frame<'a>,
        gbuffer: &GBuffer,
        gpu: &Gpu,
    ) -> Result<Option<IndirectLight>, RenderError> {
        let radiance = declare(graph, frame, gbuffer, gpu)?;
        Ok(radiance.map(IndirectLight::at_pixels))
    }

    fn point_layout(&self) -> Option<PointLayout> {
        // `VirtualLight` of `lib/slc.wgsl`: position, direction, normal, flux, and two more.
        Some(PointLayout { stride: 6, normal: 2, light: 3, has_gaps: true, count: None })
    }
}
