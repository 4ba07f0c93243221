//! Surfels: the scene's surfaces as pieces of equal area, for methods that scatter or gather light at surfaces.
//!
//! Where they lie follows from the mesh alone: each triangle gets its share by cumulative area, and within it the
//! points of the triangular van der Corput sequence (Basu and Owen 2015), of which any first n are spread evenly. Objects that
//! bend have the surfels of their mesh at rest, which stay on their triangles: they are the same in every pose.

mod bending;
mod cloud;
#[cfg(test)]
mod fixture;
mod follow;
mod group;
mod openness;
mod patches;
mod posing;
mod samples;
mod still;
mod surfel;
mod update;

pub use cloud::SurfelCloud;
pub use patches::{NO_PATCH, Patches, cells_from_world};
#[doc(hidden)]
pub use samples::{texel, wall_extent};
pub use surfel::{MAX_SURFELS, Surfel};

use super::Scene;
use crate::assets::parallel;
use bending::Bending;
use glam::Vec3;
use group::{Group, GroupKey, groups};
use patches::Arranged;
use samples::Samples;
use std::collections::HashSet;
use std::ops::Range;
use std::sync::Arc;
use surfel::Fineness;

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
