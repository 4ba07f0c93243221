//! The light of a clear sky: single scattering along lines of sight, and all further scattering by a table (Hillaire 2020,
//! "A scalable and production ready sky and atmosphere rendering technique"). Coefficients of the air are those of Bruneton
//! 2017 ("A qualitative and quantitative evaluation of 8 clear sky models"), for red, green and blue.
//!
//! Lengths are in kilometres, in double precision: metres above a sphere of 6,360 km.

use super::{SkyMap, parallel};
use glam::{DVec3, Vec3};
use std::f64::consts::PI;

/// Radius of the ground, and of the top of the air \[km\].
const GROUND: f64 = 6360.0;
const TOP: f64 = 6460.0;
/// Scattering of air at sea level \[1/km\], and the height over which its density falls to 1/e \[km\].
const RAYLEIGH: DVec3 = DVec3::new(5.802e-3, 13.558e-3, 33.1e-3);
const RAYLEIGH_HEIGHT: f64 = 8.0;
/// Scattering and extinction of the aerosols of clear air at sea level \[1/km\], with their height \[km\].
const MIE: f64 = 3.996e-3;
const MIE_EXTINCTION: f64 = 4.44e-3;
const MIE_HEIGHT: f64 = 1.2;
/// Mean cosine of the angle by which aerosols scatter.
const MIE_FORWARD: f64 = 0.8;
/// Absorption of the ozone layer at its densest \[1/km\]; the middle and half the thickness of the layer \[km\].
const OZONE: DVec3 = DVec3::new(0.65e-3, 1.881e-3, 0.085e-3);
const OZONE_MIDDLE: f64 = 25.0;
const OZONE_HALF: f64 = 15.0;

/// Columns and rows of a sky's map.
const WIDTH: u32 = 512;
const HEIGHT: u32 = 256;
/// Steps along a line of sight, and along one through which the sun shines.
const STEPS: u32 = 40;
const STEPS_TO_TOP: u32 = 40;
/// Edge of the table of further scattering, and of the square of directions that it is integrated over.
const SCATTERING_EDGE: usize = 32;
const DIRECTIONS: usize = 8;
/// Rows (heights) and columns (directions) of the table of transmittance.
const HEIGHTS: usize = 64;
const COSINES: usize = 256;
/// Highest place to stand at \[m\].
pub(crate) const MAX_ALTITUDE: f32 = 90_000.0;

/// The air, and the ground below it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Atmosphere {
    /// Aerosols, relative to clear air; 0: none, 5: a hazy day, 20: the next hill is gone.
    pub haze: f32,
    /// Diffuse reflectance of the ground.
    pub ground: Vec3,
    /// Height of the scene above the sea \[m\].
    pub altitude: f32,
}

/// A medium at a height.
struct Air {
    rayleigh: DVec3,
    mie: f64,
    extinction: DVec3,
}

/// What was computed of an atmosphere once, for all places of the sun.
#[derive(Clone, Debug)]
pub struct AtmosphereTables {
    atmosphere: Atmosphere,
    transmittance: Vec<DVec3>,
    /// Light that has been scattered more than once, by the sun's height and that of the place.
    scattering: Vec<DVec3>,
}

impl Atmosphere {
    /// The same with values in range.
    pub(crate) fn sanitized(self) -> Self {
        let within = |value: f32, most: f32| if value.is_finite() { value.clamp(0.0, most) } else { 0.0 };
        let ground = if self.ground.is_finite() { self.ground.clamp(Vec3::ZERO, Vec3::ONE) } else { Vec3::ZERO };
        Self { haze: within(self.haze, 100.0), ground, altitude: within(self.altitude, MAX_ALTITUDE) }
    }

    fn air(&self, height: f64) -> Air {
        let rayleigh = RAYLEIGH * (-height / RAYLEIGH_HEIGHT).exp();
        let aerosols = f64::from(self.haze) * (-height / MIE_HEIGHT).exp();
        let ozone = OZONE * (1.0 - (height - OZONE_MIDDLE).abs() / OZONE_HALF).max(0.0);
        Air { rayleigh, mie: MIE * aerosols, extinction: rayleigh + ozone + DVec3::splat(MIE_EXTINCTION * aerosols) }
    }

    /// Distance of the place from the middle of the planet \[km\]: never quite on the ground, whose horizon is not defined.
    fn radius(&self) -> f64 {
        GROUND + (f64::from(self.altitude) * 1e-3).max(1e-3)
    }
}

