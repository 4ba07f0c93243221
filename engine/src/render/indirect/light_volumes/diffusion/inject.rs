//! Injection of light into a volume: from all texels of reflective shadow maps or from some that are drawn, and from samples
//! of emissive surfaces (Šefčík 2016, section 8.2).

use super::LIGHT_BYTES;
use crate::gpu::{Binding, ComputeKey};
use crate::graph::{Buffer, BufferDesc, Graph, Handle, PassContext, PassError};
use crate::render::frame::Frame;
use crate::render::frame::linear_groups;
use crate::render::indirect::light_volumes::rsm_draw::{Draw, Wanted, Weight};
use crate::render::indirect::light_volumes::texels::dispatch_texels;
use crate::render::indirect::light_volumes::volume::Volume;
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
    frame: &Frame<'a>,
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
    let mut pass = graph.pass(name.as_str());
    for rsm in *rsms {
        pass.read(rsm.base_color);
        pass.read(rsm.normal);
        pass.read(rsm.depth);
    }
    samples.iter().for_each(|samples| samples.read(&mut pass));
    emitters.iter().for_each(|emitters| pass.read(emitters.surfels));
    let (fixed, injected) = (pass.write(fixed), pass.write(injected));
    let lights: Vec<u64> = rsms.iter().map(|rsm| rsm.light.revision).collect();
    pass.key(&(volume.key(), lights, frame.scene.identity, samples.as_ref().map(Draw::key)));
    let (rsms, samples, emitters, volume) = (rsms.to_vec(), samples.clone(), *emitters, *volume);
    pass.execute(move |cx| {
        let target = cx.buffer(injected).clone();
        cx.encoder().clear_buffer(&target, 0, None);
        match &samples {
            Some(samples) => inject_samples(cx, samples, &volume, fixed, injected)?,
            None => rsms.iter().try_for_each(|rsm| inject(cx, rsm, &volume, fixed, injected))?,
        }
        emitters.iter().try_for_each(|emitters| inject_emitters(cx, emitters, &volume, fixed, injected))
    });
    injected
}

fn inject(
    cx: &mut PassContext,
    rsm: &Rsm,
    volume: &Volume,
    fixed: Handle<Buffer>,
    injected: Handle<Buffer>,
) -> Result<(), PassError> {
    let scale = rsm.fixed_point_scale();
    let (fixed, injected) = (cx.buffer(fixed).clone(), cx.buffer(injected).clone());
    cx.encoder().clear_buffer(&fixed, 0, None);
    let key = ComputeKey::new("indirect/light_volumes/diffusion/inject.wgsl", "inject");
    dispatch_texels(cx, &key, rsm, 0..rsm.views.len(), volume, &fixed, scale)?;
    let counts = cx.counts();
    counts.lights += 1;
    counts.cells += u64::from(volume.cell_count());
    let volume_uniform = cx.gpu.uniform("volume", &volume.uniform());
    let layer = cx.gpu.uniform("rsm", &rsm.layer_uniform(0, scale));
    cx.dispatch(
        &ComputeKey::new("indirect/light_volumes/diffusion/inject.wgsl", "add_to_volume"),
        &[
            ("volume", Binding::Buffer(&volume_uniform)),
            ("rsm", Binding::Buffer(&layer)),
            ("fixed", Binding::Buffer(&fixed)),
            ("injected", Binding::Buffer(&injected)),
        ],
        linear_groups(12 * volume.cell_count()),
    )
}

/// Adds the light of the texels that are drawn.
fn inject_samples(
    cx: &mut PassContext,
    samples: &Draw,
    volume: &Volume,
    fixed: Handle<Buffer>,
    injected: Handle<Buffer>,
) -> Result<(), PassError> {
    const SHADER: &str = "indirect/light_volumes/diffusion/inject_samples.wgsl";
    let volume_uniform = cx.gpu.uniform("volume", &volume.uniform());
    let (fixed, injected) = (cx.buffer(fixed).clone(), cx.buffer(injected).clone());
    cx.encoder().clear_buffer(&fixed, 0, None);
    let into = [("volume", Binding::Buffer(&volume_uniform)), ("fixed", Binding::Buffer(&fixed))];
    samples.dispatch(cx, &samples.shader(SHADER, "inject"), &into)?;
    let counts = cx.counts();
    counts.injections += u64::from(samples.points());
    counts.cells += u64::from(volume.cell_count());
    let sums = samples.sums(cx);
    let sums = sums.each_ref().map(|(name, buffer)| (*name, Binding::Buffer(buffer)));
    let bindings = [&into[..], &sums, &[("injected", Binding::Buffer(&injected))]].concat();
    cx.dispatch(&samples.shader(SHADER, "add_to_volume"), &bindings, linear_groups(12 * volume.cell_count()))
}

/// Adds the light of emissive surfaces.
fn inject_emitters(
    cx: &mut PassContext,
    emitters: &Emitters,
    volume: &Volume,
    fixed: Handle<Buffer>,
    injected: Handle<Buffer>,
) -> Result<(), PassError> {
    const SHADER: &str = "indirect/light_volumes/diffusion/inject_emitters.wgsl";
    // As of a light's flux: a lobe's coefficient is at most a third of it.
    let total = emitters.flux.max_element().clamp(1e-30, 1e36);
    let scale = (29.0 - total.log2().ceil()).exp2();
    let uniform = EmissionUniform { scale, padding_a: 0, padding_b: 0, padding_c: 0 };
    let (volume_uniform, emission) =
        (cx.gpu.uniform("volume", &volume.uniform()), cx.gpu.uniform("emission", &uniform));
    let (fixed, injected) = (cx.buffer(fixed).clone(), cx.buffer(injected).clone());
    let surfels = cx.buffer(emitters.surfels).clone();
    cx.encoder().clear_buffer(&fixed, 0, None);
    cx.dispatch(
        &ComputeKey::new(SHADER, "inject"),
        &[
            ("volume", Binding::Buffer(&volume_uniform)),
            ("emission", Binding::Buffer(&emission)),
            ("surfels", Binding::Buffer(&surfels)),
            ("fixed", Binding::Buffer(&fixed)),
        ],
        linear_groups(emitters.count),
    )?;
    cx.counts().cells += u64::from(volume.cell_count());
    cx.dispatch(
        &ComputeKey::new(SHADER, "add_to_volume"),
        &[
            ("volume", Binding::Buffer(&volume_uniform)),
            ("emission", Binding::Buffer(&emission)),
            ("fixed", Binding::Buffer(&fixed)),
            ("injected", Binding::Buffer(&injected)),
        ],
        linear_groups(12 * volume.cell_count()),
    )
}
