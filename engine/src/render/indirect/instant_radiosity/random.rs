//! The numbers that decide where particles go.

use crate::world::ParticleSequence;
use glam::{Mat3, Vec2, Vec3};
use std::f32::consts::TAU;

/// O'Neill's PCG output function, as a hash (Jarzynski and Olano 2020).
fn hash(value: u32) -> u32 {
    let state = value.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    (word >> 22) ^ word
}

/// A hash of an ordered pair.
pub(super) fn hash_pair(a: u32, b: u32) -> u32 {
    hash(a ^ hash(b.wrapping_add(0x9e37_79b9)))
}

/// Owen scrambling as a hash of the reversed bits (Laine and Karras 2011, with the constants of Burley 2020).
fn scramble(value: u32, seed: u32) -> u32 {
    let mut x = value.reverse_bits().wrapping_add(seed);
    for factor in [0x6c50_b47c, 0xb82f_1e52, 0xc7af_e638, 0x8d22_f6e6_u32] {
        x ^= x.wrapping_mul(factor);
    }
    x.reverse_bits()
}

/// Second dimension of the Sobol' (0, 2)-sequence; the first is the radical inverse.
fn sobol_second(mut index: u32) -> u32 {
    let (mut x, mut direction) = (0, 0x8000_0000_u32);
    while index != 0 {
        if index & 1 != 0 {
            x ^= direction;
        }
        direction ^= direction >> 1;
        index >>= 1;
    }
    x
}

fn unit(bits: u32) -> f32 {
    (bits >> 8) as f32 * 2.0_f32.powi(-24)
}

/// The numbers of one particle: a fresh pair of dimensions a call.
pub(super) struct Numbers {
    sequence: ParticleSequence,
    seed: u32,
    index: u32,
    dimension: u32,
}

impl Numbers {
    /// Numbers of the `index`-th particle of a source.
    pub(super) fn new(sequence: ParticleSequence, seed: u32, index: u32) -> Self {
        Self { sequence, seed, index, dimension: 0 }
    }

    /// Two numbers in [0, 1). Of the low-discrepancy sequence any first 2ᵏ particles have theirs stratified together;
    /// pairs of different calls are shuffled against each other (Burley 2020).
    pub(super) fn pair(&mut self) -> Vec2 {
        let seed = hash_pair(self.seed, self.dimension);
        self.dimension += 1;
        match self.sequence {
            ParticleSequence::LowDiscrepancy => {
                let index = scramble(self.index, seed);
                let x = scramble(index.reverse_bits(), hash(seed ^ 0x9e37_79b9));
                let y = scramble(sobol_second(index), hash(seed ^ 0x85eb_ca6b));
                Vec2::new(unit(x), unit(y))
            }
            ParticleSequence::Random => {
                let x = hash_pair(seed, self.index);
                Vec2::new(unit(x), unit(hash(x ^ 0x85eb_ca6b)))
            }
        }
    }
}

/// Two unit vectors perpendicular to a third, and the third (Duff et al. 2017).
pub(super) fn frame(n: Vec3) -> Mat3 {
    let s = if n.z >= 0.0 { 1.0 } else { -1.0 };
    let a = -1.0 / (s + n.z);
    let b = n.x * n.y * a;
    Mat3::from_cols(Vec3::new(1.0 + s * n.x * n.x * a, s * b, -s * n.x), Vec3::new(b, s + n.y * n.y * a, -n.y), n)
}

/// Direction around n with density cosθ/π (Malley's method).
pub(super) fn cosine_direction(n: Vec3, u: Vec2) -> Vec3 {
    let (radius, angle) = (u.x.sqrt(), TAU * u.y);
    (frame(n) * Vec3::new(radius * angle.cos(), radius * angle.sin(), (1.0 - u.x).max(0.0).sqrt())).normalize()
}

/// Direction in the cone around n whose half angle has this cosine, all alike; −1: the whole sphere.
pub(super) fn cone_direction(n: Vec3, cosine: f32, u: Vec2) -> Vec3 {
    let z = 1.0 - u.x * (1.0 - cosine);
    let (radius, angle) = ((1.0 - z * z).max(0.0).sqrt(), TAU * u.y);
    (frame(n) * Vec3::new(radius * angle.cos(), radius * angle.sin(), z)).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_particles_are_stratified() {
        for dimension in 0..4 {
            let mut cells = [0; 64];
            for index in 0..64 {
                let mut numbers = Numbers::new(ParticleSequence::LowDiscrepancy, 5, index);
                let mut pair = numbers.pair();
                for _ in 0..dimension {
                    pair = numbers.pair();
                }
                cells[(pair.x * 8.0) as usize * 8 + (pair.y * 8.0) as usize] += 1;
            }
            assert_eq!(cells, [1; 64], "pair {dimension}");
        }
    }

    #[test]
    fn means_of_directions_are_those_of_their_densities() {
        let n = Vec3::new(0.3, -0.8, 0.52).normalize();
        let (mut cosine, mut cone, mut sphere) = (0.0, 0.0, Vec3::ZERO);
        for index in 0..4096 {
            let u = Numbers::new(ParticleSequence::LowDiscrepancy, 1, index).pair();
            cosine += cosine_direction(n, u).dot(n) / 4096.0;
            cone += cone_direction(n, 0.5, u).dot(n) / 4096.0;
            sphere += cone_direction(n, -1.0, u) / 4096.0;
        }
        // ∫cos²θ/π = ⅔; a cone up to cosine c has the mean (1 + c)/2.
        assert!((cosine - 2.0 / 3.0).abs() < 1e-3 && (cone - 0.75).abs() < 1e-3, "{cosine} {cone}");
        assert!(sphere.length() < 1e-3, "{sphere}");
    }
}
