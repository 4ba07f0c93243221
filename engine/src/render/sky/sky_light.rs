//! Light of the sky where the method of indirect light contributes none.
//!
//! The sky's light is swept once through a coarse grid around the scene, past what blocks it, so that rooms stay dark
//! that the sky does not see. Surfaces reflect it once.

use crate::graph::Graph;
use crate::render::frame::Frame;
use crate::render::geometry::gbuffer::GBuffer;
use crate::render::indirect::gloss;
use crate::render::indirect::light_volumes;
use crate::render::indirect::{IndirectLight, IndirectMethod};
use crate::render::settings::RenderSettings;
use crate::scene::Scene;
use glam::Vec3;

/// Whether the sky must be swept for itself: the image shows indirect light, and the method has no light of the sky.
pub(in crate::render) fn is_needed(scene: &Scene, settings: &RenderSettings, method: &dyn IndirectMethod) -> bool {
    let is_lit = scene.sky_light && scene.sky != Vec3::ZERO;
    settings.only.shows_indirect() && is_lit && !method.has_sky_light(scene)
}

/// Declares the light of the sky; none if the method has it, or there is none.
pub(in crate::render) fn declare<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    gbuffer: &GBuffer,
    method: &dyn IndirectMethod,
) -> Option<IndirectLight> {
    if !is_needed(frame.scene, frame.settings, method) {
        return None;
    }
    let swept = light_volumes::sweep::sky::declare(graph, frame, gbuffer);
    let radiance = gloss::declare(graph, frame, gbuffer, &swept, gloss::Names::SKY);
    Some(IndirectLight { field: Some(swept.field), ..IndirectLight::at_pixels(radiance) })
}
