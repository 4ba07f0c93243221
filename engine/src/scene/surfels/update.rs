//! Surfels of a scene in which nothing changed but where some objects stand.

use super::SurfelCloud;
use super::group::{Group, place_bits, shape};
use super::surfel::{Fineness, has_surfels};
use crate::assets::AssetId;
use crate::scene::Scene;
use glam::Affine3A;
use std::collections::HashSet;

/// Results of the update of all surfels that updates of dynamic objects reuse.
#[derive(Debug, Default)]
pub(super) struct Updated {
    state: Option<[u64; 4]>,
    geometry: u64,
    /// Area of all groups \[m²\].
    area: f64,
    movers: Vec<Mover>,
}

/// A moving primitive that does not bend.
#[derive(Debug)]
struct Mover {
    /// Its place among the scene's primitives.
    primitive: usize,
    /// Its group, and the linear part that the surfels there are made with; none if it has no surfels.
    group: Option<(usize, [u32; 9])>,
    /// Whether it has the group for itself.
    alone: bool,
    mesh: AssetId,
}

/// All but the geometry of dynamic objects; none in scenes that do not tell what does.
fn state(scene: &Scene, cell: f32) -> Option<[u64; 4]> {
    let revisions = scene.revisions;
    (revisions.statics != 0)
        .then(|| [scene.identity, revisions.statics, revisions.materials, u64::from(cell.to_bits())])
}

fn shape_bits(place: &Affine3A) -> [u32; 9] {
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

impl SurfelCloud {
    /// Updates places and poses if nothing else changed, and then only dynamic objects are looked at. False if it
    /// takes more: another mesh or size, objects that come to stand at the same place, or apart.
    pub(super) fn follow(&mut self, scene: &Scene, cell: f32) -> bool {
        let known = &self.followed;
        let is_known = known.state.is_some() && known.state == state(scene, cell);
        // A sum of areas differs in its last bits when objects turn: that must not decide how many surfels there are.
        if !is_known || Fineness::new(cell, 0.999 * known.area) != Fineness::new(cell, 1.001 * known.area) {
            return false;
        }
        let has_changed = |mover: &&Mover| scene.primitives[mover.primitive].geometry_revision > known.geometry;
        let changed: Vec<&Mover> = known.movers.iter().filter(has_changed).collect();
        let mut taken: HashSet<[u32; 12]> = HashSet::new();
        if !changed.is_empty() {
            taken.extend(self.places.iter().map(place_bits));
        }
        let mut moved: Vec<(usize, Affine3A)> = Vec::new();
        for mover in changed {
            let primitive = &scene.primitives[mover.primitive];
            let place = primitive.world_from_object;
            match mover.group {
                None if !has_surfels(primitive) => {}
                Some((group, shape))
                    if has_surfels(primitive)
                        && mover.alone
                        && mover.mesh == primitive.mesh.id
                        && shape == shape_bits(&place)
                        && taken.insert(place_bits(&place)) =>
                {
                    moved.push((group, place));
                }
                _ => return false,
            }
        }
        for (group, place) in moved {
            self.places[group] = place;
        }
        let (fineness, since) = (Fineness::new(cell, self.followed.area), self.followed.geometry);
        if !self.follow_poses(scene, fineness, since) {
            return false;
        }
        self.followed.geometry = scene.revisions.geometry;
        true
    }
}

#[cfg(test)]
mod tests {
    use super::super::fixture;
    use super::*;
    use crate::assets::Shape;
    use crate::scene::{Primitive, Revisions};
    use glam::{Quat, Vec3};
    use std::sync::Arc;

    /// Five boxes in a row, the last two of which move.
    fn row() -> Scene {
        let mesh = Arc::new(Shape::Box { size: [1.0; 3] }.mesh().expect("a valid shape"));
        let primitive = |index: u64| {
            let place = Affine3A::from_translation(Vec3::X * (2 * index) as f32);
            Primitive { moving: index > 2, ..fixture::primitive(index + 1, mesh.clone(), place) }
        };
        let revisions = Revisions { geometry: 1, materials: 1, statics: 1, ..Revisions::default() };
        Scene { identity: 1, primitives: (0..5).map(primitive).collect(), revisions, ..Scene::default() }
    }

    fn put(scene: &mut Scene, index: usize, place: Affine3A) {
        scene.revisions.geometry += 1;
        let primitive = &mut scene.primitives[index];
        (primitive.world_from_object, primitive.geometry_revision) = (place, scene.revisions.geometry);
    }

    /// Updates, and compares with what is made from nothing. Whether it followed.
    fn update(cloud: &mut SurfelCloud, scene: &Scene) -> bool {
        let follows = cloud.follow(scene, 0.6);
        cloud.update(scene, 0.6);
        let mut afresh = SurfelCloud::default();
        afresh.update(scene, 0.6);
        assert!(cloud.surfels == afresh.surfels && cloud.places == afresh.places);
        follows
    }

    #[test]
    fn what_moves_alone_is_followed_and_all_else_is_made_anew() {
        let (mut scene, mut cloud) = (row(), SurfelCloud::default());
        assert!(!update(&mut cloud, &scene));
        let turned = Affine3A::from_rotation_translation(Quat::from_rotation_y(0.5), Vec3::new(6.0, 1.0, 0.0));
        put(&mut scene, 3, turned);
        assert!(update(&mut cloud, &scene));
        assert_eq!(cloud.places[3], turned);
        // At the same place as another one they make one object.
        put(&mut scene, 4, turned);
        assert!(!update(&mut cloud, &scene));
        put(&mut scene, 4, Affine3A::from_translation(Vec3::Y));
        assert!(!update(&mut cloud, &scene));
        put(&mut scene, 4, Affine3A::from_scale_rotation_translation(Vec3::splat(2.0), Quat::IDENTITY, Vec3::Z));
        assert!(!update(&mut cloud, &scene));
        put(&mut scene, 4, Affine3A::from_scale_rotation_translation(Vec3::splat(2.0), Quat::IDENTITY, Vec3::Y));
        assert!(update(&mut cloud, &scene));
        // With a scale for each axis: the change of scale rebuilds, the turn after it does not.
        let long = |angle: f32| {
            Affine3A::from_scale_rotation_translation(Vec3::new(2.0, 1.0, 0.5), Quat::from_rotation_y(angle), Vec3::Y)
        };
        put(&mut scene, 4, long(0.3));
        assert!(!update(&mut cloud, &scene));
        put(&mut scene, 4, long(1.1));
        assert!(update(&mut cloud, &scene));
        scene.primitives[4].casts_shadow = false;
        put(&mut scene, 4, Affine3A::IDENTITY);
        assert!(!update(&mut cloud, &scene));
        put(&mut scene, 4, Affine3A::from_translation(Vec3::NEG_Y));
        assert!(update(&mut cloud, &scene));
        scene.revisions.materials += 1;
        assert!(!update(&mut cloud, &scene));
    }
}
