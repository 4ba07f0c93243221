//! The sources of a bounce: what each cell sends out.

use super::directions::Directions;
use super::opacity::Obstacles;
use super::{Level, Light};
use crate::gpu::{Binding, ComputeKey, Gpu, ShaderDef};
use crate::graph::{Buffer, BufferDesc, Graph, Handle, PassContext, PassError};
use crate::render::frame::Frame;
use crate::render::frame::linear_groups;
use crate::render::indirect::light_volumes::texels::dispatch_rsm;
use crate::render::indirect::light_volumes::volume::Volume;
use crate::render::shadows::reflective::Rsm;
use crate::world::Precision;
use encase::ShaderType;
use glam::{UVec2, Vec3};
use std::f32::consts::PI;
use wgpu::BufferUsages;

/// `Emit` of `indirect/light_volumes/sweep/emit.wgsl`.
#[derive(ShaderType, Clone, Copy)]
pub(crate) struct EmitUniform {
    scale: f32,
    bounce: u32,
    padding: UVec2,
    sky: Vec3,
    inner_low: Vec3,
    inner_high: Vec3,
}

/// Bytes of the sums of a bounce: see `totals` of `indirect/light_volumes/sweep/emit.wgsl`.
pub(super) const TOTAL_BYTES: u64 = 24;

/// Where light comes from.
pub(super) struct Sources<'s, 'a> {
    /// Reflective shadow maps of the lights.
    pub rsms: &'s [Rsm<'a>],
    /// The scene's surfaces.
    pub surfels: Handle<Buffer>,
    /// How many.
    pub count: u32,
    /// Turns flux [W] into fixed point.
    pub scale: f32,
}

/// One bounce of one cascade.
#[derive(Clone, Copy)]
pub(super) struct Step {
    /// The cascade.
    pub index: usize,
    /// 0: light straight from the lights.
    pub bounce: u32,
    /// The light that surfaces send out.
    pub light: Light,
}

/// The buffer of the flux of all bounces.
pub(super) fn totals(graph: &mut Graph<'_>, bounces: u32) -> Handle<Buffer> {
    let usage = BufferUsages::STORAGE | BufferUsages::COPY_DST;
    let totals = graph.retained_buffer("flux of the bounces", BufferDesc::new(TOTAL_BYTES * u64::from(bounces), usage));
    graph.clear("flux of the bounces", totals)
}

/// Power of two that turns flux [W] into fixed point: all light of the lights together is below 2³⁸ of 2⁴⁵, and all bounces
/// add less than fifty times as much.
///
/// A power of two leaves all bits of the flux in place: light of 2ᵏ times the intensity gives the same sums.
pub(super) fn scale(frame: &Frame, rsms: &[Rsm], levels: &[Level]) -> f32 {
    let of_light = |rsm: &Rsm| f64::from(rsm.light.intensity.max_element()) * f64::from(rsm.extent());
    let sky = levels.last().map_or(Vec3::ZERO, |level| sky_flux(frame, &level.volume));
    let surfaces = f64::from((frame.surfels.emitted() + sky).max_element());
    let total = rsms.iter().map(of_light).sum::<f64>() + surfaces;
    ((38.0 - total.clamp(1e-22, 1e36).log2().ceil()).exp2()) as f32
}

/// The same for the light of surfaces of radiance 1.
fn white_scale(frame: &Frame) -> f32 {
    ((38.0 - (std::f64::consts::PI * frame.surfels.area()).clamp(1e-22, 1e36).log2().ceil()).exp2()) as f32
}

/// Flux of the sky into a box [W].
fn sky_flux(frame: &Frame, volume: &Volume) -> Vec3 {
    let size = volume.cells.as_vec3() * volume.cell;
    frame.scene.sky * (2.0 * PI * (size.x * size.y + size.y * size.z + size.z * size.x))
}

