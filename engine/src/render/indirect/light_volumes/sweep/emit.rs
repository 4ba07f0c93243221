//! The sources of a bounce: what each cell sends out.

use super::directions::Directions;
use super::{Level, Light};
use crate::gpu::ComputeKey;
use crate::graph::{Buffer, BufferDesc, Counts, Graph, Handle, Step as Dispatch};
use crate::render::frame::Frame;
use crate::render::indirect::light_volumes::texels;
use crate::render::indirect::light_volumes::volume::Volume;
use crate::render::scene_gpu::light_uniform::LightUniform;
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
    let in_cells = |point: Vec3| (point - volume.origin) / volume.cell;
    let sky = if is_coarsest && is_straight { sky_flux(frame, &volume) } else { Vec3::ZERO };
    let emit = EmitUniform {
        scale,
        bounce: step.bounce,
        padding: UVec2::ZERO,
        sky: sky * scale,
        inner_low: inner.map_or(Vec3::ZERO, |inner| in_cells(inner.bounds().min).round()),
        inner_high: inner.map_or(Vec3::ZERO, |inner| in_cells(inner.bounds().max).round()),
    };
    let obstacles = level.obstacles;
    let mut pass = graph.compute(name, ComputeKey::new("indirect/light_volumes/sweep/emit.wgsl", "finish"));
    pass.uniform("volume", &volume.uniform());
    pass.uniform("emit", &emit);
    pass.read("surfels", sources.surfels);
    pass.read("opacity", obstacles.opacity);
    pass.read("coverage", obstacles.coverage);
    pass.read("links", obstacles.links);
    let sums = pass.write("sums", sums);
    level.emission = pass.write("emission", level.emission);
    let totals = totals.filter(|_| is_coarsest).map(|totals| {
        *totals = pass.write_in_steps(*totals);
        *totals
    });
    pass.clear(sums);
    if is_straight {
        for rsm in sources.rsms {
            pass.count(Counts { lights: 1, ..Counts::default() });
            let media = |step: &mut Dispatch<'_, '_, 'a>| frame.gpu_scene.bind_media(step);
            texels::declare_steps(
                &mut pass,
                "from_rsm",
                (rsm, 0..rsm.views.len()),
                (1.0, LightUniform::new(rsm.light)),
                media,
            );
        }
    }
    let from_surfels = [
        ("from_emissive", is_straight && frame.surfels.is_emissive()),
        ("from_white", is_white),
        ("from_bounce", received.is_some()),
    ];
    for (entry, _) in from_surfels.into_iter().filter(|(_, sends)| *sends) {
        let mut step = pass.step(entry);
        if let Some(received) = received.filter(|_| entry == "from_bounce") {
            step.read("received", received);
        }
        step.count(Counts { injections: sources.count.into(), ..Counts::default() });
        step.over_items(sources.count);
    }
    let mut finish = pass.step("finish");
    finish.values("directions", &directions.values);
    finish.flag("EXPOSED", is_exposed);
    if let Some(lamp_light) = level.lamp_light.filter(|_| !is_white) {
        finish.flag("HAZE", true);
        finish.flag("SCATTERED", is_straight);
        finish.read("lamp_light", lamp_light);
    }
    if let Some(totals) = totals {
        finish.flag("COUNTED", true);
        finish.read("totals", totals);
    }
    finish.count(Counts { cells: volume.cell_count().into(), ..Counts::default() });
    finish.over_items(volume.cell_count());
    if is_exposed {
        // Leaves the brightest source of this cascade and the coarser ones behind the emission.
        let mut brightest = pass.step("keep_brightest");
        match outer {
            Some(outer) => brightest.read("outer_emission", outer),
            None => brightest.flag("NO_OUTER", true),
        }
        brightest.in_groups([1, 1, 1]);
    }
    pass.finish();
}
