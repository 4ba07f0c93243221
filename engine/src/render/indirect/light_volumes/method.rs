//! The door of the light volumes.

use super::sweep::{self, gather};
use super::{Indirect, diffusion, presets, radiosity, warnings};
use crate::gpu::Gpu;
use crate::graph::Graph;
use crate::render::error::RenderError;
use crate::render::frame::{Frame, Kept};
use crate::render::geometry::GBuffer;
use crate::render::indirect::gloss;
use crate::render::indirect::{GiMethod, IndirectLight, IndirectMethod, MissingSettings, Preset, RayUse, Subject};
use crate::scene::Scene;
use crate::world::{Clpv, GameWorld, Transform, Transport};
use glam::Vec3;

/// Light propagation volumes, swept or diffused.
pub(in crate::render) struct LightVolumesMethod;

fn settings(scene: &Scene) -> Option<&Clpv> {
    scene.clpv.as_ref().map(|clpv| &clpv.settings)
}

/// Adds light volumes that fit the scene.
fn add_volumes(world: &mut GameWorld, scene: &Scene) {
    let bounds = scene.bounds();
    let translation = if bounds.is_empty() { Vec3::ZERO } else { bounds.center() };
    let entity = world.spawn("Light volume", None);
    world.ecs.entity_mut(entity).insert((Transform { translation, ..Transform::default() }, Clpv::default()));
}

impl IndirectMethod for LightVolumesMethod {
    fn id(&self) -> GiMethod {
        GiMethod::CLPV
    }

    fn title(&self) -> &'static str {
        "Light propagation volumes"
    }

    fn about(&self) -> &'static str {
        "Cascaded light propagation volumes: the scene's, or one that fits it if it has none"
    }

    fn varies(&self, scene: &Scene) -> bool {
        settings(scene).is_some_and(|clpv| gather::is_wanted(clpv) || sweep::varies(clpv) || diffusion::varies(clpv))
    }

    fn gathers(&self, scene: &Scene) -> bool {
        settings(scene).is_some_and(gather::is_wanted)
    }

    fn rays(&self, scene: &Scene) -> RayUse {
        match settings(scene).is_some_and(|clpv| clpv.transport == Transport::Sweep) {
            true => RayUse::Optional,
            false => RayUse::None,
        }
    }

    fn has_sky_light(&self, scene: &Scene) -> bool {
        settings(scene).is_some_and(|clpv| clpv.transport == Transport::Sweep)
    }

    /// Media are part of the sweep and the gather.
    fn scatters_in_media(&self, scene: &Scene) -> bool {
        settings(scene).is_none_or(|clpv| clpv.transport == Transport::Sweep)
    }

    fn presets(&self) -> &'static [Preset] {
        presets::PRESETS
    }

    fn lost_light(&self, frame: &Frame) -> Vec<String> {
        warnings::lost_light(frame)
    }

    fn missing_settings(&self, scene: &Scene) -> Option<MissingSettings> {
        scene.clpv.is_none().then_some(MissingSettings { component: "clpv", add: add_volumes })
    }

    fn surfel_spacing(&self, subject: &Subject) -> Result<Option<f32>, RenderError> {
        let Some(clpv) = &subject.scene.clpv else { return Ok(None) };
        if clpv.settings.transport == Transport::Diffusion {
            return diffusion::surfel_spacing(clpv, subject);
        }
        let is_gathered = subject.has_rays && gather::is_wanted(&clpv.settings);
        let quality = gather::quality_of_volumes(&clpv.settings, is_gathered);
        let volumes = sweep::volumes(clpv, quality, subject.bounds, subject.view)?;
        Ok(volumes.first().map(|volume| volume.cell))
    }

    fn keeps(&self, frame: &Frame) -> Option<Kept> {
        radiosity::kept(frame)
    }

    fn declare<'a>(
        &'a self,
        graph: &mut Graph<'a>,
        frame: &Frame<'a>,
        gbuffer: &GBuffer,
        _: &Gpu,
    ) -> Result<Option<IndirectLight>, RenderError> {
        let Some(clpv) = &frame.scene.clpv else {
            graph.skip("clpv", "the scene has no Clpv component");
            return Ok(None);
        };
        let declared = match clpv.settings.transport {
            Transport::Sweep => sweep::declare(graph, frame, gbuffer, clpv)?,
            Transport::Diffusion => diffusion::declare(graph, frame, gbuffer, clpv)?,
        };
        Ok(declared.map(|light| of_all_surfaces(graph, frame, gbuffer, light)))
    }
}

/// Adds what glossy surfaces reflect of the volumes.
fn of_all_surfaces<'a>(graph: &mut Graph<'a>, frame: &Frame<'a>, gbuffer: &GBuffer, light: Indirect) -> IndirectLight {
    let radiance = gloss::declare(graph, frame, gbuffer, &light, gloss::Names::ALL);
    let (scattered, change) = (light.scattered, light.change);
    IndirectLight { radiance, mirrored: light.mirrored, field: Some(light.field), scattered, change }
}