/// Distance along a ray to a sphere around the middle, from a radius with a cosine to the vertical; none: it is missed.
fn distance_to(sphere: f64, radius: f64, cosine: f64) -> Option<f64> {
    let discriminant = radius * radius * (cosine * cosine - 1.0) + sphere * sphere;
    let root = discriminant.max(0.0).sqrt();
    let distance = if sphere >= radius { -radius * cosine + root } else { -radius * cosine - root };
    (discriminant >= 0.0 && distance >= 0.0).then_some(distance)
}

/// Radius after a way along a ray.
fn radius_after(radius: f64, cosine: f64, way: f64) -> f64 {
    (way * way + 2.0 * radius * cosine * way + radius * radius).max(0.0).sqrt().clamp(GROUND, TOP)
}

/// Rayleigh's phase function [1/sr].
fn rayleigh_phase(cosine: f64) -> f64 {
    3.0 / (16.0 * PI) * (1.0 + cosine * cosine)
}

/// Phase function of aerosols [1/sr] (Cornette and Shanks 1992).
fn mie_phase(cosine: f64) -> f64 {
    let g = MIE_FORWARD;
    let base = (1.0 + g * g - 2.0 * g * cosine).powf(1.5);
    3.0 / (8.0 * PI) * (1.0 - g * g) * (1.0 + cosine * cosine) / ((2.0 + g * g) * base)
}

/// Light scattered on the way along a ray, and what is left of light from its end.
struct Along {
    light: DVec3,
    transmittance: DVec3,
    /// Light that would be scattered if the light around were 1 everywhere.
    of_even: DVec3,
}

/// A ray through the air, and the sun as it sees it.
#[derive(Clone, Copy)]
struct Sight {
    radius: f64,
    /// Cosines: of the ray and of the sun to the vertical, and between the two.
    up: f64,
    sun_up: f64,
    toward_sun: f64,
}

impl AtmosphereTables {
    /// Computes the tables.
    pub fn new(atmosphere: Atmosphere) -> Self {
        let mut tables = Self { atmosphere, transmittance: Vec::new(), scattering: Vec::new() };
        let rows: Vec<usize> = (0..HEIGHTS).collect();
        tables.transmittance = parallel::map(&rows, |row| tables.transmittance_row(*row)).concat();
        let rows: Vec<usize> = (0..SCATTERING_EDGE).collect();
        tables.scattering = parallel::map(&rows, |row| tables.scattering_row(*row)).concat();
        tables
    }

    /// The atmosphere that they are of.
    pub fn atmosphere(&self) -> &Atmosphere {
        &self.atmosphere
    }

    /// Share of the sun's light that arrives at the scene, with the sine of the sun's elevation; the sun sets over the
    /// angle of its disc.
    pub fn sunlight(&self, sine: f32) -> Vec3 {
        let radius = self.atmosphere.radius();
        let (sine, horizon) = (f64::from(sine), -(1.0 - (GROUND / radius).powi(2)).max(0.0).sqrt());
        // Half the angle of the sun: 0.27°.
        let above = ((sine - horizon) / 4.65e-3 * 0.5 + 0.5).clamp(0.0, 1.0);
        let smooth = above * above * (3.0 - 2.0 * above);
        (self.to_top(radius, sine.max(horizon + 1e-4)) * smooth).as_vec3()
    }

    /// The sky with the sun towards −Z, at an elevation with that sine, for an irradiance of 1 [W/m²] outside the air.
    pub fn sky(&self, sine: f32) -> SkyMap {
        let sine = f64::from(sine.clamp(-1.0, 1.0));
        let sun = DVec3::new(0.0, sine, -(1.0 - sine * sine).max(0.0).sqrt());
        let above: Vec<u32> = (0..HEIGHT / 2).collect();
        let mut texels = parallel::map(&above, |row| self.row(*row, sun, DVec3::ZERO)).concat();
        let from_sky = irradiance(&texels);
        let below: Vec<u32> = (HEIGHT / 2..HEIGHT).collect();
        texels.extend(parallel::map(&below, |row| self.row(*row, sun, from_sky)).concat());
        SkyMap::new([WIDTH, HEIGHT], texels, 0.0)
    }

    /// A row of texels; the sky is the same on both sides of the sun.
    fn row(&self, row: u32, sun: DVec3, from_sky: DVec3) -> Vec<Vec3> {
        let half: Vec<Vec3> = (0..WIDTH / 2).map(|column| self.texel(column, row, sun, from_sky)).collect();
        half.iter().chain(half.iter().rev()).copied().collect()
    }

