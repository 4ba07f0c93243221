//! Points that the camera sees, and how much a virtual light contributes to them.

use super::intersection::{Caster, IntersectionCounts};
use super::random::hash_pair;
use super::surface::on_triangle;
use super::trace_particles::{Candidate, DISTANT};
use crate::bvh::Ray;
use crate::scene::SceneBvh;
use crate::scene::{Scene, SceneView};
use glam::Vec3;
use std::f32::consts::PI;

/// Points of an image.
const POINTS: u32 = 64;
/// Rays from a light to points of the image.
const RAYS: u32 = 4;
/// A ray that comes so near to its end, over its length, has arrived.
const ARRIVED: f32 = 0.999;

struct ViewPoint {
    /// Off the surface by the error of its place \[m\].
    position: Vec3,
    normal: Vec3,
    /// Mean of the channels of what it reflects of all light.
    reflectance: f32,
}

/// What the camera sees, by some points of the image.
pub(super) struct ViewPoints<'a> {
    caster: &'a Caster<'a>,
    points: Vec<ViewPoint>,
}

/// The contribution of a light to the points: the mean of what they reflect [W/m²].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Contribution {
    /// If nothing is between.
    pub(super) unshadowed: f32,
    pub(super) shadowed: f32,
}

impl<'a> ViewPoints<'a> {
    /// Looks along lines of sight that are spread evenly over the image (the R2 sequence, Roberts 2018).
    pub(super) fn new(
        scene: &Scene,
        bvh: &SceneBvh,
        caster: &'a Caster,
        view: &SceneView,
        casts: &mut IntersectionCounts,
    ) -> Self {
        let world_from_clip = view.world_from_clip();
        let eye = view.eye_point();
        let point = |index: u32| {
            let at = |ratio: f32| (0.5 + ratio * index as f32).fract() * 2.0 - 1.0;
            // The near plane: depth is reversed.
            let near = world_from_clip.project_point3(Vec3::new(at(0.754_877_7), at(0.569_840_3), 1.0));
            let direction = (eye.w * near - eye.truncate()).normalize_or_zero();
            let origin = near;
            let hit = caster.cast(&Ray::new(origin, direction), casts)?;
            let met = on_triangle(scene, bvh, hit.triangle, hit.barycentric, direction)?;
            let cosine = -direction.dot(met.geometric_normal);
            let reflectance = met.reflectance(cosine).element_sum() / 3.0;
            let position = met.position + met.geometric_normal * (4.0 * met.error);
            Some(ViewPoint { position, normal: met.normal, reflectance })
        };
        Self { points: (0..POINTS).filter_map(point).collect(), caster }
    }

    /// Whether the camera sees nothing that reflects light.
    pub(super) fn is_empty(&self) -> bool {
        !self.points.iter().any(|point| point.reflectance > 0.0)
    }

    /// The contribution of a candidate. Rays go to points in proportion to what it would contribute there, so that the share of those
    /// which arrive is the share of its light that does.
    pub(super) fn brought(&self, candidate: &Candidate, index: u32, casts: &mut IntersectionCounts) -> Contribution {
        let each: Vec<f32> = self.points.iter().map(|point| unshadowed(candidate, point)).collect();
        let total: f32 = each.iter().sum();
        if !(total > 0.0 && total.is_finite()) {
            return Contribution::default();
        }
        let first = hash_pair(index, 0) as f32 / u32::MAX as f32;
        let mut before = 0.0;
        let (mut ray, mut arrived) = (0, 0);
        for (point, own) in self.points.iter().zip(&each) {
            before += own;
            let mut passes = None;
            while ray < RAYS && (ray as f32 + first) * total < before * RAYS as f32 {
                arrived += u32::from(*passes.get_or_insert_with(|| self.passes(candidate, point, casts)));
                ray += 1;
            }
        }
        let unshadowed = total / self.points.len() as f32;
        Contribution { unshadowed, shadowed: unshadowed * arrived as f32 / RAYS as f32 }
    }

    fn passes(&self, candidate: &Candidate, point: &ViewPoint, casts: &mut IntersectionCounts) -> bool {
        let light = &candidate.light;
        let place = Vec3::from(light.place);
        let distant = light.kind == DISTANT;
        let way = if distant { place } else { place + Vec3::from(light.normal) * light.offset - point.position };
        let hit = self.caster.cast(&Ray::new(point.position, way), casts);
        hit.is_none_or(|hit| !distant && hit.t > ARRIVED)
    }
}

/// ρ·Φ/π·cosθ·cosθ_i/max(d², A), where A is the area of surface that the light stands for: within it 1/d² is no measure
/// of its contribution.
fn unshadowed(candidate: &Candidate, point: &ViewPoint) -> f32 {
    let light = &candidate.light;
    let place = Vec3::from(light.place);
    if light.kind == DISTANT {
        return point.reflectance * candidate.power * point.normal.dot(place).max(0.0);
    }
    let offset = place - point.position;
    let squared = offset.length_squared();
    let to_light = offset / squared.sqrt().max(f32::MIN_POSITIVE);
    let cosines = point.normal.dot(to_light).max(0.0) * -Vec3::from(light.normal).dot(to_light).min(0.0);
    let nearest = if candidate.area.is_finite() { candidate.area } else { 0.0 };
    point.reflectance * candidate.power / PI * cosines / squared.max(nearest).max(f32::MIN_POSITIVE)
}
