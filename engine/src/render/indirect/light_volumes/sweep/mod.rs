//! The sweep transport: directions kept, light swept once through the grid for each (discrete ordinates).
//!
//! ```text
//! the scene's surfaces:  walls ──┬── opacity ─── white (emit, sweep, receive)
//!            surfels ────────────┴── links            │
//! its light: rsm (a light) ── emit ── sweep ── relight, probes, blended surfaces
//!                 ├── radiosity ┘
//!                 └── RSM samples, light of patches ── gather
//! ```
//! Surfaces are surfels spread over the scene's meshes. They stop light (`opacity`, with what closes whole faces of cells,
//! `walls`), and from the second bounce on they are its sources; those of the first are the texels of reflective shadow maps,
//! whose flux is exact, and emissive surfels. `links` tells which cells a surfel has to do with. All lengths in the shaders are
//! in cells.
//!
//! What the surfels send out is known from `radiosity` beside it, so that one sweep is enough. A scene that is too
//! large for rays has all bounces swept instead: `white` is then what a surfel has of light that is even everywhere, by which
//! all other is calibrated, and where the grid is fine, all bounces but the last are swept in a coarser one (`further`).

mod bounce_sum;
mod coverage;
mod directions;
mod emit;
mod further;
pub(in crate::render) mod gather;
mod gather_filter;
mod gather_shift;
mod gather_upsample;
mod grid;
pub(in crate::render) mod haze_cells;
mod interleave;
mod irradiance;
mod lamp_light;
mod links;
mod march;
pub(in crate::render) mod mirror;
pub(in crate::render) mod mirror_filter;
mod opacity;
mod probes;
mod rsm_samples;
mod shell;
pub(in crate::render) mod sky;
mod strays;
pub(super) mod surfels;
mod transport;

pub use grid::volumes;

#[cfg(test)]
pub(crate) use self::{
    bounce_sum::SumUniform,
    emit::EmitUniform,
    gather::GatherUniform,
    gather_filter::ReachUniform,
    gather_shift::ShiftUniform,
    gather_upsample::UpsampleUniform,
    irradiance::LookupUniform,
    march::{CollectUniform, MarchUniform},
    mirror::MirrorUniform,
    mirror_filter::MirrorFilterUniform,
};

use super::volume::Volume;
use super::{Indirect, radiosity};
use crate::graph::{Buffer, Graph, Handle, Texture};
use crate::render::RenderError;
use crate::render::frame::Frame;
use crate::render::geometry::gbuffer::{self, GBuffer};
use crate::render::indirect::{Scattered, sky_reflection};
use crate::render::rays::mirror_define;
use crate::render::shadows::reflective::{self, Rsm};
use crate::scene::{Aabb, SceneClpv, SceneLight};
use crate::world::{Bounces, Clpv, Precision, Quality, Transport};
use directions::Directions;
use gather_shift::Seen;
use glam::Vec3;
pub(crate) use haze_cells::HazeCells;
use interleave::Interleave;
use opacity::Obstacles;
use transport::{Kept, Sky};

pub(crate) use probes::{PROBE_LIGHT, probe_light};

/// Texels of a reflective shadow map along the edge of a cell: fewer leave some cells with more light than others.
const TEXELS_A_CELL: f32 = 3.0;

/// Share of the light that may be left when the geometric series takes over.
const TAIL: f32 = 0.1;

/// A cascade with what is in it so far.
struct Level {
    /// The cascade's part in the names of its passes and resources.
    name: String,
    volume: Volume,
    /// Precision of radiance in flight.
    precision: Precision,
    obstacles: Obstacles,
    emission: Handle<Buffer>,
    /// Light straight from the lights in its cells, where there are media to scatter it.
    lamp_light: Option<Handle<Buffer>>,
    /// Irradiance of the bounce that is under way.
    bounce: Irradiance,
    /// Irradiance of all bounces, where several are swept and it is asked for.
    sum: Option<Irradiance>,
    /// Light of the bounce under way that enters from the next coarser cascade, by axis.
    shell: Option<[Handle<Buffer>; 3]>,
}

