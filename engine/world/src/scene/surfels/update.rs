//! What is remembered of an update of all surfels, for those of dynamic objects.

use super::group::{Group, shape};
use crate::assets::AssetId;
use crate::scene::Scene;
use glam::Affine3A;
use std::collections::HashSet;

/// Results of the update of all surfels that updates of dynamic objects reuse.
#[derive(Debug, Default)]
pub(super) struct Updated {
    pub state: Option<[u64; 4]>,
    pub geometry: u64,
    /// Area of all groups \[m²\].
    pub area: f64,
    pub movers: Vec<Mover>,
}

/// A moving primitive that does not bend.
#[derive(Debug)]
pub(super) struct Mover {
    /// Its place among the scene's primitives.
    pub primitive: usize,
    /// Its group, and the linear part that the surfels there are made with; none if it has no surfels.
    pub group: Option<(usize, [u32; 9])>,
    /// Whether it has the group for itself.
    pub alone: bool,
    pub mesh: AssetId,
}

/// All but the geometry of dynamic objects; none in scenes that do not tell what does.
pub(super) fn state(scene: &Scene, cell: f32) -> Option<[u64; 4]> {
    let revisions = scene.revisions;
    (revisions.statics != 0)
        .then(|| [scene.identity, revisions.statics, revisions.materials, u64::from(cell.to_bits())])
}

pub(super) fn shape_bits(place: &Affine3A) -> [u32; 9] {
    shape(place).to_cols_array().map(f32::to_bits)
}

impl Updated {
    /// Remembers what all surfels were made of.
    pub(super) fn remember(&mut self, scene: &Scene, cell: f32, groups: &[Group], area: f64) {
        let mut movers: Vec<Mover> = scene
            .primitives
            .iter()
            .enumerate()
            .filter(|(_, p)| p.moving)
            .map(|(primitive, p)| Mover { primitive, group: None, alone: false, mesh: p.mesh.id })
            .collect();
        let mut bending = HashSet::new();
        for (index, group) in groups.iter().enumerate() {
            for member in group.members.iter().filter(|member| member.moving) {
                let place = movers.binary_search_by_key(&member.id, |mover| scene.primitives[mover.primitive].id);
                let Ok(mover) = place else { continue };
                if group.is_bending {
                    bending.insert(movers[mover].primitive);
                }
                movers[mover].group = Some((index, shape_bits(&group.place)));
                movers[mover].alone = group.members.len() == 1;
            }
        }
        movers.retain(|mover| !bending.contains(&mover.primitive));
        *self = Self { state: state(scene, cell), geometry: scene.revisions.geometry, area, movers };
    }
}
