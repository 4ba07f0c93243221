//! Light-emitting particles: sparks, embers, fireflies.

use bevy_ecs::prelude::*;
use glam::{Mat3A, Quat, Vec3, Vec3A};
use serde::{Deserialize, Serialize};
use std::f32::consts::TAU;
use std::ops::RangeInclusive;

/// A source of glowing particles. Each is born in a box around the entity, flies freely, and fades into what it is at the end
/// of its life.
///
/// The state of each particle follows from its number, the seed and the time alone: the same time shows the same particles,
/// whatever the frame rate and whatever was shown before. At time zero the source has been at work for ever. A moving entity
/// takes all of its particles with it.
#[derive(Component, Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Particles {
    /// Particles that are born in a second \[1/s\], 0..1e6. Times `life` it is the number of particles at once, at most 65,536.
    pub rate: f32,
    /// Time that each lives \[s\], 1e-3..1e4.
    pub life: f32,
    /// Edges of the box in which they are born \[m\], 0..1e6. It is turned, moved and scaled with the entity.
    pub source: Vec3,
    /// Velocity at birth along the entity's axes \[m/s\], −1e4..1e4.
    pub velocity: Vec3,
    /// Half angle of the cone around that velocity in which they set out \[degrees\], 0..180: 180 is all directions alike.
    pub spread: f32,
    /// Share by which the slowest of them is slower than that velocity, 0..1.
    pub speed_variation: f32,
    /// Acceleration along the world's axes \[m/s²\], −1e4..1e4: upwards for what hot air carries.
    pub gravity: Vec3,
    /// Radius at birth \[m\], 0..1e3.
    pub radius: f32,
    /// Radius at the end of life \[m\], 0..1e3.
    pub end_radius: f32,
    /// Colour at birth, linear RGB, 0..1; multiplies the radiance.
    pub color: Vec3,
    /// Colour at the end of life, linear RGB, 0..1.
    pub end_color: Vec3,
    /// Radiance of their surface [W/(m² sr)], 0..1e12.
    pub radiance: f32,
    /// Other particles of the same kind for another number.
    pub seed: u32,
}

/// A particle at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Particle {
    /// Its number among all that are ever born.
    pub number: i64,
    /// Share of its life that is over, 0..1.
    pub age: f32,
    /// Place from the entity's origin, along the world's axes \[m\].
    pub position: Vec3,
    /// Radius \[m\].
    pub radius: f32,
}

impl Particles {
    /// Most particles of a source at once.
    pub const MOST: usize = 1 << 16;
    /// Rates that a source may have \[1/s\].
    pub const RATES: RangeInclusive<f32> = 0.0..=1e6;
    /// Times that a particle may live \[s\].
    pub const LIVES: RangeInclusive<f32> = 1e-3..=1e4;
    /// Edges that the box of a source may have \[m\].
    pub const SOURCES: RangeInclusive<f32> = 0.0..=1e6;
    /// Speeds \[m/s\] and accelerations \[m/s²\] along an axis that particles may have.
    pub const SPEEDS: RangeInclusive<f32> = -1e4..=1e4;
    /// Half angles that a cone may have \[degrees\].
    pub const SPREADS: RangeInclusive<f32> = 0.0..=180.0;
    /// Radii that particles may have \[m\].
    pub const RADII: RangeInclusive<f32> = 0.0..=1e3;
    /// Radiances that particles may have [W/(m² sr)].
    pub const RADIANCES: RangeInclusive<f32> = 0.0..=1e12;

    /// Number of particles that may live at once.
    pub fn count(&self) -> usize {
        (f64::from(self.rate) * f64::from(self.life)).ceil() as usize
    }

    /// The settings in the ranges that the fields name, and whether they all were: numbers that are none are the least ones,
    /// and a rate that gives too many particles is less.
    pub fn sanitized(&self) -> (Self, bool) {
        let within = |value: f32, range: RangeInclusive<f32>| value.max(*range.start()).min(*range.end());
        let each = |value: Vec3, range: RangeInclusive<f32>| value.to_array().map(|v| within(v, range.clone())).into();
        let motion = |value: Vec3| -> Vec3 {
            // What has no number stands still.
            each(value.to_array().map(|v| if v.is_nan() { 0.0 } else { v }).into(), Self::SPEEDS)
        };
        let mut sane = Self {
            rate: within(self.rate, Self::RATES),
            life: within(self.life, Self::LIVES),
            source: each(self.source, Self::SOURCES),
            velocity: motion(self.velocity),
            spread: within(self.spread, Self::SPREADS),
            speed_variation: within(self.speed_variation, 0.0..=1.0),
            gravity: motion(self.gravity),
            radius: within(self.radius, Self::RADII),
            end_radius: within(self.end_radius, Self::RADII),
            color: each(self.color, 0.0..=1.0),
            end_color: each(self.end_color, 0.0..=1.0),
            radiance: within(self.radiance, Self::RADIANCES),
            seed: self.seed,
        };
        if sane.count() > Self::MOST {
            // A little less, so that rounding does not bring one more.
            sane.rate = 0.999_999 * Self::MOST as f32 / sane.life;
        }
        (sane, sane == *self)
    }

