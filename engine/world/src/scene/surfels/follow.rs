//! Surfels of a scene in which nothing changed but where some objects stand.

use super::cloud::SurfelCloud;
use super::group::place_bits;
use super::surfel::{Fineness, has_surfels};
use super::update::{Mover, shape_bits, state};
use crate::scene::Scene;
use glam::Affine3A;
use std::collections::HashSet;

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
        // The same of one that is longer than it is wide, at the second turn.
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
