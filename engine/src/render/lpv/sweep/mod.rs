//! The sweep transport: directions kept, light swept once through the grid for each (discrete ordinates).
//!
//! ```text
//! surfels ── opacity (a cascade) ──────────────┐
//! rsm (a light) ── emit (a cascade) ── sweep (a cascade) ── reflect ── emit ── sweep ── … ── relight, or gather
//! ```
//! Surfaces are surfels spread over the scene's meshes. They stop light (`opacity`), and from the second bounce on
//! they are its sources; those of the first are the texels of reflective shadow maps, whose flux is exact, and
//! emissive surfels. All lengths in the shaders are in cells.

mod balance;
mod directions;
mod emit;
pub(in crate::render) mod gather;
mod gather_filter;
mod grid;
mod irradiance;
mod opacity;
mod probes;
pub(in crate::render) mod sky;
mod surfels;
mod transport;
mod walls;

pub use grid::volumes;

#[cfg(test)]
pub(crate) use self::{
    balance::BalanceUniform, emit::EmitUniform, gather::GatherUniform, irradiance::LookupUniform,
    transport::SliceUniform, transport::SumUniform,
};

use super::Indirect;
use super::volume::Volume;
use crate::graph::{Buffer, Graph, Handle};
use crate::render::RenderError;
use crate::render::frame::Frame;
use crate::render::gbuffer::GBuffer;
use crate::render::rsm::{self, Rsm};
use crate::render::sky_light;
use crate::scene::{Aabb, SceneClpv, SceneLight};
use crate::world::{Bounces, Clpv, Quality, Transport};
use directions::Directions;
use glam::Vec3;

pub(crate) use probes::{PROBE_LIGHT, probe_light};
pub use surfels::GpuSurfels;

/// Most bounces that a `Count` may ask for.
pub const MAX_BOUNCES: u32 = 32;

/// Texels of a reflective shadow map along the edge of a cell: fewer leave some cells with more light than others.
const TEXELS_A_CELL: f32 = 3.0;

/// Share of the light that may be left when the geometric series takes over.
const TAIL: f32 = 0.1;

/// A cascade with what is in it so far.
struct Level {
    /// What the names of its passes and resources have for it.
    name: String,
    volume: Volume,
    opacity: Handle<Buffer>,
    emission: Handle<Buffer>,
    /// Irradiance of the bounce that is under way.
    bounce: Irradiance,
    /// Irradiance of all bounces.
    sum: Irradiance,
    /// Light of the bounce under way that enters from the next coarser cascade, by axis.
    shell: Option<[Handle<Buffer>; 3]>,
}

/// Irradiance by cell and normal, see `lpv/sweep/transport.wgsl`.
#[derive(Clone, Copy)]
struct Irradiance {
    axes: Handle<Buffer>,
    facing: Handle<Buffer>,
}