/// Declares the sources of a bounce in a cascade.
pub(super) fn declare<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    sources: &Sources<'_, 'a>,
    directions: &Directions,
    levels: &mut [Level],
    totals: Option<&mut Handle<Buffer>>,
    step: Step,
) {
    let is_coarsest = step.index + 1 == levels.len();
    let inner = step.index.checked_sub(1).map(|finer| levels[finer].volume);
    let outer = levels.get(step.index + 1).map(|outer| outer.emission);
    let level = &mut levels[step.index];
    let volume = level.volume;
    let received = match step.light {
        Light::White => None,
        Light::Scene(received) => received,
    };
    let is_white = matches!(step.light, Light::White);
    let is_straight = step.bounce == 0 && !is_white;
    let scale = if is_white { white_scale(frame) } else { sources.scale };
    let name = match step.bounce {
        0 => format!("emit, {}", level.name),
        bounce => format!("emit, {}, bounce {}", level.name, bounce + 1),
    };
    let usage = BufferUsages::STORAGE | BufferUsages::COPY_DST;
    let sum_bytes = 144 * u64::from(volume.cell_count()) + size_of::<f32>() as u64;
    let sums = graph.buffer(format!("{name}, sums"), BufferDesc::new(sum_bytes, usage));
    let is_exposed = level.precision == Precision::Half;
    let outer = outer.filter(|_| is_exposed);
    let mut pass = graph.pass(name);
    pass.read(sources.surfels);
    let obstacles = level.obstacles;
    [obstacles.opacity, obstacles.coverage, obstacles.links].into_iter().for_each(|buffer| pass.read(buffer));
    if is_straight {
        for rsm in sources.rsms {
            pass.read(rsm.base_color);
            pass.read(rsm.normal);
            pass.read(rsm.depth);
        }
    }
    let lamp_light = level.lamp_light.filter(|_| !is_white);
    received.into_iter().chain(outer).chain(lamp_light).for_each(|buffer| pass.read(buffer));
    let totals = totals.filter(|_| is_coarsest).map(|totals| {
        *totals = pass.write(*totals);
        *totals
    });
    let buffers = Buffers {
        surfels: sources.surfels,
        obstacles,
        received,
        lamp_light,
        is_straight,
        sums: pass.write(sums),
        emission: pass.write(level.emission),
        is_exposed,
        outer,
        totals,
    };
    level.emission = buffers.emission;
    let sky = if is_coarsest && is_straight { sky_flux(frame, &volume) } else { Vec3::ZERO };
    let lights: Vec<u64> = sources.rsms.iter().map(|rsm| rsm.light.revision).collect();
    let lights = if is_straight { lights } else { Vec::new() };
    let sky_bits = sky.to_array().map(f32::to_bits);
    pass.key(&(
        volume.key(),
        inner.map(|inner| inner.key()),
        lights,
        sky_bits,
        scale.to_bits(),
        step.bounce,
        directions.key(),
        frame.scene.identity,
        (is_exposed, is_white, lamp_light.is_some()),
    ));
    // Of what lights shine at, less their light on its way through media.
    pass.key(&is_straight.then(|| frame.media_key()));
    let in_cells = |point: Vec3| (point - volume.origin) / volume.cell;
    let emit = EmitUniform {
        scale,
        bounce: step.bounce,
        padding: UVec2::ZERO,
        sky: sky * scale,
        inner_low: inner.map_or(Vec3::ZERO, |inner| in_cells(inner.bounds().min).round()),
        inner_high: inner.map_or(Vec3::ZERO, |inner| in_cells(inner.bounds().max).round()),
    };
    let rsms = if is_straight { sources.rsms.to_vec() } else { Vec::new() };
    let (surfels, directions) = (frame.surfels, directions.clone());
    let frame = frame.clone();
    pass.execute(move |cx| {
        let sums = cx.buffer(buffers.sums).clone();
        cx.encoder().clear_buffer(&sums, 0, None);
        let uniforms = Uniforms::new(cx.gpu, &volume, &emit);
        for rsm in &rsms {
            from_rsm(cx, &frame, rsm, &volume, &uniforms, &buffers)?;
        }
        if is_straight && surfels.is_emissive() {
            from_surfels(cx, "from_emissive", surfels.count(), &uniforms, &buffers, None)?;
        }
        if is_white {
            from_surfels(cx, "from_white", surfels.count(), &uniforms, &buffers, None)?;
        }
        if buffers.received.is_some() {
            from_surfels(cx, "from_bounce", surfels.count(), &uniforms, &buffers, buffers.received)?;
        }
        finish(cx, &volume, &directions, &uniforms, &buffers)?;
        if buffers.is_exposed { keep_brightest(cx, &uniforms, &buffers) } else { Ok(()) }
    });
}

struct Buffers {
    surfels: Handle<Buffer>,
    obstacles: Obstacles,
    received: Option<Handle<Buffer>>,
    /// What media take and send out of the lights' light.
    lamp_light: Option<Handle<Buffer>>,
    /// Whether light comes straight from the lights.
    is_straight: bool,
    sums: Handle<Buffer>,
    emission: Handle<Buffer>,
    /// Whether the brightest source is asked for.
    is_exposed: bool,
    /// Emission of the next coarser cascade, where it is.
    outer: Option<Handle<Buffer>>,
    totals: Option<Handle<Buffer>>,
}

struct Uniforms {
    volume: wgpu::Buffer,
    emit: wgpu::Buffer,
}

impl Uniforms {
    fn new(gpu: &Gpu, volume: &Volume, emit: &EmitUniform) -> Self {
        Self { volume: gpu.uniform("volume", &volume.uniform()), emit: gpu.uniform("emit", emit) }
    }
}

