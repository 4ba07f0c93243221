#![allow(clippy::unwrap_used)]

use super::*;
use crate::assets::{Material, Mesh, Shape};
use crate::bvh::tests::{boxes_of, point, ray};
use crate::bvh::{Bvh, Ray};
use crate::scene::{Primitive, Scene, SceneId};
use glam::{Affine3A, Quat, Vec3};
use proptest::prelude::*;
use std::sync::Arc;

/// Along the axes, or any way.
fn turn() -> impl Strategy<Value = Quat> {
    prop_oneof![Just(Quat::IDENTITY), point(3.0).prop_map(Quat::from_scaled_axis)]
}

fn primitive(id: u64, mesh: &Arc<Mesh>, transform: Affine3A) -> Primitive {
    Primitive {
        id: SceneId(id),
        mesh: mesh.clone(),
        material: Arc::new(Material::new("m")),
        world_from_object: transform,
        bounds: mesh.bounds.transformed(&transform),
        casts_shadow: true,
        moving: false,
        geometry_revision: 0,
        material_revision: 0,
    }
}

#[test]
fn hits_come_in_world_space_and_backs_are_for_light_alone() {
    let cube = Arc::new(Shape::Box { size: [1.0; 3] }.mesh().unwrap());
    let at = |x: f32| Affine3A::from_scale_rotation_translation(Vec3::splat(2.0), Quat::IDENTITY, Vec3::X * x);
    let scene =
        Scene { primitives: vec![primitive(1, &cube, at(5.0)), primitive(2, &cube, at(9.0))], ..Scene::default() };
    let bvh = SceneBvh::new(&scene);
    let ray = Ray::new(Vec3::new(0.0, 0.1, 0.2), Vec3::X);
    let hit = bvh.closest_hit(&ray, f32::INFINITY, RayKind::Light).unwrap();
    assert_eq!((hit.t, bvh.triangles[hit.triangle as usize].primitive), (4.0, 0));
    assert!(bvh.is_blocked(&ray, 4.1) && !bvh.is_blocked(&ray, 3.9));
    // From inside, the camera looks through the back face and meets the next cube.
    let inside = Ray::new(Vec3::new(5.0, 0.1, 0.2), Vec3::X);
    assert_eq!(bvh.closest_hit(&inside, f32::INFINITY, RayKind::Camera).map(|hit| hit.t), Some(3.0));
    assert_eq!(bvh.closest_hit(&inside, f32::INFINITY, RayKind::Light).map(|hit| hit.t), Some(1.0));
}

#[test]
fn flattened_and_mirrored_objects_are_met() {
    let cube = Arc::new(Shape::Box { size: [1.0; 3] }.mesh().unwrap());
    let flat = Affine3A::from_scale(Vec3::new(2.0, 0.0, 2.0));
    let mirrored = Affine3A::from_scale_rotation_translation(Vec3::new(-1.0, 1.0, 1.0), Quat::IDENTITY, Vec3::Y * -3.0);
    let nothing = Affine3A::from_scale(Vec3::ZERO);
    let primitives = vec![primitive(1, &cube, flat), primitive(2, &cube, mirrored), primitive(3, &cube, nothing)];
    let bvh = SceneBvh::new(&Scene { primitives, ..Scene::default() });
    let down = Ray::new(Vec3::new(0.2, 4.0, 0.1), Vec3::NEG_Y);
    assert_eq!(bvh.closest_hit(&down, f32::INFINITY, RayKind::Light).map(|hit| hit.t), Some(4.0));
    let up = Ray::new(Vec3::new(0.2, -8.0, 0.1), Vec3::Y);
    assert_eq!(bvh.closest_hit(&up, f32::INFINITY, RayKind::Camera).map(|hit| hit.t), Some(4.5));
}

