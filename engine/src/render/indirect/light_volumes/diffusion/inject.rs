//! Injection of light into a volume: from all texels of reflective shadow maps or from some that are drawn, and from samples
//! of emissive surfaces (Šefčík 2016, section 8.2).

use super::LIGHT_BYTES;
use crate::gpu::ComputeKey;
use crate::graph::{Buffer, BufferDesc, ComputeBuilder, Counts, Graph, Handle, Step};
use crate::render::frame::Frame;
use crate::render::indirect::light_volumes::rsm_draw::{Draw, Wanted, Weight};
use crate::render::indirect::light_volumes::texels;
use crate::render::indirect::light_volumes::volume::Volume;
use crate::render::scene_gpu::light_uniform::LightUniform;
use crate::render::shadows::reflective::Rsm;
use crate::scene::Aabb;
use encase::ShaderType;
use glam::Vec3;
use wgpu::BufferUsages;

/// `Emission` of `indirect/light_volumes/diffusion/inject_emitters.wgsl`.
#[derive(ShaderType)]
pub(crate) struct EmissionUniform {
    scale: f32,
    padding_a: u32,
    padding_b: u32,
    padding_c: u32,
}

/// Samples of the emissive surfaces.
#[derive(Clone, Copy)]
pub(super) struct Emitters {
    /// The scene's surfels.
    pub surfels: Handle<Buffer>,
    /// Number of all surfels.
    pub count: u32,
    /// Flux that all of them emit \[W\].
    pub flux: Vec3,
}

/// Sources of light.
pub(super) struct Sources<'s, 'a> {
    /// What lights see.
    pub rsms: &'s [Rsm<'a>],
    /// Texels drawn from it, in place of all texels.
    pub samples: Option<Draw<'a>>,
    /// What emits.
    pub emitters: Option<Emitters>,
}

/// Draws the texels that are injected, within `reach`; `None` if all are.
pub(super) fn samples<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    rsms: &[Rsm<'a>],
    reach: Aabb,
    points: u32,
) -> Option<Draw<'a>> {
    if points == 0 || rsms.is_empty() {
        return None;
    }
    let of_light = |rsm: &Rsm| f64::from(rsm.light.intensity.max_element()) * f64::from(rsm.extent());
    let total = rsms.iter().map(of_light).sum::<f64>().clamp(1e-22, 1e36);
    let scale = (38.0 - total.log2().ceil()).exp2() as f32;
    let seed = frame.seed() ^ 0x2c1b_3c6d;
    let wanted = Wanted { reach, scale, points, seed, weight: Weight::Reflected };
    Some(Draw::declare(graph, ["inject, flux of texels", "inject, flux of strips"], rsms.iter(), wanted))
}

/// Declares the injection of all lights and emissive surfaces into one cascade: each in fixed point with a scale of its own, added in the
/// scene's order, so that the sum depends neither on the order of texels nor on the brightest light.
pub(super) fn declare<'a>(
    graph: &mut Graph<'a>,
    sources: &Sources<'_, 'a>,
    level: usize,
    volume: &Volume,
) -> Handle<Buffer> {
    let Sources { rsms, samples, emitters } = sources;
    let name = format!("inject, cascade {level}");
    let bytes = LIGHT_BYTES * u64::from(volume.cell_count());
    let desc = BufferDesc::new(bytes, BufferUsages::STORAGE | BufferUsages::COPY_DST);
    let fixed = graph.buffer(format!("{name}, fixed point"), desc.clone());
    let injected = graph.retained_buffer(name.as_str(), desc);
    let mut pass = graph.compute(name, ComputeKey::new("indirect/light_volumes/diffusion/inject.wgsl", "inject"));
    pass.uniform("volume", &volume.uniform());
    let injection =
        Injection { volume: *volume, fixed: pass.write("fixed", fixed), injected: pass.write("injected", injected) };
    pass.clear(injection.injected);
    match samples {
        Some(samples) => injection.inject_samples(&mut pass, samples),
        None => rsms.iter().for_each(|rsm| injection.inject(&mut pass, rsm)),
    }
    emitters.iter().for_each(|emitters| injection.inject_emitters(&mut pass, emitters));
    pass.finish();
    injection.injected
}

/// What light is injected into.
struct Injection {
    volume: Volume,
    fixed: Handle<Buffer>,
    injected: Handle<Buffer>,
}

impl Injection {
    /// Ends a step that adds what was injected to the volume.
    fn add(&self, mut step: Step) {
        step.count(Counts { cells: self.volume.cell_count().into(), ..Counts::default() });
        step.over_items(12 * self.volume.cell_count());
    }

    fn inject<'a>(&self, pass: &mut ComputeBuilder<'_, 'a>, rsm: &Rsm<'a>) {
        let scale = rsm.fixed_point_scale();
        pass.clear(self.fixed);
        texels::declare_steps(pass, "inject", (rsm, 0..rsm.views.len()), (scale, LightUniform::new(rsm.light)), |_| ());
        pass.count(Counts { lights: 1, ..Counts::default() });
        let mut step = pass.step("add_to_volume");
        step.uniform("rsm", &rsm.layer_uniform(0, scale));
        self.add(step);
    }

    /// Adds the light of the texels that are drawn.
    fn inject_samples<'a>(&self, pass: &mut ComputeBuilder<'_, 'a>, samples: &Draw<'a>) {
        let shader = |entry| samples.shader("indirect/light_volumes/diffusion/inject_samples.wgsl", entry);
        pass.clear(self.fixed);
        samples.declare_steps(pass, &shader("inject"));
        pass.count(Counts { injections: samples.points().into(), ..Counts::default() });
        let mut step = pass.step_of(shader("add_to_volume"));
        samples.bind_sums(&mut step);
        self.add(step);
    }

    /// Adds the light of emissive surfaces.
    fn inject_emitters(&self, pass: &mut ComputeBuilder, emitters: &Emitters) {
        let shader = |entry| ComputeKey::new("indirect/light_volumes/diffusion/inject_emitters.wgsl", entry);
        // As of a light's flux: a lobe's coefficient is at most a third of it.
        let total = emitters.flux.max_element().clamp(1e-30, 1e36);
        let scale = (29.0 - total.log2().ceil()).exp2();
        let uniform = EmissionUniform { scale, padding_a: 0, padding_b: 0, padding_c: 0 };
        pass.clear(self.fixed);
        let mut step = pass.step_of(shader("inject"));
        step.uniform("emission", &uniform);
        step.read("surfels", emitters.surfels);
        step.over_items(emitters.count);
        let mut step = pass.step_of(shader("add_to_volume"));
        step.uniform("emission", &uniform);
        self.add(step);
    }
}
