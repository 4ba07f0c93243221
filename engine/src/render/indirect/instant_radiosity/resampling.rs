//! Which of many candidates become the virtual lights of a view.
//!
//! To shoot a particle costs a few rays, to shade its lights a ray of every pixel. So more are shot than are shaded, and
//! those are kept that contribute to what the camera sees (Segovia et al. 2006, "Bidirectional instant radiosity";
//! Georgiev and Slusallek 2010, "Simple and robust iterative importance sampling of virtual point lights"). Of M
//! candidates N are picked (sampling importance resampling, Talbot et al. 2005), candidate i on average N·w_i/W times,
//! W = Σw, and its light counts W/(N·w_i) for each time: the expectation is the sum over all M. The picks are even steps
//! through the sum of the weights along a curve through space, so that they lie as evenly as the candidates do.

use super::intersection::{Caster, IntersectionCounts};
use super::trace_particles::{Candidate, DISTANT, Origin, Particles, Shot, VirtualLight};
use super::view_points::{Contribution, ViewPoints};
use crate::assets::parallel;
use crate::scene::SceneBvh;
use crate::scene::{Scene, SceneView};
use crate::world::InstantRadiosity;
use glam::Vec3;
use std::f32::consts::PI;
use std::ops::Range;

/// Share of the lights of a source and hit that stand for less than d_min's square. Few stand for much, and those would be
/// seen as spots: with the median the error of `courtyard` is a third larger if all lights are kept (512, 64²: 0.53 for
/// 0.40).
const BOUNDED: f32 = 0.9;
/// Candidates of one piece of parallel work.
const PIECE: usize = 256;
/// Parts of a candidate's weight: what arrives by a few rays, what would if nothing were between, since rays may
/// miss, and its flux, since a few points are not all that is seen. No candidate's light grows by more than the inverse
/// of the last.
const SHADOWED: f32 = 0.6;
const UNSHADOWED: f32 = 0.2;
const FLUX: f32 = 0.2;

/// All candidates become lights.
pub(super) fn all(shot: &Shot, scene: &Scene, settings: &InstantRadiosity) -> Particles {
    settle(shot, shot.candidates.clone(), scene, settings)
}

/// One of `settings.candidates` becomes a light: those which contribute most to the view.
pub(super) fn for_view(
    shot: &Shot,
    scene: &Scene,
    bvh: &SceneBvh,
    settings: &InstantRadiosity,
    view: &SceneView,
) -> Particles {
    let mut casts = IntersectionCounts::default();
    let caster = Caster::new(scene, bvh, settings.casts);
    let points = ViewPoints::new(scene, bvh, &caster, view, &mut casts);
    let candidates = along_a_curve(&shot.candidates, scene);
    let count = candidates.len().div_ceil(settings.candidates.max(1) as usize);
    let (brought, cast) = brought(&points, &candidates);
    casts += cast;
    let kept = pick(&candidates, &weights(&candidates, &brought, scene), count);
    let mut particles = settle(shot, kept, scene, settings);
    particles.casts += casts;
    particles
}

/// The candidates of a source and hit together, and in the order of Morton's curve (1966), so that neighbours in the
/// list are neighbours in space.
fn along_a_curve(candidates: &[Candidate], scene: &Scene) -> Vec<Candidate> {
    let bounds = scene.bounds();
    let scale = bounds.size().max(Vec3::splat(f32::MIN_POSITIVE)).recip();
    let code = |candidate: &Candidate| {
        let place = Vec3::from(candidate.light.place);
        let unit = match candidate.light.kind {
            DISTANT => 0.5 * place + 0.5,
            _ => (place - bounds.min) * scale,
        };
        morton((unit.clamp(Vec3::ZERO, Vec3::ONE) * 1023.0).as_uvec3().to_array())
    };
    let mut ordered: Vec<_> = candidates.iter().map(|candidate| (code(candidate), *candidate)).collect();
    ordered.sort_by_key(|(code, candidate)| (candidate.source, candidate.hit, *code));
    ordered.into_iter().map(|(_, candidate)| candidate).collect()
}

/// The ten bits of each coordinate, interleaved (Morton order).
fn morton(coordinates: [u32; 3]) -> u32 {
    (0..30).fold(0, |code, bit| code | (coordinates[bit % 3] >> (bit / 3) & 1) << bit)
}

