//! Buried and open surfels, in small scenes.

use super::super::fixture;
use crate::assets::{AlphaMode, Material, Shape};
use crate::scene::{Primitive, Revisions, Scene, Surfel, SurfelCloud};
use glam::{Affine3A, Vec3};
use std::sync::Arc;

fn box_at(id: u64, size: [f32; 3], at: Vec3, material: Material) -> Primitive {
    let mesh = Arc::new(Shape::Box { size }.mesh().expect("a valid shape"));
    let place = Affine3A::from_translation(at);
    Primitive { material: Arc::new(material), ..fixture::primitive(id, mesh, place) }
}

fn stone() -> Material {
    Material::diffuse("stone", Vec3::splat(0.5))
}

fn cloud(primitives: Vec<Primitive>) -> SurfelCloud {
    let revisions = Revisions { geometry: 1, ..Default::default() };
    let scene = Scene { identity: 1, revisions, primitives, ..Default::default() };
    let mut cloud = SurfelCloud::default();
    cloud.update(&scene, 0.1);
    cloud
}

/// Area of the surfels of each primitive, which stand at places of their own.
fn areas(primitives: Vec<Primitive>) -> Vec<f32> {
    let count = primitives.len();
    let cloud = cloud(primitives);
    (0..count).map(|place| cloud.surfels.iter().filter(|s| s.group() == place).map(|s| s.area).sum()).collect()
}

fn within(value: f32, expected: f32) -> bool {
    (value / expected - 1.0).abs() < 0.03
}

#[test]
fn what_stands_in_something_else_is_buried_and_what_looks_out_is_not() {
    let floor = box_at(1, [4.0, 1.0, 4.0], Vec3::new(0.0, -0.5, 0.0), stone());
    // A quarter of it in the floor: 7 of 10 m² are left.
    let column = box_at(2, [1.0, 2.0, 1.0], Vec3::new(0.0, 0.5, 0.0), stone());
    let found = areas(vec![floor, column]);
    assert!(within(found[1], 7.0), "{found:?}");
    assert!(within(found[0], 48.0 - 1.0), "{found:?}");
}

#[test]
fn a_face_on_a_face_is_buried() {
    let lower = box_at(1, [2.0; 3], Vec3::new(0.0, -1.0, 0.0), stone());
    let upper = box_at(2, [1.0; 3], Vec3::new(0.0, 0.5, 0.0), stone());
    let found = areas(vec![lower, upper]);
    assert!(within(found[0], 23.0) && within(found[1], 5.0), "{found:?}");
}

#[test]
fn a_room_is_no_solid_and_neither_is_a_shell_with_two_sides_or_with_holes() {
    let two_sides = Material { double_sided: true, ..stone() };
    let holes = Material { alpha_mode: AlphaMode::Mask(0.5), ..stone() };
    for material in [two_sides, holes] {
        let shell = box_at(1, [3.0; 3], Vec3::ZERO, material);
        let found = areas(vec![shell, box_at(2, [1.0; 3], Vec3::splat(0.1), stone())]);
        assert!(within(found[1], 6.0), "{found:?}");
    }
    // Its faces look inwards.
    let mut mesh = Shape::Box { size: [3.0; 3] }.mesh().expect("a valid shape");
    mesh.indices.chunks_exact_mut(3).for_each(|triangle| triangle.swap(1, 2));
    let room = Primitive { mesh: Arc::new(mesh), ..box_at(1, [3.0; 3], Vec3::ZERO, stone()) };
    let found = areas(vec![room, box_at(2, [1.0; 3], Vec3::splat(0.1), stone())]);
    assert!(within(found[1], 6.0), "{found:?}");
}

#[test]
fn what_moves_buries_nothing_and_is_not_buried() {
    let wall = box_at(1, [3.0; 3], Vec3::ZERO, stone());
    let mover = Primitive { moving: true, ..box_at(2, [1.0; 3], Vec3::splat(0.1), stone()) };
    let still = box_at(3, [0.5; 3], Vec3::new(5.0, 0.0, 0.0), stone());
    let around = Primitive { moving: true, ..box_at(4, [1.0; 3], Vec3::new(5.1, 0.0, 0.0), stone()) };
    let found = areas(vec![wall, mover, still, around]);
    assert!(within(found[1], 6.0) && within(found[2], 1.5), "{found:?}");
}

/// Two floors of which the upper one leaves a gap, and what a surfel in the middle of the gap gets: all that comes from
/// far away, and half of the rest.
#[test]
fn a_narrow_gap_is_closed_and_a_wide_one_is_open() {
    let share = |gap: f32| {
        let lower = box_at(1, [4.0, 1.0, 4.0], Vec3::new(0.0, -0.5, 0.0), stone());
        let upper = box_at(2, [4.0, 1.0, 4.0], Vec3::new(0.0, 0.5 + gap, 0.0), stone());
        let cloud = cloud(vec![lower, upper]);
        let is_within = |s: &&Surfel| {
            let [x, y, z] = s.position;
            s.group() == 0 && y > 0.499 && x.abs().max(z.abs()) < 1.0
        };
        let within: Vec<f32> = cloud.surfels.iter().filter(is_within).map(Surfel::openness).collect();
        within.iter().sum::<f32>() / within.len() as f32
    };
    // Cells of 0.1 m: the rays see 0.2 m.
    assert_eq!(share(0.25), 1.0);
    // Those that meet the other floor within 0.2 m have cos² > ¼: three quarters of them.
    assert!((share(0.1) - 0.625).abs() < 0.02, "{}", share(0.1));
    // No ray gets out of a crack.
    assert_eq!(share(0.01), 0.0);
}

