//! The door of instant radiosity.

use super::{VirtualLights, declare, main_light, paths, presets, warnings};
use crate::gpu::Gpu;
use crate::graph::{Graph, Handle, Texture};
use crate::render::error::RenderError;
use crate::render::frame::Frame;
use crate::render::geometry::GBuffer;
use crate::render::indirect::{GiMethod, IndirectLight, IndirectMethod, Methods, MissingSettings, PointLayout, Preset};
use crate::scene::Scene;
use crate::world::{GameWorld, InstantRadiosity, Transform, VirtualPlacement, VirtualShading};

/// Instant radiosity, with what it keeps of earlier frames.
#[derive(Default)]
pub struct InstantRadiosityMethod {
    /// Made for the first frame.
    state: Option<VirtualLights>,
}

/// The virtual lights that a [renderer's methods](crate::render::Renderer::methods) keep, for tools and measurements: none before the first frame that asked for them.
pub fn virtual_lights(methods: &Methods) -> Option<&VirtualLights> {
    methods.of_type::<InstantRadiosityMethod>()?.state.as_ref()
}

/// Adds the default settings.
fn add_settings(world: &mut GameWorld, _: &Scene) {
    let entity = world.spawn("Virtual lights", None);
    world.ecs.entity_mut(entity).insert((Transform::default(), InstantRadiosity::default()));
}

impl IndirectMethod for InstantRadiosityMethod {
    fn id(&self) -> GiMethod {
        GiMethod::VPL
    }

    fn title(&self) -> &'static str {
        "Instant radiosity"
    }

    fn about(&self) -> &'static str {
        "Instant radiosity: virtual point lights, as the scene sets them or by default"
    }

    fn varies(&self, _: &Scene) -> bool {
        true
    }

    fn presets(&self) -> &'static [Preset] {
        presets::PRESETS
    }

    fn lost_light(&self, frame: &Frame) -> Vec<String> {
        warnings::lost_light(frame.scene)
    }

    fn missing_settings(&self, scene: &Scene) -> Option<MissingSettings> {
        scene.vpl.is_none().then_some(MissingSettings { component: "vpl", add: add_settings })
    }

    fn has_sky_light(&self, scene: &Scene) -> bool {
        // Maps show what lights see, and no sky.
        let settings = scene.vpl.clone().unwrap_or_default();
        settings.placement == VirtualPlacement::Particles || settings.shading == VirtualShading::AsPublished
    }

    fn update(&mut self, gpu: &Gpu, scene: &Scene) -> Result<(), RenderError> {
        Ok(self.state.get_or_insert_with(|| VirtualLights::new(gpu)).update(gpu, scene)?)
    }

    fn declare<'a>(
        &'a self,
        graph: &mut Graph<'a>,
        frame: &Frame<'a>,
        gbuffer: &GBuffer,
        _: &Gpu,
    ) -> Result<Option<IndirectLight>, RenderError> {
        let Some(state) = &self.state else { return Ok(None) };
        let radiance = declare(graph, frame, gbuffer, state)?;
        Ok(radiance.map(IndirectLight::at_pixels))
    }

    fn declare_direct<'a>(
        &'a self,
        graph: &mut Graph<'a>,
        frame: &Frame<'a>,
        gbuffer: &GBuffer,
    ) -> Option<Handle<Texture>> {
        let settings = self.state.as_ref()?.published()?;
        Some(main_light::declare(graph, frame, gbuffer, settings))
    }

    fn declare_overlay<'a>(
        &'a self,
        graph: &mut Graph<'a>,
        frame: &Frame<'a>,
        gbuffer: &GBuffer,
        radiance: Handle<Texture>,
    ) -> Handle<Texture> {
        match &self.state {
            Some(state) if frame.settings.particle_paths > 0 => paths::declare(graph, frame, gbuffer, state, radiance),
            _ => radiance,
        }
    }

    fn point_layout(&self) -> Option<PointLayout> {
        let count = self.state.as_ref().map(|state| state.particles().lights.len() as u32);
        // `VirtualLight` of `lib/vpl.wgsl`: place, normal, intensity, and two more.
        Some(PointLayout { stride: 5, normal: 1, light: 2, has_gaps: false, count: count.filter(|count| *count > 0) })
    }
}