impl Level {
    /// Irradiance of all that was swept.
    fn light(&self) -> Irradiance {
        self.sum.unwrap_or(self.bounce)
    }
}

/// Irradiance by cell and normal, see `indirect/light_volumes/sweep/transport.wgsl`.
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
    let shown = Seen { frame, gbuffer };
    let is_gathered = gather::is_possible(graph, frame, settings);
    // Everything but what is seen at the frame's own pixels belongs to the image that is gathered.
    let gathering = frame.gathering().filter(|_| is_gathered);
    let frame = gathering.as_ref().unwrap_or(frame);
    let quality = quality(frame, settings);
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
    let names: Vec<String> = (0..volumes.len()).map(|index| format!("cascade {index}")).collect();
    let lamp_light: Vec<_> =
        names.iter().zip(&volumes).map(|(name, volume)| lamp_light::declare(graph, frame, name, volume)).collect();
    let cells_of_lamps = volumes.last().zip(lamp_light.last().copied().flatten());
    let cells_of_lamps =
        cells_of_lamps.map(|(volume, light)| HazeCells { volume: *volume, light, are_lamps_alone: true });
    let radiosity = radiosity::declare(graph, frame, settings, surfels, cells_of_lamps);
    let bounces = bounces(settings, cloud.mean_albedo(), is_gathered);
    let is_swept_at_once = radiosity.is_some() || bounces.swept == 1;
    let coarser = grid::of_further_bounces(clpv, quality, &frame.bounds, &volumes).filter(|_| !is_swept_at_once);
    let kept = if is_swept_at_once || coarser.is_some() { Kept::OneSweep } else { Kept::Sum };
    let mut levels: Vec<Level> = Vec::with_capacity(volumes.len());
    for ((name, volume), lamp_light) in names.iter().zip(&volumes).zip(lamp_light) {
        let level = level(graph, frame, surfels, name, volume, settings.precision, kept);
        levels.push(Level { lamp_light, ..level });
    }
    let scale = emit::scale(frame, &rsms, &levels);
    let source = emit::Sources { rsms: &rsms, surfels, count: cloud.count(), scale };
    let work = Work { frame, source };
    let [straight, further] = &directions;
    let once = BounceCount { swept: 1, has_tail: false };
    match (radiosity, coarser) {
        // What the surfaces send out is known.
        (Some(radiosity), _) => {
            let light = Light::Scene(Some(radiosity.surfels));
            work.sweep(graph, &mut levels, None, Bounce { number: 0, of: once, directions: straight, light });
        }
        // All bounces but the last are swept in the coarser grid, and tell what the surfaces send out.
        (None, Some(volume)) => {
            let before = BounceCount { swept: bounces.swept - 1, ..bounces };
            let (name, precision) = ("further bounces", settings.precision);
            let lamp_light = lamp_light::declare(graph, frame, name, &volume);
            let level = level(graph, frame, surfels, name, &volume, precision, Kept::Nothing);
            let level = Level { lamp_light, ..level };
            let received = further::declare(graph, &work, level, before, further);
            let bounce = Bounce { number: 0, of: once, directions: straight, light: Light::Scene(Some(received)) };
            work.sweep(graph, &mut levels, None, bounce);
        }
        (None, None) => work.sweep_all(graph, &mut levels, bounces, [straight, further]),
    }
    let haze = levels.last().and_then(|level| {
        let light = level.light().axes;
        level.lamp_light.map(|lamps| haze_cells::declare(graph, &level.volume, lamps, light))
    });
    let ends_in_patches = is_gathered && !gather::are_paths(settings);
    let patches = radiosity.map(|light| light.patches).filter(|_| ends_in_patches);
    let scattered = Scattered { patches, haze };
    let mut mirrored = None;
    let radiance = if is_gathered {
        let interleave = Interleave::new(frame, patches.is_some());
        mirrored = declare_mirrors(graph, shown, settings, scattered, interleave);
        let lit = rsm_samples::declare(graph, frame, &rsms, (reach, scale), gather::points(settings, interleave));
        let gbuffer = gathering.as_ref().map(|frame| gbuffer::declare_as(graph, frame, "gathered "));
        let gathered_at = Seen { frame, gbuffer: gbuffer.as_ref().unwrap_or(shown.gbuffer) };
        let shown = gathering.as_ref().map(|_| shown);
        gather::declare(graph, gathered_at, shown, settings, (patches, haze), lit, interleave)
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
        .filter(|_| !is_gathered && sky_reflection::is_mirrored(frame.scene))
        .map(|level| (level.obstacles, level.volume));
    let sky = sky.map(|(obstacles, volume)| sky::field_of(&sky::level(graph, frame, obstacles, &volume)));
    let change = radiosity.filter(|_| ends_in_patches).and_then(|light| light.change);
    let indirect = |level: &Level| Indirect {
        radiance,
        mirrored,
        is_glossy: is_gathered,
        field: sky::field_of(level),
        sky,
        scattered,
        change,
    };
    Ok(levels.last().map(indirect))
}