/// Openness that is kept from state to state equals that of a cloud built from nothing.
#[test]
fn changes_leave_what_is_made_anew() {
    let floor = box_at(1, [4.0, 1.0, 4.0], Vec3::new(0.0, -0.5, 0.0), stone());
    let column = box_at(2, [1.0, 2.0, 1.0], Vec3::new(0.0, 0.5, 0.0), stone());
    let of = |material: Material| Primitive { material: Arc::new(material), ..column.clone() };
    let raised = |primitive: &Primitive| {
        let world_from_object = Affine3A::from_translation(Vec3::new(0.0, 0.8, 0.0));
        Primitive { world_from_object, ..primitive.clone() }
    };
    let scaled = |primitive: &Primitive, scale: Vec3| {
        let world_from_object = primitive.world_from_object * Affine3A::from_scale(scale);
        let bounds = primitive.mesh.bounds.transformed(&world_from_object);
        Primitive { world_from_object, bounds, ..primitive.clone() }
    };
    let stone_at = |id: u64, at: Vec3| box_at(id, [0.2; 3], at, stone());
    let many = (10..30).map(|id| stone_at(id, Vec3::new(0.1 * id as f32 - 2.0, 0.2, 1.5)));
    let states = [
        vec![floor.clone(), column.clone()],
        vec![floor.clone(), of(Material::diffuse("paint", Vec3::X))],
        vec![floor.clone(), raised(&column)],
        vec![floor.clone(), raised(&of(Material { double_sided: true, ..stone() }))],
        vec![floor.clone(), Primitive { moving: true, ..raised(&column) }],
        vec![floor.clone(), column.clone()],
        vec![floor.clone(), column.clone(), stone_at(3, Vec3::new(1.5, 0.1, 1.5))],
        vec![floor.clone(), column.clone(), stone_at(3, Vec3::new(0.6, 0.05, 0.0)), stone_at(5, Vec3::ZERO)],
        [floor.clone(), column.clone()].into_iter().chain(many).collect(),
        vec![floor.clone(), scaled(&column, Vec3::new(-1.0, 1.0, 1.0))],
        vec![floor.clone(), scaled(&column, Vec3::new(1.0, 1.0, 0.0))],
        vec![column.clone()],
    ];
    let mut kept = SurfelCloud::default();
    for (revision, primitives) in (1_u64..).zip(states) {
        let statics = revision.div_ceil(2);
        let revisions = Revisions { geometry: revision, materials: revision, statics, ..Default::default() };
        let scene = Scene { identity: 1, revisions, primitives, ..Default::default() };
        kept.update(&scene, 0.1);
        let mut fresh = SurfelCloud::default();
        fresh.update(&scene, 0.1);
        assert!(kept.surfels == fresh.surfels, "state {revision}");
    }
}

/// The wall behind a block on a floor: rays within the block end where its faces and the others' coincide.
#[test]
fn neither_turns_nor_the_order_of_objects_change_what_is_left() {
    let left = |degrees: f32, ids: [u64; 3]| {
        let turn = Affine3A::from_rotation_y(degrees.to_radians()) * Affine3A::from_rotation_x(degrees.to_radians());
        let floor = box_at(ids[0], [4.0, 1.0, 4.0], Vec3::new(0.0, -0.5, 0.0), stone());
        let wall = box_at(ids[1], [4.0, 3.0, 0.5], Vec3::new(0.0, 1.5, -0.75), stone());
        let block = box_at(ids[2], [1.0; 3], Vec3::new(0.2, 0.5, 0.0), stone());
        let mut all = vec![floor, wall, block];
        all.sort_by_key(|primitive| primitive.id);
        for primitive in &mut all {
            primitive.world_from_object = turn * primitive.world_from_object;
            primitive.bounds = primitive.mesh.bounds.transformed(&primitive.world_from_object);
        }
        let found = areas(all);
        let mut order: Vec<usize> = vec![0, 1, 2];
        order.sort_by_key(|index| ids[*index]);
        let of = |object: usize| found[order.iter().position(|index| *index == object).unwrap_or(0)];
        [of(0), of(1), of(2)]
    };
    let straight = left(0.0, [1, 2, 3]);
    // The floor covers two of the wall's 31 m² and the block one; two of the block's six are covered.
    assert!(within(straight[1], 28.0) && within(straight[2], 4.0), "{straight:?}");
    for (degrees, ids) in [(0.0, [3, 2, 1]), (0.0, [2, 3, 1]), (17.0, [1, 2, 3]), (45.0, [3, 1, 2])] {
        let other = left(degrees, ids);
        let same = straight.iter().zip(other).all(|(a, b)| (a - b).abs() < 0.005 * a);
        assert!(same, "{degrees}°, {ids:?}: {straight:?}, {other:?}");
    }
}

#[test]
fn a_mirrored_solid_buries_as_well_and_a_flattened_one_nothing() {
    let lower = box_at(1, [2.0; 3], Vec3::new(0.0, -1.0, 0.0), stone());
    let buried = |scale: Vec3| {
        let upper = box_at(2, [1.0; 3], Vec3::new(0.0, 0.5, 0.0), stone());
        let world_from_object = upper.world_from_object * Affine3A::from_scale(scale);
        let bounds = upper.mesh.bounds.transformed(&world_from_object);
        let found = areas(vec![lower.clone(), Primitive { world_from_object, bounds, ..upper }]);
        24.0 - found[0]
    };
    assert!((buried(Vec3::new(1.0, 1.0, -1.0)) - 1.0).abs() < 0.05);
    assert!(buried(Vec3::new(1.0, 0.0, 1.0)).abs() < 0.05);
}
