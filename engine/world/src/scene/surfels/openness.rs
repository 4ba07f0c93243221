//! How open the surroundings of surfels are. Cells tell what light there is about a surfel, but not what stands between:
//! under a bench there is less than above it. And scenes are put together of objects that stand within each other: a
//! column's foot in the floor, and the floor below it, would claim light that never reaches them.
//!
//! A few rays a surfel tell both, as for ambient obscurance (Zhukov, Iones and Kronin 1998, "An ambient light illumination
//! model"): what they meet within the reach of a cell gives back a part of the light.

use super::group::{Group, GroupKey};
use super::patches::{Occluders, Subject};
use super::still::Still;
use super::surfel::{CLOSED_SHIFT, HIDDEN, Surfel};
use crate::assets::{AlphaMode, AssetId, parallel};
use crate::bvh::Ray;
use crate::scene::world_normal;
use crate::scene::{Aabb, Primitive, Scene};
use glam::{Affine3A, Vec3};
use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;

/// Surfels that are looked at together.
const CHUNK: usize = 4096;
/// How far before a surfel its rays start \[cells\]: where two surfaces coincide, each is behind the other.
const BEFORE: f32 = 0.001;
/// Distance within which cells do not know what is in the way \[cells\]. It matters little, since what the surfels have is
/// calibrated by even light, in which the same is in their way: the error of `cathedral` at `Medium` without rays is .232
/// with 1 and .228 with 2, that of `meeting_room` .183 and .181.
const REACH: f32 = 2.0;
/// Share of the light that comes from what is in the way: its reflectance, of which nothing is known here, so that another
/// colour of one surface changes nothing around it.
const NEAR: f32 = 0.5;
/// Distance that some ray of a surfel must get to, or it lies in a crack or cavity that light hardly finds \[cells\].
const LEAST_REACH: f32 = 1.0;
/// Rays of a surfel.
const RAYS: u8 = 8;
/// From so many objects that come or go at once on, all surfels are recomputed, and not only those that see them.
const MANY: usize = 16;

/// The surfels of static objects, without those that no light can reach. Where static objects change, the
/// surfels that see the change are checked again, and none if it is the colour of a material.
#[derive(Debug, Default)]
pub(super) struct Exposed {
    scene: u64,
    cell: f32,
    still: Still,
    /// Boxes of what changed in the last update.
    changed: Vec<Aabb>,
    /// By the places of groups.
    groups: HashMap<[u32; 12], Known>,
}

/// The known openness of a group.
#[derive(Debug)]
struct Known {
    spread: Spread,
    around: Vec<Around>,
    all: Arc<Vec<Surfel>>,
    left: Arc<Vec<Surfel>>,
}

/// All that it depends on where the surfels of a group lie.
#[derive(Debug, PartialEq)]
struct Spread {
    /// Meshes, whether they have two sides, and the materials that cut holes into them.
    members: Vec<(AssetId, bool, Option<AssetId>)>,
    linear: [u32; 9],
    fineness: [u32; 2],
}

impl Spread {
    fn new(group: &Group, key: &GroupKey) -> Self {
        let member = |member: &&Primitive| {
            let material = &member.material;
            let holes = (material.alpha_mode != AlphaMode::Opaque).then_some(material.id);
            (member.mesh.id, material.double_sided, holes)
        };
        Self { members: group.members.iter().map(member).collect(), linear: key.linear, fineness: key.fineness }
    }
}

/// The surroundings of a surfel.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Around {
    /// Nothing but the inside of solids: no light ever comes here.
    Solid,
    /// How much is closed, of 255; that is [`HIDDEN`].
    Closed(u8),
}

impl Exposed {
    /// How far before a surfel its rays start \[m\].
    fn before(&self) -> f32 {
        BEFORE * self.cell
    }