fn brought(points: &ViewPoints, candidates: &[Candidate]) -> (Vec<Contribution>, IntersectionCounts) {
    if points.is_empty() {
        return (vec![Contribution::default(); candidates.len()], IntersectionCounts::default());
    }
    let pieces: Vec<Range<usize>> =
        (0..candidates.len()).step_by(PIECE).map(|first| first..candidates.len().min(first + PIECE)).collect();
    let work = |piece: &Range<usize>| {
        let mut casts = IntersectionCounts::default();
        let all: Vec<Contribution> =
            piece.clone().map(|index| points.brought(&candidates[index], index as u32, &mut casts)).collect();
        (all, casts)
    };
    let mut casts = IntersectionCounts::default();
    let mut all = Vec::with_capacity(candidates.len());
    for (brought, cast) in parallel::map(&pieces, work) {
        all.extend(brought);
        casts += cast;
    }
    (all, casts)
}

/// Chances of the candidates, up to a factor: the parts by their means.
fn weights(candidates: &[Candidate], brought: &[Contribution], scene: &Scene) -> Vec<f64> {
    // Of light from far away, what passes through a ball that holds the scene.
    let ball = PI * 0.25 * scene.bounds().size().length_squared();
    let flux = |candidate: &Candidate| candidate.power * if candidate.light.kind == DISTANT { ball } else { 1.0 };
    let mean = |part: &dyn Fn(usize) -> f32| {
        let sum: f64 = (0..candidates.len()).map(|index| f64::from(part(index))).sum();
        sum / candidates.len().max(1) as f64
    };
    let parts: [(f32, &dyn Fn(usize) -> f32); 3] = [
        (SHADOWED, &|index| brought[index].shadowed),
        (UNSHADOWED, &|index| brought[index].unshadowed),
        (FLUX, &|index| flux(&candidates[index])),
    ];
    let mut weights = vec![0.0; candidates.len()];
    for (share, part) in parts {
        let mean = mean(part);
        if mean > 0.0 && mean.is_finite() {
            let scale = f64::from(share) / mean;
            weights.iter_mut().enumerate().for_each(|(index, weight)| *weight += scale * f64::from(part(index)));
        }
    }
    weights
}

/// Steps through the sum of weights; what is stepped on more than once is one light that counts as often.
fn pick(candidates: &[Candidate], weights: &[f64], count: usize) -> Vec<Candidate> {
    let total: f64 = weights.iter().sum();
    let step = total / count.max(1) as f64;
    let mut kept = Vec::with_capacity(count);
    let (mut before, mut taken) = (0.0, 0_u64);
    for (candidate, weight) in candidates.iter().zip(weights) {
        before += weight;
        // Steps begin at their middles.
        let until = ((before / step + 0.5).floor() as u64).min(count as u64);
        if until > taken && *weight > 0.0 {
            let times = (until - taken) as f64;
            kept.push(candidate.stands_for((step / weight) as f32, (times * step / weight) as f32));
        }
        taken = taken.max(until);
    }
    kept
}

/// The lights in their order, with d_min.
fn settle(shot: &Shot, mut kept: Vec<Candidate>, scene: &Scene, settings: &InstantRadiosity) -> Particles {
    let mut particles = Particles {
        nearest: vec![0.0; scene.lights.len()],
        shot: shot.shot,
        casts: shot.casts,
        paths: shot.paths.clone(),
        reflectance: shot.reflectance,
        ..Default::default()
    };
    kept.sort_by_key(|candidate| (candidate.source, candidate.hit));
    for of_source in kept.chunk_by_mut(|a, b| a.source == b.source) {
        let nearest = set_nearest(of_source, settings.near_bound);
        let of_hit = |hit: u32| nearest.iter().find(|(of, _)| *of == hit).map_or(0.0, |(_, nearest)| *nearest);
        match shot.origins[of_source[0].source as usize] {
            Origin::Light(index) => particles.nearest[index] = of_hit(1),
            Origin::Emitters => particles.nearest_glow = of_hit(0),
            Origin::Sky => {}
        }
        particles.lights.extend(of_source.iter().map(|candidate| candidate.light));
    }
    particles
}