    fn texel(&self, column: u32, row: u32, sun: DVec3, from_sky: DVec3) -> Vec3 {
        let direction = direction(column, row);
        let radius = self.atmosphere.radius();
        let sight = Sight { radius, up: direction.y, sun_up: sun.y, toward_sun: direction.dot(sun) };
        let ground = distance_to(GROUND, radius, direction.y);
        let end = ground.or(distance_to(TOP, radius, direction.y)).unwrap_or(0.0);
        let along = self.along(sight, end, STEPS, true);
        let mut light = along.light;
        if ground.is_some() {
            let sun_up = (sun.y * radius + end * sight.toward_sun) / GROUND;
            let from_sun = self.to_sun(GROUND, sun_up) * sun_up.max(0.0);
            light += along.transmittance * self.atmosphere.ground.as_dvec3() / PI * (from_sun + from_sky);
        }
        light.as_vec3().max(Vec3::ZERO)
    }

    /// Integrates along a ray. Steps grow with the distance, as the square of their number does.
    fn along(&self, sight: Sight, end: f64, steps: u32, further: bool) -> Along {
        let mut sum = Along { light: DVec3::ZERO, transmittance: DVec3::ONE, of_even: DVec3::ZERO };
        let (rayleigh, mie) = match further {
            true => (rayleigh_phase(sight.toward_sun), mie_phase(sight.toward_sun)),
            false => (1.0 / (4.0 * PI), 1.0 / (4.0 * PI)),
        };
        let way = |step: f64| end * (step / f64::from(steps)).powi(2);
        for step in 0..steps {
            let (start, stop) = (way(f64::from(step)), way(f64::from(step) + 1.0));
            let middle = 0.5 * (start + stop);
            let radius = radius_after(sight.radius, sight.up, middle);
            let air = self.atmosphere.air(radius - GROUND);
            let sun_up = ((sight.radius * sight.sun_up + middle * sight.toward_sun) / radius).clamp(-1.0, 1.0);
            let scattering = air.rayleigh + DVec3::splat(air.mie);
            let mut light = (air.rayleigh * rayleigh + DVec3::splat(air.mie * mie)) * self.to_sun(radius, sun_up);
            if further {
                light += scattering * self.further(radius, sun_up);
            }
            let passes = (air.extinction * -(stop - start)).map(f64::exp);
            // ∫ S·e^{−σt} dt over the step; S times its length where nothing is lost.
            let share = (DVec3::ONE - passes) / air.extinction.max(DVec3::splat(1e-12)) * sum.transmittance;
            sum.light += light * share;
            sum.of_even += scattering * share;
            sum.transmittance *= passes;
        }
        sum
    }

    /// Share of the sun's light that arrives at a place; none below the horizon.
    fn to_sun(&self, radius: f64, sun_up: f64) -> DVec3 {
        let horizon = -(1.0 - (GROUND / radius).powi(2)).max(0.0).sqrt();
        if sun_up < horizon { DVec3::ZERO } else { self.to_top(radius, sun_up) }
    }

    /// Share of light that comes through the air from outside, looked up.
    fn to_top(&self, radius: f64, cosine: f64) -> DVec3 {
        let (row, column) = transmittance_at(radius, cosine);
        bilinear(&self.transmittance, COSINES, HEIGHTS, column, row)
    }

    fn transmittance_row(&self, row: usize) -> Vec<DVec3> {
        let of = |column: usize| {
            let (radius, cosine) = transmittance_place(row, column);
            let end = distance_to(TOP, radius, cosine).unwrap_or(0.0);
            let length = end / f64::from(STEPS_TO_TOP);
            let depth = |step: u32| {
                let height = radius_after(radius, cosine, length * (f64::from(step) + 0.5)) - GROUND;
                self.atmosphere.air(height).extinction * length
            };
            let depth: DVec3 = (0..STEPS_TO_TOP).map(depth).sum();
            (-depth).map(f64::exp)
        };
        (0..COSINES).map(of).collect()
    }

    /// Light of all scatterings but the first, per unit of scattering, looked up [1/sr].
    fn further(&self, radius: f64, sun_up: f64) -> DVec3 {
        let edge = (SCATTERING_EDGE - 1) as f64;
        let row = (radius - GROUND) / (TOP - GROUND) * edge;
        bilinear(&self.scattering, SCATTERING_EDGE, SCATTERING_EDGE, (sun_up * 0.5 + 0.5) * edge, row)
    }

    /// Hillaire's equations 5 to 10: the light of the second scattering, times the sum of the geometric series of those after
    /// it, all taken to be isotropic.
    fn scattering_row(&self, row: usize) -> Vec<DVec3> {
        let edge = (SCATTERING_EDGE - 1) as f64;
        let height = (row as f64 / edge * (TOP - GROUND)).clamp(1e-3, TOP - GROUND - 1e-3);
        (0..SCATTERING_EDGE).map(|column| self.all_further(GROUND + height, column as f64 / edge * 2.0 - 1.0)).collect()
    }