    /// Removes buried surfels from `all` surfels of each group, for cells of a size \[m\].
    pub fn update(
        &mut self,
        scene: &Scene,
        cell: f32,
        groups: &[Group],
        keys: &[GroupKey],
        all: Vec<Arc<Vec<Surfel>>>,
    ) -> Vec<Arc<Vec<Surfel>>> {
        if self.scene != scene.identity || self.cell.to_bits() != cell.to_bits() {
            *self = Self { scene: scene.identity, cell, ..Self::default() };
        }
        let changed = self.still.update(scene);
        self.changed.clone_from(&changed);
        let mut before = std::mem::take(&mut self.groups);
        let (mut pieces, mut known) = (Vec::new(), Vec::with_capacity(groups.len()));
        for (index, (group, all)) in groups.iter().zip(&all).enumerate() {
            let spread = Spread::new(group, &keys[index]);
            // Deformed objects may share a place with others.
            let of_group = if is_still(group) { before.remove(&place(group)) } else { None };
            let of_group = of_group.filter(|known| known.is_of(&spread, all));
            if is_still(group) && !(of_group.is_some() && changed.is_empty()) {
                let firsts = (0..all.len()).step_by(CHUNK);
                pieces.extend(firsts.map(|first| (index, first..all.len().min(first + CHUNK))));
            }
            known.push(of_group);
        }
        // Many small objects share the cores as few large ones do.
        let look = |(index, piece): &(usize, Range<usize>)| {
            let known = known[*index].as_ref().filter(|_| changed.len() < MANY);
            let known = known.map(|known| &known.around[piece.clone()]);
            self.look(&all[*index], piece, &groups[*index].place, known, &changed)
        };
        let mut looked: HashMap<usize, Vec<Around>> = HashMap::new();
        for ((index, _), around) in pieces.iter().zip(parallel::map(&pieces, look)) {
            looked.entry(*index).or_default().extend(around);
        }
        let mut left = Vec::with_capacity(groups.len());
        for (index, ((group, all), known)) in groups.iter().zip(all).zip(known).enumerate() {
            if !is_still(group) {
                left.push(all);
                continue;
            }
            let known = match (known, looked.remove(&index)) {
                (Some(known), looked) if known.holds(&all, looked.as_deref()) => known,
                (known, looked) => {
                    let around = looked.or(known.map(|known| known.around)).unwrap_or_default();
                    let left = Arc::new(exposed(&all, &around));
                    Known { spread: Spread::new(group, &keys[index]), around, all, left }
                }
            };
            left.push(known.left.clone());
            self.groups.insert(place(group), known);
        }
        left
    }

    /// The surfels of groups for patches of a size \[m\], with what stands around each.
    pub fn subjects<'a>(&'a self, groups: &[Group], surfels: &'a [Arc<Vec<Surfel>>], size: f32) -> Vec<Subject<'a>> {
        groups.iter().zip(surfels).map(|(group, surfels)| self.subject(group, surfels, size)).collect()
    }

    fn subject<'a>(&'a self, group: &Group, surfels: &'a Arc<Vec<Surfel>>, size: f32) -> Subject<'a> {
        let occluders = is_still(group).then(|| Occluders::new(&self.still, group.place, size, self.before()));
        let bounds = group.members.iter().fold(Aabb::EMPTY, |sum, member| sum.union(&member.bounds));
        let reach = Vec3::splat(size);
        let near = Aabb { min: bounds.min - reach, max: bounds.max + reach };
        let is_changed = occluders.is_some() && self.changed.iter().any(|other| !near.intersection(other).is_empty());
        Subject { surfels, shape: group.shape(), occluders, is_changed }
    }

    /// The surroundings of a part of a group's surfels; what was known before a change is reused.
    fn look(
        &self,
        surfels: &[Surfel],
        piece: &Range<usize>,
        place: &Affine3A,
        known: Option<&[Around]>,
        changed: &[Aabb],
    ) -> Vec<Around> {
        let look = |index: usize| {
            let rays = rays(&surfels[index], index, place, self.cell);
            let sees = |ray: &Ray| changed.iter().any(|bounds| ray.enters(bounds, f32::INFINITY).is_some());
            match known {
                Some(known) if !rays.iter().flatten().any(sees) => known[index - piece.start],
                _ => self.around(rays),
            }
        };
        piece.clone().map(look).collect()
    }

