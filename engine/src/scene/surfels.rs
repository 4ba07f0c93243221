//! Surfels: the scene's surfaces as pieces of equal area, for methods that scatter or gather light at surfaces.
//!
//! Where they lie follows from the mesh alone: each triangle gets its share by cumulative area, and within it the
//! points of the triangular van der Corput sequence (Basu and Owen 2015), of which any first n are spread evenly. Objects that
//! bend have the surfels of their mesh at rest, which stay on their triangles: they are the same in every pose.

mod bending;
#[cfg(test)]
mod fixture;
mod group;
mod openness;
mod patches;
mod samples;
mod still;
mod update;

pub use patches::{NO_PATCH, Patches, cells_from_world};
pub(crate) use samples::{texel, wall_extent};

use super::{Primitive, Scene};
use crate::assets::parallel;
use bending::Bending;
use bytemuck::{Pod, Zeroable};
use glam::{Affine3A, Vec3};
use group::{Group, GroupKey, groups};
use openness::Exposed;
use patches::Arranged;
use samples::Samples;
use std::collections::{HashMap, HashSet};
use std::ops::Range;
use std::sync::Arc;
use update::Updated;

/// Most surfels of a scene: 64 MiB.
pub const MAX_SURFELS: usize = 1 << 20;

/// Surfels a face of a cell.
const SURFELS_A_FACE: f32 = 8.0;

/// Thickness \[m\] of what has nothing behind it.
const ENDLESS: f32 = 1e30;

/// Cells that fit into what a closed double-sided mesh encloses from which on it is a room, as `ROOM` of
/// `lib/sweep.wgsl`.
const ROOM: f32 = 2.0;

/// Bit of [`Surfel::place`]: the inner side of what may be a room, as `INNER` of `lib/sweep.wgsl`.
const INNER: u32 = 1 << 31;

/// Where in [`Surfel::place`] the eight bits begin that tell how closed the surroundings are, as `CLOSED` of
/// `lib/sweep.wgsl`.
const CLOSED_SHIFT: u32 = 23;

/// The value of these bits for a surfel that lies in a crack or cavity.
const HIDDEN: u8 = 255;

/// A piece of surface, as `Surfel` of `lib/sweep.wgsl`. Position and normal are in object space, lengths and areas
/// are as in the world.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Surfel {
    /// Position in object space.
    pub position: [f32; 3],
    /// Area \[m²\], times alpha where the surface is blended.
    pub area: f32,
    /// Unit normal in object space, to the side that reflects.
    pub normal: [f32; 3],
    /// Thickness of the solid behind it \[m\]: the way along −n to the next surface of the same object. 0 for both
    /// sides of a sheet that can be seen from both, very large for the only side of one that cannot. Below 0 for both
    /// sides of a closed surface that can be seen from both: less the width of what it encloses, which is a room
    /// for cells that are small against it, and a solid for others.
    pub thickness: f32,
    /// Diffuse reflectance.
    pub albedo: [f32; 3],
    /// Index in [`SurfelCloud::places`], see [`Surfel::group`]; the highest bit is set on the inner side of a closed
    /// surface, and the eight after it tell how closed its surroundings are, see [`Surfel::openness`].
    pub place: u32,
    /// Emitted radiance [W/(m² sr)].
    pub emissive: [f32; 3],
    /// Largest cells \[m\] whose faces the object closes whole: the second largest edge of its box, 0 if it has holes.
    pub wall: f32,
}

impl Surfel {
    /// Index in [`SurfelCloud::places`].
    pub fn group(&self) -> usize {
        (self.place & ((1 << CLOSED_SHIFT) - 1)) as usize
    }

    /// Whether it lies in a crack or cavity, where light hardly gets.
    pub fn is_hidden(&self) -> bool {
        (self.place >> CLOSED_SHIFT) as u8 == HIDDEN
    }

    /// Share of the light about it that gets past what stands near it.
    pub fn openness(&self) -> f32 {
        1.0 - f32::from((self.place >> CLOSED_SHIFT) as u8) / 255.0
    }
}

