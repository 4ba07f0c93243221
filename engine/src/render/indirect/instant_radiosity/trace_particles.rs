//! Shoots particles from the lights and leaves virtual lights where they hit (Keller 1997, section 3).

use super::intersection::{Caster, IntersectionCounts};
use super::random::{Numbers, cosine_direction, hash_pair};
use super::schedule::{Plan, deal, mean_reflectance};
use super::source::{Glow, Source, Start};
use super::surface::{Met, meet};
use crate::assets::parallel;
use crate::bvh::Ray;
use crate::scene::Scene;
use crate::scene::SceneBvh;
use crate::world::{InstantRadiosity, ParticleBounce, VirtualShading};
use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use std::collections::HashMap;
use std::f32::consts::PI;

/// A surface.
pub const SURFACE: u32 = 0;
/// Parallel light from far away.
pub const DISTANT: u32 = 1;

/// A virtual light as `VirtualLight` of `lib/vpl.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct VirtualLight {
    /// World position \[m\]; for distant light the unit direction towards it.
    pub place: [f32; 3],
    /// `SURFACE` or `DISTANT`.
    pub kind: u32,
    /// Unit normal of the surface.
    pub normal: [f32; 3],
    /// d_min \[m\].
    pub nearest: f32,
    /// Intensity along the normal Φ/π [W/sr]; of distant light the irradiance across it [W/m²].
    pub intensity: [f32; 3],
    /// How far a ray must end before the surface \[m\].
    pub offset: f32,
    /// Flux that arrives, over the number of particles \[W\]; for glossy surfaces.
    pub flux: [f32; 3],
    /// Roughness and F90 in 65535ths; 0: no glossy surface.
    pub gloss: u32,
    /// Unit direction that the flux comes from, octahedral, in 32767ths.
    pub incident: u32,
    /// √F0, ten bits a channel.
    pub specular: u32,
    /// d_min of the lights at the next hits of the same source \[m\]; 0: there are none.
    pub next: f32,
    /// Nothing.
    pub padding: u32,
}

/// Results of tracing particles.
#[derive(Clone, Debug, Default)]
pub struct Particles {
    /// The lights, by source, then by the number of the hit.
    pub lights: Vec<VirtualLight>,
    /// Ways of the particles: start and hits of each \[m\], the first [`MAX_PATHS`] of every source.
    pub paths: Vec<Vec<Vec3>>,
    /// Particles shot.
    pub shot: u64,
    /// Intersection tests.
    pub casts: IntersectionCounts,
    /// Mean reflectance ρ of the scene.
    pub reflectance: f64,
    /// d_min of the lights at the first hits of each light of the scene \[m\]; 0 where there are none.
    pub nearest: Vec<f32>,
    /// d_min of the lights on surfaces that emit \[m\].
    pub nearest_glow: f32,
}

/// Ways that are remembered of a source, to be drawn.
pub const MAX_PATHS: u32 = 1024;
/// Particles of one piece of parallel work.
const PIECE: u32 = 64;

/// The sources with their plans, known before any particle is shot.
pub(super) struct Setup<'a> {
    sources: Vec<(Source<'a>, Plan)>,
    pub(super) reflectance: f64,
}

impl<'a> Setup<'a> {
    pub(super) fn new(
        scene: &'a Scene,
        bvh: &'a SceneBvh,
        settings: &InstantRadiosity,
        colors: &mut HashMap<crate::assets::AssetId, Vec3>,
    ) -> Self {
        let mut all = Source::all(scene, bvh);
        if settings.shading == VirtualShading::AsPublished {
            all.retain(|(source, _)| !source.glows());
        }
        let flux: Vec<f64> = all.iter().map(|(_, flux)| *flux).collect();
        let reflectance = mean_reflectance(scene, colors);
        let plan = |particles: u32, source: &Source| {
            Plan::new(particles, reflectance, settings.schedule, settings.bounces, source.glows())
        };
        let shares = deal(settings.particles.saturating_mul(candidates(settings)), &flux);
        let sources = all.into_iter().zip(shares).map(|((source, _), share)| {
            let plan = plan(share, &source);
            (source, plan)
        });
        Self { sources: sources.collect(), reflectance }
    }

    /// Most lights that the particles can leave.
    pub(super) fn capacity(&self) -> u64 {
        let glow = |source: &Source, plan: &Plan| if source.glows() { u64::from(plan.particles) } else { 0 };
        self.sources.iter().map(|(source, plan)| glow(source, plan) + plan.hits()).sum()
    }
}

/// Lights to choose from for each that is kept. The report's formulas are for all that is shot.
pub(super) fn candidates(settings: &InstantRadiosity) -> u32 {
    if settings.shading == VirtualShading::AsPublished { 1 } else { settings.candidates.max(1) }
}

