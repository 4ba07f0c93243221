//! How many particles a source shoots, and how many of them go on.

use crate::assets::{AssetId, Texture};
use crate::scene::Scene;
use crate::world::{Bounces, Schedule};
use glam::Vec3;
use std::collections::HashMap;
use std::sync::Arc;

/// Hits of one particle at most. With the largest reflectance that the schedule takes, N = 10⁶ ends before.
pub(super) const MAX_HITS: u32 = 256;
/// Largest mean reflectance that the schedule takes: at 1 it would never end.
const MAX_REFLECTANCE: f64 = 0.95;

/// The numbers of particles of one source.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Plan {
    /// Particles of the source, N.
    pub(super) particles: u32,
    /// Mean reflectance ρ.
    reflectance: f64,
    schedule: Schedule,
    /// Hits that may become lights.
    hits: u32,
}

impl Plan {
    /// `emits` is true for sources whose start points are lights themselves, which is one reflection more.
    pub(super) fn new(particles: u32, reflectance: f64, schedule: Schedule, bounces: Bounces, emits: bool) -> Self {
        let most = match bounces {
            Bounces::Converged => MAX_HITS,
            Bounces::Count(count) => count,
        };
        let hits = most.saturating_sub(u32::from(emits)).min(MAX_HITS);
        Self { particles, reflectance: reflectance.clamp(0.0, MAX_REFLECTANCE), schedule, hits }
    }

    /// Particles that make the `hit`-th hit, counted from 1.
    pub(super) fn count(&self, hit: u32) -> u32 {
        if hit == 0 || hit > self.hits {
            return 0;
        }
        let power = match self.schedule {
            Schedule::Keller => hit,
            Schedule::Report => hit - 1,
        };
        // A rounding must not take one away where ρʲN is whole.
        (f64::from(self.particles) * self.reflectance.powi(power as i32) + 1e-9).floor() as u32
    }

    /// Hits of all particles together: the lights that they leave at most.
    pub(super) fn hits(&self) -> u64 {
        (1..=MAX_HITS).map(|hit| u64::from(self.count(hit))).take_while(|&count| count > 0).sum()
    }
}

/// Deals out particles to sources in proportion to their flux, at least one each.
pub(super) fn deal(particles: u32, flux: &[f64]) -> Vec<u32> {
    let total: f64 = flux.iter().sum();
    let mut begun = 0.0;
    let mut before = 0;
    flux.iter()
        .map(|flux| {
            begun += flux / total.max(f64::MIN_POSITIVE);
            let until = (f64::from(particles) * begun).round() as u32;
            let share = until.saturating_sub(before);
            before = until;
            share.max(1)
        })
        .collect()
}

/// Mean reflectance ρ of the scene's surfaces by area: the mean channel of base colours with their textures.
pub(super) fn mean_reflectance(scene: &Scene, colors: &mut HashMap<AssetId, Vec3>) -> f64 {
    let (mut sum, mut area) = (0.0_f64, 0.0_f64);
    for primitive in &scene.primitives {
        let mean = |texture: &Arc<Texture>| *colors.entry(texture.id).or_insert_with(|| texture.mean_color());
        let texture = primitive.material.base_color_texture.as_ref().map_or(Vec3::ONE, mean);
        let color = (primitive.material.base_color.truncate() * texture).clamp(Vec3::ZERO, Vec3::ONE);
        let corner = |&index: &u32| {
            let position = Vec3::from(primitive.mesh.vertices[index as usize].position);
            primitive.world_from_object.transform_point3(position)
        };
        let own: f64 = primitive
            .mesh
            .indices
            .chunks_exact(3)
            .map(|t| (corner(&t[1]) - corner(&t[0])).cross(corner(&t[2]) - corner(&t[0])).length())
            .filter(|double| double.is_finite())
            .map(|double| 0.5 * f64::from(double))
            .sum();
        let mean = f64::from(color.element_sum()) / 3.0;
        if mean.is_finite() {
            sum += own * mean;
            area += own;
        }
    }
    if area > 0.0 { sum / area } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ten_particles_at_half_reflectance_leave_eighteen_lights() {
        let plan = Plan::new(10, 0.5, Schedule::Report, Bounces::Converged, false);
        let counts: Vec<u32> = (1..=5).map(|hit| plan.count(hit)).collect();
        assert_eq!((counts, plan.hits()), (vec![10, 5, 2, 1, 0], 18));
        // Keller's ten start points with what the first five leave are as many.
        let plan = Plan::new(10, 0.5, Schedule::Keller, Bounces::Converged, true);
        assert_eq!(10 + plan.hits(), 18);
    }

    #[test]
    fn bounces_end_the_schedule() {
        let hits = |bounces, emits| Plan::new(100, 0.5, Schedule::Report, bounces, emits).hits();
        assert_eq!(hits(Bounces::Count(1), false), 100);
        assert_eq!(hits(Bounces::Count(2), false), 150);
        assert_eq!(hits(Bounces::Count(2), true), 100);
        assert_eq!(hits(Bounces::Count(1), true), 0);
        // White walls: the schedule ends all the same.
        assert!(Plan::new(1000, 1.0, Schedule::Report, Bounces::Converged, false).hits() < 20_000);
    }

    #[test]
    fn particles_are_dealt_out_by_flux() {
        assert_eq!(deal(100, &[1.0, 2.0, 1.0]), [25, 50, 25]);
        assert_eq!(deal(10, &[1.0, 1e-9]), [10, 1]);
        assert_eq!(deal(10, &[0.0]), [1]);
        assert_eq!(deal(7, &[1.0, 1.0, 1.0]).iter().sum::<u32>(), 7);
    }
}