/// The surfels of a scene.
#[derive(Debug, Default)]
pub struct SurfelCloud {
    /// All surfels, in the order of the scene's primitives.
    pub surfels: Vec<Surfel>,
    /// World from object space, one for each group of primitives that stand at the same place.
    pub places: Vec<Affine3A>,
    /// The surfels, grouped into patches.
    pub patches: Patches,
    /// Index in [`Self::places`] by that of the primitive in the scene; `u32::MAX` for those without surfels.
    pub place_of_primitive: Vec<u32>,
    /// Changes with every change of `surfels`, `patches` and `place_of_primitive`.
    pub revision: u64,
    /// Like `revision`, but unchanged where only objects were posed: [`Self::bending`] and [`Patches::bending`] count
    /// other changes then.
    pub rebuilt: u64,
    /// Changes where surfels and patches are others than before. The same numbers stand for the same ones of the same
    /// objects until then, wherever they are.
    pub layout: u64,
    /// Sum of area·reflectance over the sum of areas: the mean share of light that a surface returns. Objects that bend
    /// count as they are at rest.
    pub mean_albedo: Vec3,
    /// Flux that all surfaces emit \[W\]; objects that bend count at rest.
    pub emitted: Vec3,
    area: f64,
    /// Whether any surface emits light.
    pub is_emissive: bool,
    built: HashMap<GroupKey, Arc<Samples>>,
    state: Option<(u64, u64, u64, u32)>,
    exposed: Exposed,
    bent: Vec<Bending>,
    followed: Updated,
}

/// How fine the surfels are.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Fineness {
    /// Surfels a square metre.
    density: f32,
    /// Width from which on the inside of a closed double-sided mesh has surfels too \[m\].
    room: f32,
}

impl Fineness {
    /// For cells of a size \[m\] in a scene of an area \[m²\].
    fn new(cell: f32, area: f64) -> Self {
        Self { density: limited(SURFELS_A_FACE / cell / cell, area), room: ROOM * cell }
    }

    fn bits(&self) -> [u32; 2] {
        [self.density, self.room].map(f32::to_bits)
    }
}

impl SurfelCloud {
    /// Updates the surfels from the scene: as many as cells of a size \[m\] need, eight a face, fewer if
    /// there would be more than [`MAX_SURFELS`]. Costs nothing if nothing changed; an object that only moved or bent keeps its
    /// surfels, and where it is known to be moving no other one is looked at. What lies within a solid that does not move
    /// either has none.
    pub fn update(&mut self, scene: &Scene, cell: f32) {
        let revisions = scene.revisions;
        let state = (scene.identity, revisions.geometry, revisions.materials, cell.to_bits());
        if self.state == Some(state) {
            return;
        }
        self.state = Some(state);
        if self.follow(scene, cell) {
            return;
        }
        let (groups, place_of_primitive) = groups(scene);
        let area: f64 = groups.iter().map(Group::area).sum();
        let fineness = Fineness::new(cell, area);
        let keys: Vec<GroupKey> = groups.iter().map(|group| group.key(fineness)).collect();
        let samples = self.samples(&groups, &keys, fineness);
        self.places = groups.iter().map(|group| group.place).collect();
        let all = samples.iter().map(|samples| samples.surfels.clone()).collect();
        let exposed = self.exposed.update(scene, cell, &groups, &keys, all);
        let size = patches::patch_size(fineness.density);
        let before = std::mem::take(&mut self.patches.ranges);
        let arranged = self.patches.arrange(size, &self.exposed.subjects(&groups, &exposed, size));
        let mut surfels = numbered(&arranged);
        self.summarise(&surfels);
        let bent_before: Vec<_> = self.bending().collect();
        self.bent = Bending::all(scene, &groups, &keys, &samples, &arranged);
        self.pose_all(&groups, size, &mut surfels);
        let has_other_table = self.patches.collect(&arranged, &self.bent);
        self.followed.remember(scene, cell, &groups, area);
        let has_other_objects = place_of_primitive != self.place_of_primitive;
        let is_same = surfels == self.surfels && !has_other_objects;
        let is_posed = bent_before.into_iter().eq(self.bending());
        if has_other_objects || before != self.patches.ranges || !is_posed || !self.are_posed(&surfels) {
            self.layout += 1;
        }
        if !is_same || has_other_table {
            self.surfels = surfels;
            self.place_of_primitive = place_of_primitive;
            self.revision += 1;
            self.rebuilt = self.revision;
        }
    }