/// Declares the rays of mirrors, where there are any.
fn declare_mirrors<'a>(
    graph: &mut Graph<'a>,
    Seen { frame, gbuffer }: Seen<'_, 'a>,
    settings: &Clpv,
    light: Scattered,
    interleave: Interleave,
) -> Option<Handle<Texture>> {
    match frame.rays.zip(mirror::rays(frame, settings, interleave.is_sparse())) {
        Some((scene, rays)) => {
            let mirrors = mirror::Mirrors { scene, rays, define: mirror_define(mirror::are_smooth(frame)) };
            let mirrored = mirror::declare(graph, frame, gbuffer, light, mirrors);
            Some(mirror_filter::declare(graph, frame, gbuffer, mirrored))
        }
        None => {
            graph.skip("mirror", "no surface is smooth enough, or the settings leave mirrors to the gather");
            None
        }
    }
}

/// The quality of the sweep of these settings in a frame.
pub(in crate::render) fn quality(frame: &Frame, settings: &Clpv) -> Quality {
    gather::quality_of_volumes(settings, gather::is_wanted(settings) && frame.refused_rays.is_none())
}

/// Whether light is swept along other directions in each of the frames that are averaged.
pub(in crate::render) fn varies(settings: &Clpv) -> bool {
    settings.transport == Transport::Sweep && settings.vary_directions
}

/// An empty cascade, with what stops light in it.
fn level<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    surfels: Handle<Buffer>,
    name: &str,
    volume: &Volume,
    precision: Precision,
    kept: Kept,
) -> Level {
    let obstacles = opacity::declare(graph, frame, surfels, name, volume);
    transport::level(graph, obstacles, name, volume, precision, kept)
}

/// Shared inputs of all sweeps of a frame.
struct Work<'f, 'a> {
    frame: &'f Frame<'a>,
    source: emit::Sources<'f, 'a>,
}

/// A bounce to be swept.
#[derive(Clone, Copy)]
struct Bounce<'d> {
    /// 0: light straight from the lights.
    number: u32,
    of: BounceCount,
    directions: &'d Directions,
    light: Light,
}

/// The light that surfaces send out.
#[derive(Clone, Copy)]
enum Light {
    /// Radiance 1 from all of them, and from the sky.
    White,
    /// Of the scene: straight from the lights, if it is the first bounce, and what they reflect of this irradiance \[W/m²\].
    Scene(Option<Handle<Buffer>>),
}