    fn all_further(&self, radius: f64, sun_up: f64) -> DVec3 {
        let sun = DVec3::new(0.0, sun_up, -(1.0 - sun_up * sun_up).max(0.0).sqrt());
        let (mut second, mut share) = (DVec3::ZERO, DVec3::ZERO);
        let weight = 1.0 / (DIRECTIONS * DIRECTIONS) as f64;
        for i in 0..DIRECTIONS * DIRECTIONS {
            let part = |k: usize| (k as f64 + 0.5) / DIRECTIONS as f64;
            let (cosine, azimuth) = (1.0 - 2.0 * part(i % DIRECTIONS), 2.0 * PI * part(i / DIRECTIONS));
            let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
            let direction = DVec3::new(sine * azimuth.sin(), cosine, -sine * azimuth.cos());
            let sight = Sight { radius, up: cosine, sun_up, toward_sun: direction.dot(sun) };
            let ground = distance_to(GROUND, radius, cosine);
            let end = ground.or(distance_to(TOP, radius, cosine)).unwrap_or(0.0);
            let along = self.along(sight, end, STEPS / 2, false);
            second += along.light * weight;
            share += along.of_even * weight;
            if ground.is_some() {
                let sun_up = (sun.y * radius + end * sight.toward_sun) / GROUND;
                let lit = self.to_sun(GROUND, sun_up) * sun_up.max(0.0);
                second += along.transmittance * self.atmosphere.ground.as_dvec3() / PI * lit * weight;
            }
        }
        second / (DVec3::ONE - share).max(DVec3::splat(1e-3))
    }
}

/// Direction of a texel, as [`SkyMap::direction`] has it without a turn.
fn direction(column: u32, row: u32) -> DVec3 {
    let azimuth = 2.0 * PI * ((f64::from(column) + 0.5) / f64::from(WIDTH) - 0.5);
    let polar = PI * (f64::from(row) + 0.5) / f64::from(HEIGHT);
    DVec3::new(polar.sin() * azimuth.sin(), polar.cos(), -polar.sin() * azimuth.cos())
}

/// Irradiance of the ground below the upper half of a map [W/m²].
fn irradiance(texels: &[Vec3]) -> DVec3 {
    let area = 2.0 * PI / f64::from(WIDTH) * (PI / f64::from(HEIGHT));
    let part = |(i, texel): (usize, &Vec3)| {
        let polar = PI * ((i / WIDTH as usize) as f64 + 0.5) / f64::from(HEIGHT);
        texel.as_dvec3() * (polar.sin() * polar.cos() * area)
    };
    texels.iter().enumerate().map(part).sum()
}

/// Distances from the ground's horizon at the height of a row, for the top and for that height \[km\].
fn horizon_distances(radius: f64) -> (f64, f64) {
    let of_top = (TOP * TOP - GROUND * GROUND).sqrt();
    (of_top, (radius * radius - GROUND * GROUND).max(0.0).sqrt())
}

/// Where in the table a place lies, as row and column: both by distances that a ray goes (Bruneton 2017).
fn transmittance_at(radius: f64, cosine: f64) -> (f64, f64) {
    let (of_top, own) = horizon_distances(radius);
    let way = distance_to(TOP, radius, cosine).unwrap_or(0.0);
    let (shortest, longest) = (TOP - radius, own + of_top);
    let column = (way - shortest) / (longest - shortest).max(1e-9);
    (own / of_top * (HEIGHTS - 1) as f64, column * (COSINES - 1) as f64)
}

/// The place of an entry: radius and cosine to the vertical.
fn transmittance_place(row: usize, column: usize) -> (f64, f64) {
    let of_top = horizon_distances(TOP).0;
    let own = of_top * row as f64 / (HEIGHTS - 1) as f64;
    let radius = (own * own + GROUND * GROUND).sqrt();
    let (shortest, longest) = (TOP - radius, own + of_top);
    let way = shortest + (longest - shortest) * column as f64 / (COSINES - 1) as f64;
    let cosine = if way <= 0.0 { 1.0 } else { (of_top * of_top - own * own - way * way) / (2.0 * radius * way) };
    (radius, cosine.clamp(-1.0, 1.0))
}

fn bilinear(table: &[DVec3], width: usize, height: usize, column: f64, row: f64) -> DVec3 {
    let (column, row) = (column.clamp(0.0, (width - 1) as f64), row.clamp(0.0, (height - 1) as f64));
    let (x, y) = (column as usize, row as usize);
    let at = |x: usize, y: usize| table[y.min(height - 1) * width + x.min(width - 1)];
    let low = at(x, y).lerp(at(x + 1, y), column - x as f64);
    low.lerp(at(x, y + 1).lerp(at(x + 1, y + 1), column - x as f64), row - y as f64)
}

#[cfg(test)]
#[path = "atmosphere_tests.rs"]
mod tests;
