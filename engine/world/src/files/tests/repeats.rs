//! Prefabs in grids, in rings and along lines.

use super::*;
use crate::world::{GlobalTransform, Light};
use glam::Vec3;

const LAMP: &str = r#"Prefab(entities: [
    (name: "Pole", mesh: Box(size: (0.1, 2, 0.1)), children: [
        (name: "Bulb", transform: (translation: (0, 1, 0)), light: (kind: Point, intensity: 3)),
    ]),
])"#;

const ROW: &str = r#"(entities: [
    (name: "Lamps", prefab: "lamp.prefab.ron", repeat: Line(count: 3, points: [(0, 0, 0), (4, 0, 0)]),
        overrides: { "2/Pole/Bulb": (light: (kind: Point, intensity: 7)) }),
])"#;

fn folder(scene: &str) -> Folder {
    let scene = format!("(entities: [{scene}])");
    Folder::new(&[("lamp.prefab.ron", LAMP), ("row.prefab.ron", ROW), ("a.scene.ron", &scene)])
}

fn place(world: &GameWorld, path: &str) -> Vec3 {
    let entity = at(world, path).unwrap_or_else(|| panic!("no `{path}`"));
    world.ecs.get::<GlobalTransform>(entity).unwrap().0.translation.into()
}

fn intensity(world: &GameWorld, path: &str) -> f32 {
    world.ecs.get::<Light>(at(world, path).unwrap()).unwrap().intensity
}

fn close(world: &GameWorld, path: &str, expected: [f32; 3]) {
    let found = place(world, path);
    assert!(found.distance(expected.into()) < 1e-5, "{path}: {found}, expected {expected:?}");
}

#[test]
fn a_grid_stands_around_its_entity() {
    let world = folder(
        r#"(name: "G", transform: (translation: (10, 0, 0)), prefab: "lamp.prefab.ron",
            repeat: Grid(count: (3, 1, 2), spacing: (2, 5, 4)))"#,
    )
    .load("a.scene.ron")
    .unwrap();
    close(&world, "G/1/Pole", [8.0, 0.0, -2.0]);
    close(&world, "G/3/Pole", [12.0, 0.0, -2.0]);
    close(&world, "G/4/Pole/Bulb", [8.0, 1.0, 2.0]);
    assert!(at(&world, "G/6/Pole").is_some() && at(&world, "G/7").is_none() && at(&world, "G/Pole").is_none());
}

#[test]
fn a_ring_turns_its_copies_outwards() {
    let scene = r#"(name: "R", prefab: "row.prefab.ron", repeat: Ring(count: 4, radius: 3)),
        (name: "Arc", prefab: "lamp.prefab.ron", repeat: Ring(count: 3, radius: 2, angles: (-90, 90), turn: false))"#;
    let world = folder(scene).load("a.scene.ron").unwrap();
    close(&world, "R/1", [0.0, 0.0, 3.0]);
    close(&world, "R/2", [3.0, 0.0, 0.0]);
    close(&world, "R/3", [0.0, 0.0, -3.0]);
    // The row's own +x, turned by 90°, is -z.
    close(&world, "R/2/Lamps/3/Pole", [3.0, 0.0, -4.0]);
    assert_eq!((intensity(&world, "R/4/Lamps/2/Pole/Bulb"), intensity(&world, "R/4/Lamps/3/Pole/Bulb")), (7.0, 3.0));
    close(&world, "Arc/1/Pole", [-2.0, 0.0, 0.0]);
    close(&world, "Arc/2/Pole", [0.0, 0.0, 2.0]);
    close(&world, "Arc/3/Pole", [2.0, 0.0, 0.0]);
}

#[test]
fn a_line_bends_at_its_points() {
    let scene = r#"(name: "L", prefab: "lamp.prefab.ron",
        repeat: Line(count: 5, points: [(0, 0, 0), (2, 0, 0), (2, 0, 2)], turn: true))"#;
    let world = folder(scene).load("a.scene.ron").unwrap();
    for (i, expected) in
        [[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 0.0, 1.0], [2.0, 0.0, 2.0]].iter().enumerate()
    {
        close(&world, &format!("L/{}/Pole", i + 1), *expected);
    }
    let turn = world.ecs.get::<GlobalTransform>(at(&world, "L/1").unwrap()).unwrap().0.matrix3.z_axis;
    assert!(turn.distance(glam::Vec3A::X) < 1e-5, "+z of the first points to {turn}");
}

#[test]
fn copies_are_overridden_and_survive_a_save() {
    let scene = r#"(name: "G", prefab: "lamp.prefab.ron", repeat: Grid(count: (4, 1, 1), spacing: (1, 1, 1)), overrides: {
            "2": (remove: true), "3": (transform: (translation: (0, 9, 0))),
            "4/Pole/Bulb": (light: (kind: Point, intensity: 8)),
        }, children: [(name: "Sign")])"#;
    let folder = folder(scene);
    let check = |world: &GameWorld| {
        assert!(at(world, "G/2").is_none() && at(world, "G/Sign").is_some());
        close(world, "G/3/Pole", [0.0, 9.0, 0.0]);
        assert_eq!((intensity(world, "G/1/Pole/Bulb"), intensity(world, "G/4/Pole/Bulb")), (3.0, 8.0));
    };
    let world = folder.load("a.scene.ron").unwrap();
    check(&world);
    save_scene(&world, &folder.path("saved.scene.ron")).unwrap();
    let saved = folder.read("saved.scene.ron");
    assert!(saved.contains("repeat: Grid(count: (4, 1, 1)") && !saved.contains("\"1\""), "{saved}");
    let again = folder.load("saved.scene.ron").unwrap_or_else(|e| panic!("{e}\n{saved}"));
    check(&again);
    save_scene(&again, &folder.path("twice.scene.ron")).unwrap();
    assert_eq!(folder.read("twice.scene.ron"), saved);
}

#[test]
fn repeats_that_make_no_sense_are_errors() {
    let cases = [
        (r#"repeat: Grid(count: (2, 2, 2), spacing: (1, 1, 1))"#, "without a prefab"),
        (r#"prefab: "lamp.prefab.ron", repeat: Grid(count: (2, 0, 2), spacing: (1, 1, 1))"#, "0 copies"),
        (
            r#"prefab: "lamp.prefab.ron", repeat: Grid(count: (4000000000, 4000000000, 4000000000), spacing: (1, 1, 1))"#,
            "copies",
        ),
        (r#"prefab: "lamp.prefab.ron", repeat: Ring(count: 20000, radius: 1)"#, "20000 copies"),
        (r#"prefab: "lamp.prefab.ron", repeat: Line(count: 2, points: [(0, 0, 0)])"#, "two points"),
        (r#"prefab: "lamp.prefab.ron", repeat: Ring(count: 2, radius: 1, turns: true)"#, "did you mean `turn`"),
        (
            r#"prefab: "lamp.prefab.ron", repeat: Ring(count: 2, radius: 1), overrides: {"3/Pole": (remove: true)}"#,
            "3/Pole",
        ),
        (r#"prefab: "lamp.prefab.ron", repeat: Ring(count: 2, radius: 1), children: [(name: "2")]"#, "named `2`"),
    ];
    for (fields, expected) in cases {
        let error = folder(&format!("(name: \"A\", {fields})")).load("a.scene.ron").err().unwrap().to_string();
        assert!(error.contains(expected) && error.contains("a.scene.ron:1:"), "{fields}: {error}");
    }
}