/// Declares all passes. None, with the reason in the report, if there is no light.
///
/// # Errors
/// Settings that make no volume.
pub(super) fn declare<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    gbuffer: &GBuffer,
    clpv: &'a SceneClpv,
) -> Result<Option<Indirect>, RenderError> {
    let settings = &clpv.settings;
    let quality = frame.sweep_quality(settings);
    let volumes = volumes(clpv, quality, &frame.bounds, frame.view)?;
    let reach = volumes.iter().fold(Aabb::EMPTY, |reach, volume| reach.union(&volume.bounds()));
    let rsms = rsms(graph, frame, &volumes, &reach);
    let cloud = frame.surfels;
    if rsms.is_empty() && !cloud.is_emissive() && frame.scene.sky == Vec3::ZERO {
        graph.skip("clpv", "no light feeds indirect light");
        return Ok(None);
    }
    let directions = [Directions::of(quality), Directions::of_further_bounces(quality)];
    let directions = match frame.number().filter(|_| varies(settings)) {
        Some(number) => directions.map(|set| set.varied(number)),
        None => directions,
    };
    let surfels = surfels::declare(graph, frame);
    let is_gathered = gather::is_possible(graph, frame, settings);
    let bounces = bounces(settings, cloud.mean_albedo(), is_gathered);
    let mut totals = emit::totals(graph, bounces.swept);
    let mut levels: Vec<Level> = Vec::with_capacity(volumes.len());
    for (index, volume) in volumes.iter().enumerate() {
        let name = format!("cascade {index}");
        let opacity = opacity::declare(graph, frame, surfels, &name, volume);
        levels.push(transport::level(graph, opacity, &name, volume));
    }
    let source =
        emit::Sources { rsms: &rsms, surfels, count: cloud.count(), scale: emit::scale(frame, &rsms, &levels) };
    for bounce in 0..bounces.swept {
        let received = (bounce > 0).then(|| received(graph, &source, &levels, bounce - 1));
        for index in (0..levels.len()).rev() {
            let directions = &directions[usize::from(bounce > 0)];
            let step = emit::Step { index, bounce, received };
            emit::declare(graph, frame, &source, directions, &mut levels, &mut totals, step);
            transport::declare(
                graph,
                frame,
                directions,
                &mut levels,
                totals,
                transport::Step { index, bounce, bounces },
            );
        }
    }
    let radiance = if is_gathered {
        let swept = levels.last().filter(|_| settings.bounces != Bounces::Count(1));
        gather::declare(graph, frame, gbuffer, settings, swept)
    } else {
        let names = irradiance::Names { pass: "relight", image: "indirect radiance" };
        irradiance::relight(graph, frame, gbuffer, names, settings.border_fade.max(0.0), &levels)
    };
    if !frame.probes.is_empty() {
        let light = probes::declare(graph, frame, &levels);
        graph.output(light);
    }
    let sky = levels
        .last()
        .filter(|_| !is_gathered && sky_light::is_mirrored(frame.scene))
        .map(|level| (level.opacity, level.volume));
    let sky = sky.map(|(opacity, volume)| sky::field_of(&sky::level(graph, frame, opacity, &volume)));
    Ok(levels.last().map(|level| Indirect { radiance, is_glossy: is_gathered, field: sky::field_of(level), sky }))
}

/// Whether light is swept along other directions in each of the frames that are averaged.
pub(in crate::render) fn varies(settings: &Clpv) -> bool {
    settings.transport == Transport::Sweep && settings.vary_directions
}

/// What the surfels have of a bounce.
fn received<'a>(
    graph: &mut Graph<'a>,
    source: &emit::Sources<'_, 'a>,
    levels: &[Level],
    bounce: u32,
) -> emit::Received {
    let irradiance = irradiance::at_surfels(graph, source, levels, bounce);
    let whole = &levels[levels.len() - 1];
    let shares = balance::declare(graph, source, whole, irradiance, bounce);
    emit::Received { irradiance, shares, balance: balance::BalanceUniform::new(&whole.volume, source.scale) }
}

/// The directions that light is swept along when it comes straight from the lights.
pub fn directions(quality: Quality) -> Vec<Vec3> {
    Directions::of(quality).values.iter().map(|&[x, y, z, _]| Vec3::new(x, y, z)).collect()
}

/// The maps of all lights, with texels small enough for the finest cells.
fn rsms<'a>(graph: &mut Graph<'a>, frame: &Frame<'a>, volumes: &[Volume], reach: &Aabb) -> Vec<Rsm<'a>> {
    let spacing = volumes.first().map_or(1.0, |volume| volume.cell / TEXELS_A_CELL);
    let declare = |(light, index): (&'a SceneLight, u32)| {
        let size = rsm::size_for_spacing(light, &frame.bounds, spacing);
        rsm::declare_sized(graph, frame, light, index, reach, size)
    };
    frame.scene.lights.iter().zip(0..).filter_map(declare).collect()
}

/// How many bounces are swept, and whether the rest is a series.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct BounceCount {
    swept: u32,
    has_tail: bool,
}

/// The scene's mean reflectance bounds what is left after each bounce.
fn bounces(settings: &Clpv, mean_albedo: Vec3, is_gathered: bool) -> BounceCount {
    match settings.bounces {
        Bounces::Count(count) => {
            // The gather is a bounce itself. What is swept lights blended surfaces even where it is all there is.
            BounceCount { swept: count.saturating_sub(u32::from(is_gathered)).clamp(1, MAX_BOUNCES), has_tail: false }
        }
        Bounces::Converged => {
            let albedo = mean_albedo.max_element().clamp(0.01, 0.99);
            let swept = (TAIL.ln() / albedo.ln()).ceil() as u32;
            BounceCount { swept: swept.clamp(3, 8), has_tail: true }
        }
    }
}
