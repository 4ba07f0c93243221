#![allow(clippy::unwrap_used)]

use super::*;
use crate::assets::Shape;
use crate::core::Aabb;
use glam::{Quat, Vec3};
use proptest::prelude::*;

pub(crate) fn point(range: f32) -> impl Strategy<Value = Vec3> {
    prop::array::uniform3(-range..range).prop_map(Vec3::from)
}

/// Triangles of all kinds: ordinary, slivers, without area, and many at one place.
fn triangle() -> impl Strategy<Value = [Vec3; 3]> {
    prop_oneof![
        6 => prop::array::uniform3(point(1.0)),
        3 => (point(1.0), prop::array::uniform3(point(0.05))).prop_map(|(at, offsets)| offsets.map(|o| at + o)),
        1 => (point(1.0), point(1.0)).prop_map(|(a, b)| [a, b, b]),
        1 => (point(1.0), point(1.0)).prop_map(|(a, b)| [a, 0.5 * (a + b), b]),
        1 => point(1.0).prop_map(|a| [a, a, a]),
        1 => Just([Vec3::ZERO, Vec3::X, Vec3::Y]),
    ]
}

pub(crate) fn ray() -> impl Strategy<Value = Ray> {
    let axis = prop::sample::select(vec![Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z]);
    let direction = prop_oneof![4 => point(1.0), 1 => axis, 1 => point(1e-6), 1 => point(1e6)];
    (point(2.0), direction).prop_map(|(origin, direction)| Ray::new(origin, direction))
}

fn assert_sound(bvh: &Bvh, boxes: &[Aabb]) {
    let mut seen = vec![0; boxes.len()];
    for node in bvh.nodes.iter().filter(|node| node.count > 0) {
        for &entry in &bvh.order[node.first as usize..][..node.count as usize] {
            seen[entry as usize] += 1;
            let inside = boxes[entry as usize];
            assert_eq!(node.bounds().union(&inside), node.bounds(), "box {entry} sticks out of its leaf");
        }
    }
    let expected: Vec<u32> = boxes.iter().map(|bounds| u32::from(!bounds.is_empty())).collect();
    assert_eq!(seen, expected, "every box lies in exactly one leaf");
    for node in bvh.nodes.iter().filter(|node| node.count == 0) {
        for child in 0..2 {
            let child = bvh.nodes[node.first as usize + child].bounds();
            assert_eq!(node.bounds().union(&child), node.bounds(), "a child sticks out of its parent");
        }
    }
}

pub(crate) fn boxes_of(soup: &[[Vec3; 3]]) -> Vec<Aabb> {
    soup.iter().map(|corners| Aabb::from_points(*corners)).collect()
}

proptest! {
    #[test]
    fn finds_what_trying_every_triangle_finds(
        soup in prop::collection::vec(triangle(), 0..200),
        rays in prop::collection::vec(ray(), 1..20),
    ) {
        let mesh = MeshBvh::from_triangles(soup);
        for ray in rays {
            let found = mesh.closest_hit(&ray, f32::INFINITY, |_| true);
            let expected = mesh.closest_hit_by_brute_force(&ray, f32::INFINITY);
            prop_assert_eq!(found, expected, "{:?}", ray);
        }
    }

    #[test]
    fn a_refitted_tree_finds_the_moved_triangles(
        soup in prop::collection::vec(triangle(), 1..100),
        shift in point(3.0),
        rays in prop::collection::vec(ray(), 1..10),
    ) {
        let mut mesh = MeshBvh::from_triangles(soup.clone());
        let twisted = |corners: &[Vec3; 3]| corners.map(|c| Quat::from_rotation_y(2.0 * c.y) * c + shift);
        let moved: Vec<[Vec3; 3]> = soup.iter().map(twisted).collect();
        mesh.refit(moved.clone());
        assert_sound(&mesh.bvh, &boxes_of(&moved));
        for ray in rays {
            prop_assert_eq!(
                mesh.closest_hit(&ray, f32::INFINITY, |_| true),
                mesh.closest_hit_by_brute_force(&ray, f32::INFINITY)
            );
        }
    }

    #[test]
    fn every_box_lies_in_one_leaf(soup in prop::collection::vec(triangle(), 0..300), leaf_size in 1_usize..9) {
        let boxes = boxes_of(&soup);
        let bvh = Bvh::new(&boxes, leaf_size);
        assert_sound(&bvh, &boxes);
        prop_assert!(bvh.nodes.iter().all(|node| node.count as usize <= leaf_size));
    }
}

#[test]
fn nothing_makes_an_empty_tree() {
    let mesh = MeshBvh::from_triangles(Vec::new());
    assert_eq!(mesh.bvh.depth(), 0);
    assert_eq!(mesh.closest_hit(&Ray::new(Vec3::ZERO, Vec3::X), f32::INFINITY, |_| true), None);
    let broken = MeshBvh::from_triangles(vec![[Vec3::NAN; 3], [Vec3::ZERO, Vec3::INFINITY, Vec3::X]]);
    assert!(broken.bvh.nodes.is_empty());
}

#[test]
fn coinciding_and_exponentially_spaced_boxes_keep_the_tree_shallow() {
    let coinciding = vec![Aabb { min: Vec3::ZERO, max: Vec3::ONE }; 5000];
    let spaced: Vec<Aabb> = (0..5000)
        .map(|i| {
            let at = Vec3::splat(2.0_f32.powf(i as f32 / 25.0 - 100.0));
            Aabb { min: at, max: at * 1.01 }
        })
        .collect();
    for boxes in [coinciding, spaced] {
        let bvh = Bvh::new(&boxes, 1);
        assert_sound(&bvh, &boxes);
        assert!(bvh.depth() <= MAX_DEPTH + 16, "{}", bvh.depth());
    }
}

#[test]
fn equal_input_gives_equal_nodes() {
    let mesh = Shape::Torus { radius: 1.0, tube: 0.3, segments: 48, sides: 24 }.mesh().unwrap();
    let (a, b) = (MeshBvh::from_triangles(mesh.corners()), MeshBvh::from_triangles(mesh.corners()));
    assert_eq!((a.bvh.nodes, a.bvh.order), (b.bvh.nodes, b.bvh.order));
}

#[test]
fn the_heuristic_beats_halving_by_count() {
    // A few large triangles among many small ones, where halving by count does badly.
    let small = (0..2000).map(|i| {
        let at = Vec3::new((i % 50) as f32, 0.0, (i / 50) as f32) * 0.01;
        [at, at + Vec3::X * 0.01, at + Vec3::Z * 0.01]
    });
    let large = (0..20).map(|i| [Vec3::ZERO, Vec3::X, Vec3::Y].map(|c| c * 50.0 + Vec3::Z * i as f32));
    let soup: Vec<[Vec3; 3]> = small.chain(large).collect();
    let bvh = Bvh::new(&boxes_of(&soup), 4);
    assert!(bvh.cost() < 60.0, "cost {}", bvh.cost());
}