#[test]
fn moved_objects_are_refitted_until_that_is_too_slow() {
    let cube = Arc::new(Shape::Box { size: [1.0; 3] }.mesh().unwrap());
    let place = |i: u64| Affine3A::from_translation(Vec3::X * 3.0 * i as f32);
    let primitives = (0..20).map(|i| primitive(i, &cube, place(i))).collect();
    let mut scene = Scene { primitives, ..Scene::default() };
    let mut bvh = SceneBvh::new(&scene);
    assert_eq!(bvh.update(&scene), Updated::Nothing);
    scene.primitives[3].world_from_object.translation.y += 0.5;
    assert_eq!(bvh.update(&scene), Updated::Refitted);
    let down = Ray::new(Vec3::new(9.0, 5.0, 0.1), Vec3::NEG_Y);
    assert_eq!(bvh.closest_hit(&down, f32::INFINITY, RayKind::Light).map(|hit| hit.t), Some(4.0));
    // All change places: neighbours in the tree lie far from one another.
    for (index, primitive) in scene.primitives.iter_mut().enumerate() {
        primitive.world_from_object = place((index as u64 * 7) % 20);
    }
    assert_eq!(bvh.update(&scene), Updated::Built);
    scene.primitives.remove(5);
    assert_eq!(bvh.update(&scene), Updated::Built);
    assert_eq!(bvh.triangles.len(), 19 * 12);
}

#[test]
fn what_moves_is_followed_and_what_is_static_stays() {
    let cube = Arc::new(Shape::Box { size: [1.0; 3] }.mesh().unwrap());
    let place = |i: u64| Affine3A::from_translation(Vec3::X * 3.0 * i as f32);
    let primitives = (0..20).map(|i| primitive(i, &cube, place(i))).collect();
    let mut scene = Scene { primitives, ..Scene::default() };
    scene.primitives[3].moving = true;
    let mut bvh = SceneBvh::new(&scene);
    assert_eq!(bvh.trees().map(|tree| tree.order.len()).collect::<Vec<_>>(), [19 * 12, 12]);
    let versions = |bvh: &SceneBvh| [bvh.statics.version, bvh.movers.version];
    let before = versions(&bvh);
    assert_eq!((bvh.update(&scene), versions(&bvh)), (Updated::Nothing, before));
    scene.primitives[3].world_from_object.translation.y += 100.0;
    assert_eq!(bvh.update(&scene), Updated::Refitted);
    assert!(versions(&bvh)[0] == before[0] && versions(&bvh)[1] > before[1]);
    let down = Ray::new(Vec3::new(9.0, 105.0, 0.1), Vec3::NEG_Y);
    assert_eq!(bvh.closest_hit(&down, f32::INFINITY, RayKind::Light).map(|hit| hit.t), Some(4.5));
    assert!(bvh.is_blocked(&down, 5.0) && !bvh.is_blocked(&down, 4.0));
    // What begins to move changes its part.
    scene.primitives[7].moving = true;
    assert_eq!(bvh.update(&scene), Updated::Built);
    assert_eq!(bvh.trees().map(|tree| tree.order.len()).collect::<Vec<_>>(), [18 * 12, 12, 12]);
}

proptest! {
    #[test]
    fn hits_are_those_of_brute_force_whatever_moves(
        places in prop::collection::vec((point(2.0), turn(), any::<bool>()), 1..12),
        shift in point(1.0),
        rays in prop::collection::vec(ray(), 1..20),
    ) {
        let cube = Arc::new(Shape::Box { size: [1.0; 3] }.mesh().unwrap());
        // Each is there twice, so that rays meet two triangles at the same distance.
        let twice = places.iter().flat_map(|place| [place, place]);
        let primitives = twice.zip(0..).map(|((at, turn, is_moving), index)| Primitive {
            moving: *is_moving ^ (index % 4 == 1),
            ..primitive(index, &cube, Affine3A::from_rotation_translation(*turn, *at))
        });
        let mut scene = Scene { primitives: primitives.collect(), ..Scene::default() };
        let mut bvh = SceneBvh::new(&scene);
        for _ in 0..2 {
            bvh.update(&scene);
            for ray in &rays {
                for kind in [RayKind::Camera, RayKind::Light] {
                    let expected = bvh.closest_hit_by_brute_force(ray, f32::INFINITY, kind);
                    // Of two triangles at one place a box may hide the one whose index is lower, by rounding.
                    let surface = |hit: SceneHit| (hit.t, hit.barycentric, bvh.triangles[hit.triangle as usize].corners);
                    let found = bvh.closest_hit(ray, f32::INFINITY, kind);
                    prop_assert_eq!(found.map(surface), expected.map(surface), "{:?}", ray);
                    if kind == RayKind::Light {
                        prop_assert_eq!(bvh.is_blocked(ray, f32::INFINITY), expected.is_some());
                    }
                }
            }
            for primitive in scene.primitives.iter_mut().filter(|primitive| primitive.moving) {
                primitive.world_from_object.translation += glam::Vec3A::from(shift);
            }
        }
    }
}