/// A light that a particle left.
#[derive(Clone, Copy)]
pub(super) struct Candidate {
    /// Its source in [`Shot::origins`].
    pub(super) source: u32,
    /// The hit of the particle, counted from 1; 0: where it started.
    pub(super) hit: u32,
    pub(super) light: VirtualLight,
    /// Area of surface that the light stands for \[m²\].
    pub(super) area: f32,
    /// All that it sends out, the mean of the channels \[W\]; of distant light the irradiance across it [W/m²].
    pub(super) power: f32,
}

/// The origin of virtual lights.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Origin {
    /// Index of a light of the scene.
    Light(usize),
    /// Surfaces that emit.
    Emitters,
    Sky,
}

/// Results of all particles.
#[derive(Default)]
pub(super) struct Shot {
    /// By source, and in the order of the particles.
    pub(super) candidates: Vec<Candidate>,
    pub(super) origins: Vec<Origin>,
    pub(super) paths: Vec<Vec<Vec3>>,
    pub(super) shot: u64,
    pub(super) casts: IntersectionCounts,
    pub(super) reflectance: f64,
}

/// Results of one part of the work.
#[derive(Default)]
struct Piece {
    lights: Vec<Candidate>,
    paths: Vec<Vec<Vec3>>,
    shot: u64,
    casts: IntersectionCounts,
}

/// Shoots all particles. Equal input gives equal bits, on however many cores.
pub(super) fn simulate(scene: &Scene, bvh: &SceneBvh, settings: &InstantRadiosity, setup: &Setup) -> Shot {
    let caster = Caster::new(scene, bvh, settings.casts);
    let mut shot = Shot { reflectance: setup.reflectance, ..Default::default() };
    for ((source, plan), index) in setup.sources.iter().zip(0..) {
        let seed = hash_pair(settings.seed, index);
        let shooter = Shooter { scene, bvh, caster: &caster, settings, source, plan, seed, index };
        let firsts: Vec<u32> = (0..plan.particles).step_by(PIECE as usize).collect();
        for piece in parallel::map(&firsts, |&first| shooter.piece(first)) {
            shot.candidates.extend(piece.lights);
            shot.paths.extend(piece.paths);
            shot.shot += piece.shot;
            shot.casts += piece.casts;
        }
        shot.origins.push(source.origin());
    }
    shot
}

struct Shooter<'a> {
    scene: &'a Scene,
    bvh: &'a SceneBvh,
    caster: &'a Caster<'a>,
    settings: &'a InstantRadiosity,
    source: &'a Source<'a>,
    plan: &'a Plan,
    seed: u32,
    /// Of the source.
    index: u32,
}