    fn around(&self, rays: Option<[Ray; RAYS as usize]>) -> Around {
        let Some(rays) = rays else { return Around::Closed(0) };
        let looks = rays.each_ref().map(|ray| self.along(ray));
        // Where solids overlap a ray from within one may meet the front of another before the back of its own.
        if looks.iter().any(|look| look.is_back) {
            let within = rays.iter().filter(|ray| self.still.is_within(ray)).count();
            if 4 * within >= 3 * rays.len() {
                return Around::Solid;
            }
        }
        if looks.iter().all(|look| look.distance < LEAST_REACH * self.cell) {
            return Around::Closed(HIDDEN);
        }
        let open = looks.iter().map(|look| look.light).sum::<f32>() / f32::from(RAYS);
        Around::Closed(((255.0 * (1.0 - open)).round() as u8).min(HIDDEN - 1))
    }

    fn along(&self, ray: &Ray) -> Look {
        let Some(met) = self.still.closest(ray) else {
            return Look { distance: f32::INFINITY, is_back: false, light: 1.0 };
        };
        let light = match met.is_back {
            _ if met.t >= REACH * self.cell => 1.0,
            true => 0.0,
            false => NEAR,
        };
        Look { distance: met.t, is_back: met.is_back, light }
    }
}

impl Known {
    /// Whether what is around these surfels is known, or was before a change.
    fn is_of(&self, spread: &Spread, all: &[Surfel]) -> bool {
        self.spread == *spread && self.around.len() == all.len()
    }

    /// Whether these are the surfels, and what was recomputed is as before.
    fn holds(&self, all: &Arc<Vec<Surfel>>, looked: Option<&[Around]>) -> bool {
        Arc::ptr_eq(&self.all, all) && looked.is_none_or(|looked| looked == self.around)
    }
}

fn is_still(group: &Group) -> bool {
    !group.members.iter().any(|member| member.moving)
}

/// Bits of where a group stands; no other one stands there.
fn place(group: &Group) -> [u32; 12] {
    group.place.to_cols_array().map(f32::to_bits)
}

/// The surfels that light can reach, with how closed their surroundings are.
fn exposed(surfels: &[Surfel], around: &[Around]) -> Vec<Surfel> {
    let exposed = surfels.iter().zip(around).filter_map(|(surfel, around)| match around {
        Around::Solid => None,
        Around::Closed(closed) => Some(Surfel { place: surfel.place | u32::from(*closed) << CLOSED_SHIFT, ..*surfel }),
    });
    exposed.collect()
}

/// The rays of a surfel; none if it has no normal.
fn rays(surfel: &Surfel, index: usize, place: &Affine3A, cell: f32) -> Option<[Ray; RAYS as usize]> {
    let normal = world_normal(place, surfel.normal.into());
    if normal == Vec3::ZERO {
        return None;
    }
    let point = place.transform_point3(surfel.position.into());
    let start = point + normal * (BEFORE * cell + 1e-5 * point.abs().max_element());
    // A tangent of the object, so that its turned copies are looked at alike.
    let tangent = place.transform_vector3(Vec3::from(surfel.normal).any_orthonormal_vector());
    let u = tangent.reject_from_normalized(normal).try_normalize().unwrap_or(normal.any_orthonormal_vector());
    let axes = [u, normal.cross(u), normal];
    Some(std::array::from_fn(|ray| Ray::new(start, direction(axes, ray as u8, index))))
}

/// The result of a ray.
struct Look {
    /// \[m\].
    distance: f32,
    /// The back of a surface of which only the front can be seen.
    is_back: bool,
    /// Share of the light that comes from there.
    light: f32,
}

/// One of the directions about the last axis of a frame, distributed as their cosines: a spiral, turned from surfel to
/// surfel.
fn direction([u, v, normal]: [Vec3; 3], ray: u8, index: usize) -> Vec3 {
    // Fractions of a turn: the golden ratio along the spiral, and the plastic number from one spiral to the next.
    let turn = f32::from(ray) * 0.618_034 + (index % 4096) as f32 * 0.754_877_7;
    let (sin, cos) = (std::f32::consts::TAU * turn.fract()).sin_cos();
    let share = (f32::from(ray) + 0.5) / f32::from(RAYS);
    (1.0 - share).sqrt() * normal + share.sqrt() * (cos * u + sin * v)
}

#[cfg(test)]
mod tests;