/// d_min of all lights of a source that come from the same hit: the bound times the distance between neighbours where
/// they are farthest apart, the root of the area that one stands for. By the number of the hit.
fn set_nearest(lights: &mut [Candidate], bound: f32) -> Vec<(u32, f32)> {
    let mut all: Vec<(u32, f32)> = Vec::new();
    for group in lights.chunk_by_mut(|a, b| a.hit == b.hit) {
        let mut areas: Vec<f32> = group.iter().map(|left| left.area).filter(|area| area.is_finite()).collect();
        areas.sort_unstable_by(f32::total_cmp);
        let spacing = areas.get((areas.len() as f32 * BOUNDED) as usize).map_or(0.0, |area| bound * area.sqrt());
        // Of later hits there are fewer, and they lie as far apart: a few whose ways were short do not tell how far.
        let nearest = all.last().map_or(spacing, |(_, before)| spacing.max(*before));
        group.iter_mut().for_each(|left| left.light.nearest = nearest);
        all.push((group[0].hit, nearest));
    }
    for left in lights {
        left.light.next = all.iter().find(|(hit, _)| *hit == left.hit + 1).map_or(0.0, |(_, nearest)| *nearest);
    }
    all
}

impl Candidate {
    /// The candidate as a light that stands for `share` candidates like it, and shines `scale` times as bright.
    fn stands_for(&self, share: f32, scale: f32) -> Self {
        let scaled = |light: [f32; 3]| light.map(|channel| channel * scale);
        let VirtualLight { intensity, flux, .. } = self.light;
        let light = VirtualLight { intensity: scaled(intensity), flux: scaled(flux), ..self.light };
        Self { light, area: self.area * share.max(1.0), power: self.power * scale, ..*self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn candidate(power: f32) -> Candidate {
        let light = VirtualLight { intensity: [power; 3], ..Default::default() };
        Candidate { source: 0, hit: 1, light, area: 1.0, power }
    }

    #[test]
    fn lights_in_proportion_to_their_chances_keep_their_sum() {
        let candidates: Vec<Candidate> = (1..=40).map(|power| candidate(power as f32)).collect();
        let weights: Vec<f64> = candidates.iter().map(|candidate| f64::from(candidate.power)).collect();
        let kept = pick(&candidates, &weights, 8);
        let sum = |lights: &[Candidate]| lights.iter().map(|light| light.light.intensity[0]).sum::<f32>();
        assert_eq!(kept.len(), 8);
        assert!((sum(&kept) - sum(&candidates)).abs() < 1e-3 * sum(&candidates), "{}", sum(&kept));
        // All alike: an eighth of what all send out. Together they stand for the area of all, about.
        assert!(kept.iter().all(|light| (light.power - 102.5).abs() < 1e-3), "{:?}", kept[0].power);
        let stands_for: f32 = kept.iter().map(|light| light.area).sum();
        assert!((30.0..=60.0).contains(&stands_for), "{stands_for}");
    }

    #[test]
    fn over_many_orders_the_sum_is_kept_whatever_the_chances() {
        let weights: Vec<f64> = (0..32).map(|i| 0.2 + f64::from(i * 7 % 32)).collect();
        let mut mean = 0.0;
        for turn in 0..32 {
            let mut order: Vec<usize> = (0..32).collect();
            order.rotate_left(turn);
            let candidates: Vec<Candidate> = order.iter().map(|&index| candidate(1.0 + index as f32)).collect();
            let weights: Vec<f64> = order.iter().map(|&index| weights[index]).collect();
            mean += pick(&candidates, &weights, 8).iter().map(|light| f64::from(light.power)).sum::<f64>() / 32.0;
        }
        assert!((mean - 528.0).abs() < 0.05 * 528.0, "{mean}");
    }

    #[test]
    fn what_is_stepped_on_twice_is_one_light_and_what_has_no_weight_none() {
        let candidates = [candidate(1.0), candidate(1.0), candidate(1.0)];
        let kept = pick(&candidates, &[0.0, 8.0, 0.0], 4);
        assert_eq!(kept.len(), 1);
        assert!((kept[0].power - 1.0).abs() < 1e-6 && kept[0].area == 1.0);
        assert!(pick(&candidates, &[0.0; 3], 4).is_empty());
        assert!(pick(&[], &[], 4).is_empty());
    }

    #[test]
    fn neighbours_on_the_curve_are_neighbours_in_space() {
        assert_eq!(morton([1, 0, 0]), 1);
        assert_eq!(morton([0, 1, 0]), 2);
        assert_eq!(morton([0, 0, 2]), 32);
        assert_eq!(morton([1023; 3]), (1 << 30) - 1);
    }
}