impl Shooter<'_> {
    fn piece(&self, first: u32) -> Piece {
        let mut piece = Piece::default();
        for index in first..(first + PIECE).min(self.plan.particles) {
            self.shoot(index, &mut piece);
        }
        piece
    }

    fn published(&self) -> bool {
        self.settings.shading == VirtualShading::AsPublished
    }

    fn shoot(&self, index: u32, piece: &mut Piece) {
        let mut numbers = Numbers::new(self.settings.sequence, self.seed, index);
        let Some(start) = self.source.start(&mut numbers) else { return };
        self.leave_glow(&start, piece);
        if index >= self.plan.count(1) {
            return;
        }
        piece.shot += 1;
        let mut path = vec![start.origin];
        let mut flight = Flight::new(&start, self.published(), self.source);
        let mut hit = 1;
        while index < self.plan.count(hit) {
            let ray = Ray::new(flight.origin, flight.direction);
            let Some(cast) = self.caster.cast(&ray, &mut piece.casts) else { break };
            path.push(ray.at(cast.t));
            let Some(met) = meet(self.scene, self.bvh, &ray, &cast) else { break };
            let Some(light) = self.reflect(&mut flight, &met, hit) else { break };
            piece.lights.push(light);
            hit += 1;
            if index >= self.plan.count(hit) || !self.turn(&mut flight, &met, numbers.pair()) {
                break;
            }
        }
        if index < MAX_PATHS {
            piece.paths.push(path);
        }
    }

    /// The light of the start point itself.
    fn leave_glow(&self, start: &Start, piece: &mut Piece) {
        let share = 1.0 / self.plan.particles as f32;
        let light = match start.glow {
            Glow::None => return,
            Glow::Surface(normal, intensity, _) => VirtualLight {
                place: start.origin.to_array(),
                kind: SURFACE,
                normal: normal.to_array(),
                intensity: (intensity * share).to_array(),
                ..Default::default()
            },
            Glow::Distant(irradiance) => VirtualLight {
                place: (-start.direction).to_array(),
                kind: DISTANT,
                intensity: (irradiance * share).to_array(),
                ..Default::default()
            },
        };
        let area = if let Glow::Surface(_, _, area) = start.glow { area * share } else { 0.0 };
        let glow = mean(light.intensity.into());
        let power = if light.kind == SURFACE { PI * glow } else { glow };
        piece.lights.push(Candidate { source: self.index, hit: 0, light, area, power });
    }

    /// Takes from the particle what the surface absorbs, and leaves a light; none where nothing is reflected.
    fn reflect(&self, flight: &mut Flight, met: &Met, hit: u32) -> Option<Candidate> {
        let offset = met.position - flight.origin;
        let distance = offset.length();
        let cosine = -flight.direction.dot(met.geometric_normal);
        if hit == 1
            && let Source::Light(_, light, _) = self.source
            && let Some(range) = light.range.filter(|_| !self.published() && light.has_position())
        {
            flight.flux *= (1.0 - (distance / range).powi(4)).clamp(0.0, 1.0);
        }
        let published = self.published();
        let arrived = flight.flux;
        flight.flux *= if published { met.albedo / PI } else { met.reflectance(cosine) };
        if !(flight.flux.max_element() > 0.0 && flight.flux.is_finite()) {
            return None;
        }
        let count = self.plan.count(hit) as f32;
        let share = if published { 1.0 / count } else { 1.0 / (PI * count) };
        // The inverse of the density with which particles arrive, over their number.
        let per_area = flight.per_area + flight.per_solid_angle / (distance * distance).max(f32::MIN_POSITIVE);
        let area = 1.0 / (per_area * cosine.max(1e-3) * count);
        let light = VirtualLight {
            place: met.position.to_array(),
            kind: SURFACE,
            normal: met.normal.to_array(),
            intensity: (flight.flux * share).to_array(),
            offset: 4.0 * met.error,
            ..Default::default()
        };
        let light = match met.gloss() {
            Some((gloss, specular)) if !published => VirtualLight {
                intensity: (arrived * met.albedo * share).to_array(),
                flux: (arrived / count).to_array(),
                gloss,
                specular,
                incident: octahedral(-flight.direction),
                ..light
            },
            _ => light,
        };
        let power = mean(flight.flux) / count;
        Some(Candidate { source: self.index, hit, light, area, power })
    }

    /// Sends the particle on; false where it would go into the surface.
    fn turn(&self, flight: &mut Flight, met: &Met, u: glam::Vec2) -> bool {
        let direction = match self.settings.bounce {
            ParticleBounce::Diffuse => cosine_direction(met.normal, u),
            ParticleBounce::Mirror => flight.direction - 2.0 * flight.direction.dot(met.normal) * met.normal,
        };
        if direction.dot(met.geometric_normal) <= 0.0 {
            return false;
        }
        flight.origin = met.position + met.geometric_normal * (4.0 * met.error);
        flight.direction = direction;
        flight.per_area = 0.0;
        // A mirrored beam keeps the spread that it had; cosθ/π is the spread of diffuse light.
        flight.per_solid_angle = direction.dot(met.normal).max(1e-3) / PI;
        true
    }
}

/// A unit vector in two times 16 bits (Cigolle et al. 2014), as `unpack2x16snorm` reads them.
fn octahedral(d: Vec3) -> u32 {
    let p = d.truncate() / d.abs().element_sum().max(f32::MIN_POSITIVE);
    let sign = |x: f32| if x >= 0.0 { 1.0 } else { -1.0 };
    let [x, y] = if d.z >= 0.0 { [p.x, p.y] } else { [(1.0 - p.y.abs()) * sign(p.x), (1.0 - p.x.abs()) * sign(p.y)] };
    let word = |value: f32| u32::from((value.clamp(-1.0, 1.0) * 32767.0).round() as i16 as u16);
    word(x) | word(y) << 16
}

/// Mean of the channels.
fn mean(light: Vec3) -> f32 {
    light.element_sum() / 3.0
}

/// A particle on its way.
struct Flight {
    origin: Vec3,
    direction: Vec3,
    flux: Vec3,
    per_solid_angle: f32,
    per_area: f32,
}

impl Flight {
    fn new(start: &Start, published: bool, source: &Source) -> Self {
        let flux = match source {
            Source::Light(_, light, _) if published => light.intensity,
            _ => start.flux,
        };
        let Start { origin, direction, per_solid_angle, per_area, .. } = *start;
        Self { origin, direction, flux, per_solid_angle, per_area }
    }
}