impl<'a> Work<'_, 'a> {
    /// Declares the sweeps of all bounces through all cascades. The directions are those of light that comes straight from
    /// the lights, and of all further bounces.
    fn sweep_all(
        &self,
        graph: &mut Graph<'a>,
        levels: &mut [Level],
        bounces: BounceCount,
        [straight, further]: [&Directions; 2],
    ) {
        let mut totals = emit::totals(graph, bounces.swept);
        let white = self.white(graph, levels, further);
        let first = Bounce { number: 0, of: bounces, directions: straight, light: Light::Scene(None) };
        self.sweep(graph, levels, Some(&mut totals), first);
        for number in 1..bounces.swept {
            let received = irradiance::at_surfels(graph, &self.source, levels, &bounce_name(number), Some(white));
            let light = Light::Scene(Some(received));
            self.sweep(graph, levels, Some(&mut totals), Bounce { number, of: bounces, directions: further, light });
        }
    }

    /// Declares the sweep of one bounce through all cascades.
    fn sweep(
        &self,
        graph: &mut Graph<'a>,
        levels: &mut [Level],
        mut totals: Option<&mut Handle<Buffer>>,
        Bounce { number: bounce, of: bounces, directions, light }: Bounce<'_>,
    ) {
        for index in (0..levels.len()).rev() {
            let step = emit::Step { index, bounce, light };
            emit::declare(graph, self.frame, &self.source, directions, levels, totals.as_deref_mut(), step);
            let sky = match light {
                Light::White => Sky::White,
                Light::Scene(_) if bounce == 0 => Sky::Scene,
                Light::Scene(_) => Sky::Dark,
            };
            let step = transport::Step { index, bounce, bounces };
            transport::declare(graph, self.frame, directions, levels, totals.as_deref().copied(), sky, step);
        }
    }

    /// Declares what the surfels have where all surfaces and the sky are white. Each light that is swept to them is held
    /// against it, see `indirect/light_volumes/sweep/irradiance.wgsl`. It depends on the scene's surfaces alone.
    fn white(&self, graph: &mut Graph<'a>, levels: &[Level], directions: &Directions) -> Handle<Buffer> {
        let white = |level: &Level| {
            let name = format!("white, {}", level.name);
            transport::level(graph, level.obstacles, &name, &level.volume, level.precision, Kept::Nothing)
        };
        let mut levels: Vec<Level> = levels.iter().map(white).collect();
        let once = BounceCount { swept: 1, has_tail: false };
        self.sweep(graph, &mut levels, None, Bounce { number: 0, of: once, directions, light: Light::White });
        irradiance::at_surfels(graph, &self.source, &levels, "white", None)
    }
}

/// A bounce's part in the names of its passes.
fn bounce_name(number: u32) -> String {
    format!("bounce {number}")
}

/// The directions that light is swept along when it comes straight from the lights.
pub fn directions(quality: Quality) -> Vec<Vec3> {
    Directions::of(quality).values.iter().map(|&[x, y, z, _]| Vec3::new(x, y, z)).collect()
}

/// The maps of all lights, with texels small enough for the finest cells.
fn rsms<'a>(graph: &mut Graph<'a>, frame: &Frame<'a>, volumes: &[Volume], reach: &Aabb) -> Vec<Rsm<'a>> {
    let spacing = volumes.first().map_or(1.0, |volume| volume.cell / TEXELS_A_CELL);
    let declare = |(light, index): (&'a SceneLight, u32)| {
        let size = reflective::size_for_spacing(light, &frame.bounds, spacing);
        reflective::declare_sized(graph, frame, light, index, reach, size)
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
            BounceCount {
                swept: count.saturating_sub(u32::from(is_gathered)).clamp(1, super::MAX_BOUNCES),
                has_tail: false,
            }
        }
        Bounces::Converged => {
            let albedo = mean_albedo.max_element().clamp(0.01, 0.99);
            let swept = (TAIL.ln() / albedo.ln()).ceil() as u32;
            BounceCount { swept: swept.clamp(3, 8), has_tail: true }
        }
    }
}
