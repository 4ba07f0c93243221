//! Virtual lights from the lights' reflective shadow maps ("ignore the further bounces").

use super::particles::{LightCount, Lights, VirtualLights};
use super::schedule::deal;
use super::trace_particles::VirtualLight;
use crate::gpu::ComputeKey;
use crate::graph::{BufferDesc, Counts, Graph};
use crate::render::frame::Frame;
use crate::render::scene_gpu::light_uniform::LightUniform;
use crate::render::shadows::reflective::{self, Rsm};
use crate::world::ParticleSequence;
use encase::ShaderType;

/// `Place` of `indirect/instant_radiosity/place.wgsl`.
#[derive(ShaderType)]
pub(crate) struct MapPlaceUniform {
    first: u32,
    count: u32,
    seed: u32,
    random: u32,
    near_bound: f32,
    pad_a: u32,
    pad_b: u32,
    pad_c: u32,
}

/// Declares the maps and the lights from them; none where no light is seen to light anything.
pub(super) fn declare<'a>(graph: &mut Graph<'a>, frame: &Frame<'a>, state: &'a VirtualLights) -> Option<Lights> {
    let lights = frame.scene.lights.iter().zip(0..);
    let maps: Vec<Rsm<'a>> =
        lights.filter_map(|(light, index)| reflective::declare(graph, frame, light, index, &frame.bounds)).collect();
    let settings = &state.settings;
    if maps.is_empty() {
        graph.skip("place", "no light has a reflective shadow map");
        return None;
    }
    // Every layer of every map alike: a cube's faces share its light, and lights their number.
    let layers: Vec<(usize, usize)> =
        maps.iter().enumerate().flat_map(|(map, rsm)| (0..rsm.views.len()).map(move |layer| (map, layer))).collect();
    let counts = deal(settings.particles, &vec![1.0; layers.len()]);
    let total: u32 = counts.iter().sum();
    let size = u64::from(total) * size_of::<VirtualLight>() as u64;
    let buffer = graph.retained_buffer("virtual lights", BufferDesc::new(size, wgpu::BufferUsages::STORAGE));
    let mut pass = graph.compute("place", ComputeKey::new("indirect/instant_radiosity/place.wgsl", "main"));
    let buffer = pass.write("virtual_lights", buffer);
    let mut first = 0;
    for (&(map, layer), &count) in layers.iter().zip(&counts) {
        let rsm = &maps[map];
        let place = MapPlaceUniform {
            first,
            count,
            seed: super::random::hash_pair(settings.seed, first),
            random: u32::from(settings.sequence == ParticleSequence::Random),
            near_bound: settings.near_bound,
            pad_a: 0,
            pad_b: 0,
            pad_c: 0,
        };
        let mut step = pass.step("main");
        step.uniform("place", &place);
        step.uniform("light", &LightUniform::new(rsm.light));
        step.uniform("rsm", &rsm.layer_uniform(layer, 1.0));
        step.read("base_color", rsm.base_color);
        step.read("normal", rsm.normal);
        step.read("depth", rsm.depth);
        step.over_items(count);
        first += count;
    }
    pass.count(Counts { lights: total.into(), ..Counts::default() });
    pass.finish();
    Some(Lights { buffer, all: buffer, count: LightCount::Known(total) })
}
