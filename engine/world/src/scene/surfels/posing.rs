//! Poses of the objects that bend.

use super::bending::Bending;
use super::cloud::SurfelCloud;
use super::group::{Group, place_bits};
use super::surfel::{Fineness, Surfel};
use crate::assets::parallel;
use crate::scene::Scene;
use glam::Affine3A;
use std::ops::Range;

impl SurfelCloud {
    /// Poses all objects that bend.
    pub(super) fn pose_all(&mut self, groups: &[Group], size: f32, surfels: &mut [Surfel]) {
        let poses = parallel::map(&self.bent, |bent| bent.posed(&groups[bent.group], size));
        for (bent, pose) in self.bent.iter_mut().zip(poses) {
            surfels[bent.surfels.clone()].copy_from_slice(&pose.surfels);
            bent.cells = pose.cells;
        }
    }

    /// Poses the objects again that have bent since a revision of the geometry. False if an object is another one.
    pub(super) fn follow_poses(&mut self, scene: &Scene, fineness: Fineness, since: u64) -> bool {
        let mut changed: Vec<(usize, Group)> = Vec::new();
        for (index, bent) in self.bent.iter().enumerate().filter(|(_, bent)| bent.has_changed(scene, since)) {
            let Some(group) = bent.object(scene, fineness) else { return false };
            changed.push((index, group));
        }
        if changed.is_empty() {
            return true;
        }
        let size = self.patches.size;
        let poses = parallel::map(&changed, |(index, group)| self.bent[*index].posed(group, size));
        for ((index, group), pose) in changed.iter().zip(poses) {
            let bent = &mut self.bent[*index];
            self.surfels[bent.surfels.clone()].copy_from_slice(&pose.surfels);
            self.places[bent.group] = group.place;
            bent.cells = pose.cells;
        }
        self.revision += 1;
        self.stand_apart() && self.patches.bend(&self.bent)
    }

    /// Whether no two of the objects that bend stand at the same place, where they would be one.
    fn stand_apart(&self) -> bool {
        let place = |bent: &Bending| -> Affine3A { self.places[bent.group] };
        let mut places: Vec<_> = self.bent.iter().map(|bent| place_bits(&place(bent))).collect();
        places.sort_unstable();
        places.windows(2).all(|pair| pair[0] != pair[1])
    }

    /// The surfels of objects that bend, object after object.
    pub fn bending(&self) -> impl Iterator<Item = Range<usize>> + '_ {
        self.bent.iter().map(|bent| bent.surfels.clone())
    }
}