/// A room of thin walls and a few shelves, turned as a whole.
fn room(turn: Quat) -> Scene {
    let cube = Arc::new(Shape::Box { size: [1.0; 3] }.mesh().unwrap());
    let walls = (0..3).flat_map(|axis| {
        [-2.0, 2.0].map(|side| {
            let (mut size, mut at) = (Vec3::splat(4.0), Vec3::ZERO);
            (size[axis], at[axis]) = (0.1, side);
            (size, at)
        })
    });
    let shelves = (0..20).map(|i| (Vec3::new(3.0, 0.03, 0.4), Vec3::new(0.0, 0.15 * i as f32 - 1.5, 1.5)));
    let place =
        |(size, at)| Affine3A::from_quat(turn) * Affine3A::from_scale_rotation_translation(size, Quat::IDENTITY, at);
    let primitives = walls.chain(shelves).zip(0..).map(|(part, index)| primitive(index, &cube, place(part)));
    Scene { primitives: primitives.collect(), ..Scene::default() }
}

#[test]
fn a_turned_room_costs_rays_little_more_than_one_along_the_axes() {
    let turned = Quat::from_rotation_y(0.6) * Quat::from_rotation_x(0.7);
    let [aligned, turned] = [Quat::IDENTITY, turned].map(|turn| SceneBvh::new(&room(turn)));
    // Along the axes nothing is gained by cutting, and nothing is cut.
    assert_eq!(aligned.statics.bvh.order.len(), aligned.triangles.len());
    assert!(turned.statics.bvh.order.len() > turned.triangles.len());
    let corners: Vec<[Vec3; 3]> = turned.triangles.iter().map(|triangle| triangle.corners).collect();
    let whole = Bvh::new(&boxes_of(&corners), 2).cost();
    let [aligned, turned] = [&aligned, &turned].map(|bvh| bvh.statics.bvh.cost());
    assert!(
        turned < 1.5 * aligned && turned < 0.85 * whole,
        "{aligned} along the axes, {turned} turned, {whole} uncut"
    );
}

#[test]
fn cut_triangles_hide_no_hit() {
    let bvh = SceneBvh::new(&room(Quat::from_rotation_y(0.6) * Quat::from_rotation_x(0.7)));
    let mut met = 0;
    for index in 0..4000_u32 {
        // From the middle in all directions: R2 sequence (Roberts 2018) on the sphere.
        let (u, v) = ((0.754_877_7 * index as f32).fract(), (0.569_840_3 * index as f32).fract());
        let (z, angle) = (2.0 * u - 1.0, std::f32::consts::TAU * v);
        let radius = (1.0 - z * z).sqrt();
        let ray = Ray::new(Vec3::new(0.01, 0.02, 0.03), Vec3::new(radius * angle.cos(), radius * angle.sin(), z));
        let found = bvh.closest_hit(&ray, f32::INFINITY, RayKind::Light);
        let expected = bvh.closest_hit_by_brute_force(&ray, f32::INFINITY, RayKind::Light);
        assert_eq!(found.map(|hit| hit.t), expected.map(|hit| hit.t));
        met += u32::from(found.is_some());
    }
    assert_eq!(met, 4000, "the room is closed");
}