fn from_rsm(
    cx: &mut PassContext,
    frame: &Frame,
    rsm: &Rsm,
    volume: &Volume,
    uniforms: &Uniforms,
    buffers: &Buffers,
) -> Result<(), PassError> {
    let handles = [buffers.obstacles.opacity, buffers.obstacles.coverage, buffers.sums];
    let [opacity, coverage, sums] = handles.map(|handle| cx.buffer(handle).clone());
    cx.counts().lights += 1;
    let media = frame.gpu_scene.media_binding(cx.gpu);
    let mut more = vec![
        ("emit", Binding::Buffer(&uniforms.emit)),
        ("opacity", Binding::Buffer(&opacity)),
        ("coverage", Binding::Buffer(&coverage)),
        ("sums", Binding::Buffer(&sums)),
    ];
    more.extend(media.iter().map(|(name, media)| (*name, Binding::Buffer(media))));
    let key = ComputeKey::new("indirect/light_volumes/sweep/emit.wgsl", "from_rsm");
    let key = frame.gpu_scene.with_media(key);
    dispatch_rsm(cx, &key, rsm, 0..rsm.views.len(), volume, 1.0, &more)
}

fn from_surfels(
    cx: &mut PassContext,
    entry: &'static str,
    count: u32,
    uniforms: &Uniforms,
    buffers: &Buffers,
    received: Option<Handle<Buffer>>,
) -> Result<(), PassError> {
    let handles = [buffers.surfels, buffers.obstacles.links, buffers.sums];
    let [surfels, links, sums] = handles.map(|handle| cx.buffer(handle).clone());
    let received = received.map(|handle| cx.buffer(handle).clone());
    let mut bindings = vec![
        ("volume", Binding::Buffer(&uniforms.volume)),
        ("emit", Binding::Buffer(&uniforms.emit)),
        ("surfels", Binding::Buffer(&surfels)),
        ("links", Binding::Buffer(&links)),
        ("sums", Binding::Buffer(&sums)),
    ];
    bindings.extend(received.iter().map(|received| ("received", Binding::Buffer(received))));
    cx.counts().injections += u64::from(count);
    cx.dispatch(&ComputeKey::new("indirect/light_volumes/sweep/emit.wgsl", entry), &bindings, linear_groups(count))
}

fn finish(
    cx: &mut PassContext,
    volume: &Volume,
    directions: &Directions,
    uniforms: &Uniforms,
    buffers: &Buffers,
) -> Result<(), PassError> {
    let set = cx.gpu.constants("directions", &directions.values);
    let [sums, emission] = [buffers.sums, buffers.emission].map(|h| cx.buffer(h).clone());
    let totals = buffers.totals.map(|handle| cx.buffer(handle).clone());
    let mut key = ComputeKey::new("indirect/light_volumes/sweep/emit.wgsl", "finish");
    let mut bindings = vec![
        ("volume", Binding::Buffer(&uniforms.volume)),
        ("emit", Binding::Buffer(&uniforms.emit)),
        ("directions", Binding::Buffer(&set)),
        ("sums", Binding::Buffer(&sums)),
        ("emission", Binding::Buffer(&emission)),
    ];
    if buffers.is_exposed {
        key = key.def("EXPOSED", ShaderDef::Flag(true));
    }
    let lamp_light = buffers.lamp_light.map(|handle| cx.buffer(handle).clone());
    if let Some(lamp_light) = &lamp_light {
        key = key.def("HAZE", ShaderDef::Flag(true));
        if buffers.is_straight {
            key = key.def("SCATTERED", ShaderDef::Flag(true));
        }
        bindings.push(("lamp_light", Binding::Buffer(lamp_light)));
    }
    if let Some(totals) = &totals {
        key = key.def("COUNTED", ShaderDef::Flag(true));
        bindings.push(("totals", Binding::Buffer(totals)));
    }
    cx.counts().cells += u64::from(volume.cell_count());
    cx.dispatch(&key, &bindings, linear_groups(volume.cell_count()))
}

/// Leaves the brightest source of this cascade and the coarser ones behind the emission.
fn keep_brightest(cx: &mut PassContext, uniforms: &Uniforms, buffers: &Buffers) -> Result<(), PassError> {
    let [sums, emission] = [buffers.sums, buffers.emission].map(|h| cx.buffer(h).clone());
    let outer = buffers.outer.map(|handle| cx.buffer(handle).clone());
    let mut key = ComputeKey::new("indirect/light_volumes/sweep/emit.wgsl", "keep_brightest");
    let mut bindings = vec![
        ("volume", Binding::Buffer(&uniforms.volume)),
        ("sums", Binding::Buffer(&sums)),
        ("emission", Binding::Buffer(&emission)),
    ];
    match &outer {
        Some(outer) => bindings.push(("outer_emission", Binding::Buffer(outer))),
        None => key = key.def("NO_OUTER", ShaderDef::Flag(true)),
    }
    cx.dispatch(&key, &bindings, [1, 1, 1])
}