    /// Radiance at a share of life [W/(m² sr)], linear RGB.
    pub fn radiance_at(&self, age: f32) -> Vec3 {
        self.radiance * self.color.lerp(self.end_color, age)
    }

    /// The particles at a time \[s\]: particle n in place n modulo [`Self::count`], where it stays for all of its life; none
    /// where there is none yet. `place` is the linear part of the entity's place, `turn` its orientation.
    pub fn at(&self, seconds: f64, place: &Mat3A, turn: &Mat3A) -> Vec<Option<Particle>> {
        let count = self.count() as i64;
        let births = seconds * f64::from(self.rate);
        let newest = births.floor() as i64;
        let living = |slot: i64| {
            let number = newest - (newest - slot).rem_euclid(count);
            let age = ((births - number as f64) / f64::from(self.rate) / f64::from(self.life)) as f32;
            (age < 1.0).then(|| self.particle(number, age, place, turn))
        };
        (0..count).map(living).collect()
    }

    /// As many particles as there are at most, of all ages alike: those whose places and sizes stand for all times.
    pub fn typical(&self) -> Vec<Particle> {
        let count = self.count();
        let age = |slot: usize| (slot as f32 + 0.5) / count as f32;
        (0..count).map(|slot| self.particle(slot as i64, age(slot), &Mat3A::IDENTITY, &Mat3A::IDENTITY)).collect()
    }

    fn particle(&self, number: i64, age: f32, place: &Mat3A, turn: &Mat3A) -> Particle {
        let random = |which| random(self.seed, number, which);
        let start = place * Vec3A::from(self.source * (Vec3::from_array([0, 1, 2].map(random)) - 0.5));
        let speed = self.velocity.length() * (1.0 - self.speed_variation * random(3));
        let axis = turn * Vec3A::from(self.velocity.normalize_or(Vec3::Y));
        let direction = in_cone(axis.into(), self.spread.to_radians().cos(), [4, 5].map(random));
        let time = age * self.life;
        Particle {
            number,
            age,
            position: Vec3::from(start) + direction * (speed * time) + self.gravity * (0.5 * time * time),
            radius: self.radius + (self.end_radius - self.radius) * age,
        }
    }
}

impl Default for Particles {
    /// Sparks of a small fire.
    fn default() -> Self {
        Self {
            rate: 50.0,
            life: 2.0,
            source: Vec3::splat(0.1),
            velocity: Vec3::new(0.0, 2.0, 0.0),
            spread: 20.0,
            speed_variation: 0.5,
            gravity: Vec3::new(0.0, -1.0, 0.0),
            radius: 0.01,
            end_radius: 0.002,
            color: Vec3::new(1.0, 0.6, 0.2),
            end_color: Vec3::new(0.5, 0.05, 0.01),
            radiance: 500.0,
            seed: 0,
        }
    }
}

/// A number in 0..1 of a particle (splitmix64: Steele, Lea and Flood 2014).
fn random(seed: u32, number: i64, which: u32) -> f32 {
    let mut z = (number as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15)
        ^ (u64::from(seed) << 32 | u64::from(which)).wrapping_mul(0xd1b5_4a32_d192_ed03);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ (z >> 31)) >> 40) as f32 / (1 << 24) as f32
}

/// The turn of a particle, all turns alike (Shoemake 1992).
pub(crate) fn turn_of_particle(seed: u32, number: i64) -> Quat {
    let [share, first, second] = [6, 7, 8].map(|which| random(seed, number, which));
    let (a, b) = ((1.0 - share).sqrt(), share.sqrt());
    let [(sin_a, cos_a), (sin_b, cos_b)] = [first, second].map(|turn| (turn * TAU).sin_cos());
    Quat::from_xyzw(a * sin_a, a * cos_a, b * sin_b, b * cos_b)
}