    /// The surfels of each group as its meshes are modelled.
    fn samples(&mut self, groups: &[Group], keys: &[GroupKey], fineness: Fineness) -> Vec<Arc<Samples>> {
        let used: HashSet<&GroupKey> = keys.iter().collect();
        self.built.retain(|key, _| used.contains(key));
        let missing: Vec<usize> = (0..groups.len()).filter(|&i| !self.built.contains_key(&keys[i])).collect();
        for (index, samples) in missing.iter().zip(parallel::map(&missing, |&i| Samples::new(&groups[i], fineness))) {
            self.built.insert(keys[*index].clone(), Arc::new(samples));
        }
        keys.iter().map(|key| self.built[key].clone()).collect()
    }

    /// Whether these are the surfels there are, or the same ones in another pose.
    fn are_posed(&self, surfels: &[Surfel]) -> bool {
        let is_same = |range: Range<usize>| surfels[range.clone()] == self.surfels[range];
        let has_same_surface = |range: Range<usize>| {
            let surface = |s: &Surfel| (s.albedo, s.emissive, s.place, s.wall, s.thickness);
            surfels[range.clone()].iter().map(surface).eq(self.surfels[range].iter().map(surface))
        };
        let mut next = 0;
        surfels.len() == self.surfels.len()
            && self.bending().all(|range| {
                let before = std::mem::replace(&mut next, range.end)..range.start;
                is_same(before) && has_same_surface(range)
            })
            && is_same(next..surfels.len())
    }

    /// Area of all surfels \[m²\].
    pub fn area(&self) -> f64 {
        self.area
    }

    fn summarise(&mut self, surfels: &[Surfel]) {
        let area: f64 = surfels.iter().map(|s| f64::from(s.area)).sum();
        self.area = area;
        let sum = |channel: usize| -> f64 {
            surfels.iter().map(|s| f64::from(s.albedo[channel]) * f64::from(s.area)).sum::<f64>()
        };
        let mean = |channel| if area > 0.0 { (sum(channel) / area) as f32 } else { 0.0 };
        self.mean_albedo = Vec3::new(mean(0), mean(1), mean(2));
        self.emitted = surfels.iter().map(|s| std::f32::consts::PI * s.area * Vec3::from(s.emissive)).sum();
        self.is_emissive = surfels.iter().any(|s| s.emissive != [0.0; 3]);
    }
}

/// All surfels, each with the index of its group.
fn numbered(objects: &[Arc<Arranged>]) -> Vec<Surfel> {
    let numbered = objects.iter().zip(0..).flat_map(|(object, group)| {
        object.surfels.iter().map(move |surfel| Surfel { place: group | surfel.place, ..*surfel })
    });
    numbered.collect()
}

fn has_surfels(primitive: &Primitive) -> bool {
    primitive.blocks_light() && primitive.world_from_object.is_finite()
}

/// The density with which the scene's area gives no more than [`MAX_SURFELS`], in steps of √2 so that a small change
/// of the scene changes none.
fn limited(density: f32, area: f64) -> f32 {
    let wanted = f64::from(density) * area;
    let most = MAX_SURFELS as f64 * 0.9;
    if wanted <= most {
        return density;
    }
    let steps = (2.0 * (wanted / most).log2()).ceil();
    (f64::from(density) * (-0.5 * steps).exp2()) as f32
}