/// A unit vector, evenly distributed in the cone around a unit axis with a cosine of its half angle.
fn in_cone(axis: Vec3, cosine: f32, [along, around]: [f32; 2]) -> Vec3 {
    let c = 1.0 - along * (1.0 - cosine);
    let s = (1.0 - c * c).max(0.0).sqrt();
    let (right, up) = axis.any_orthonormal_pair();
    let (sine, cosine) = (around * TAU).sin_cos();
    axis * c + right * (s * cosine) + up * (s * sine)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn at(particles: &Particles, seconds: f64) -> Vec<Option<Particle>> {
        particles.at(seconds, &Mat3A::IDENTITY, &Mat3A::IDENTITY)
    }

    #[test]
    fn a_particle_flies_a_parabola_and_keeps_its_place_for_life() {
        let sparks = Particles { rate: 3.0, life: 2.0, ..Particles::default() };
        assert_eq!(sparks.count(), 6);
        let slot = 4;
        let born = at(&sparks, 10.0 / 3.0 + 1e-9)[slot].unwrap();
        assert!(born.number == 10 && born.age < 1e-6 && born.position.length() < 0.1, "{born:?}");
        let halfway = at(&sparks, 10.0 / 3.0 + 1.0)[slot].unwrap();
        let end = at(&sparks, 10.0 / 3.0 + 1.999)[slot].unwrap();
        assert_eq!((halfway.number, end.number), (10, 10));
        assert!((halfway.age - 0.5).abs() < 1e-6 && (halfway.radius - 0.006).abs() < 1e-6, "{halfway:?}");
        // The second difference of places is the acceleration.
        let bend = end.position - 2.0 * halfway.position + born.position;
        assert!((bend - sparks.gravity).length() < 0.01, "{bend}");
        let next = at(&sparks, 10.0 / 3.0 + 2.001)[slot].unwrap();
        assert_eq!(next.number, 16);
    }

    #[test]
    fn times_alone_decide_and_all_ages_are_there() {
        let sparks = Particles { rate: 1000.0, life: 1.0, ..Particles::default() };
        let now = at(&sparks, 7.25);
        assert_eq!(now, at(&sparks, 7.25));
        assert_ne!(now, at(&Particles { seed: 1, ..sparks }, 7.25));
        let ages: Vec<f32> = now.iter().flatten().map(|particle| particle.age).collect();
        let mean = ages.iter().sum::<f32>() / ages.len() as f32;
        assert!(ages.len() >= 999 && (mean - 0.5).abs() < 0.01, "{} particles, mean age {mean}", ages.len());
        // Time zero is no beginning.
        assert_eq!(at(&sparks, 0.0).iter().flatten().count(), ages.len());
        assert_eq!(sparks.typical().len(), 1000);
    }

    #[test]
    fn directions_fill_the_cone_evenly() {
        let sparks = Particles { rate: 4000.0, life: 1.0, spread: 60.0, speed_variation: 0.0, ..Particles::default() };
        let still = Particles { source: Vec3::ZERO, gravity: Vec3::ZERO, ..sparks };
        let turn = Mat3A::from_rotation_z(-std::f32::consts::FRAC_PI_2);
        let all = still.at(0.0, &Mat3A::IDENTITY, &turn);
        let along: Vec<f32> = all.iter().flatten().filter_map(|p| Some(p.position.try_normalize()?.x)).collect();
        let (least, mean) = (along.iter().copied().fold(1.0, f32::min), along.iter().sum::<f32>() / along.len() as f32);
        assert!((0.499..0.51).contains(&least) && (mean - 0.75).abs() < 0.01, "{least} {mean}");
    }

    #[test]
    fn what_is_out_of_range_is_brought_into_it() {
        assert_eq!(Particles::default().sanitized(), (Particles::default(), true));
        let wild = Particles {
            rate: 1e9,
            life: 0.0,
            velocity: Vec3::new(f32::NAN, 1e9, f32::NEG_INFINITY),
            radius: -1.0,
            end_radius: f32::NAN,
            color: Vec3::new(-1.0, 2.0, f32::NAN),
            radiance: f32::INFINITY,
            ..Particles::default()
        };
        let (sane, was_sane) = wild.sanitized();
        assert!(!was_sane && sane.count() <= Particles::MOST, "{sane:?}");
        assert_eq!((sane.life, sane.velocity), (1e-3, Vec3::new(0.0, 1e4, -1e4)));
        assert_eq!((sane.radius, sane.end_radius, sane.color), (0.0, 0.0, Vec3::new(0.0, 1.0, 0.0)));
        let (many, _) = Particles { rate: 1e6, life: 1e4, ..wild }.sanitized();
        assert!((65_000..=Particles::MOST).contains(&many.count()), "{}", many.count());
    }
}
