//! Rays, moving balls and boxes against the triangles of a world, against formulas and against small steps.

#![allow(clippy::unwrap_used)]

use bevy_ecs::prelude::Entity;
use glam::{DVec3, Quat, Vec3};
use lightwell::game::{FixedUpdate, Game, LightProbe, NonSolid, SpatialQuery};
use lightwell::world::Transform;
use proptest::prelude::*;

fn game(entities: &str) -> (tempfile::TempDir, Game) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.scene.ron");
    std::fs::write(&path, format!("Scene(entities: [{entities}])")).unwrap();
    let mut game = Game::new();
    game.enter(&path).unwrap();
    (folder, game)
}

const ALL: fn(Entity) -> bool = |_| true;

const YARD: &str = r#"
    (name: "Floor", mesh: Plane(size: (20, 20))),
    (name: "Box", transform: (translation: (4, 1, 0), rotation: (0, 45, 0), scale: 2), mesh: Box(size: (1, 1, 1))),
    (name: "Ball", transform: (translation: (-4, 2, 0), scale: (1, 2, 1)), mesh: Sphere(radius: 1, segments: 96, rings: 48)),
    (name: "Mist", transform: (translation: (0, 1, 3)), mesh: Box(size: (1, 1, 1)), components: {"NonSolid": ()}),
    (name: "Hidden", transform: (translation: (0, 1, -3)), mesh: Box(size: (1, 1, 1)), visible: false),
"#;

#[test]
fn rays_meet_what_stands_there() {
    let (_folder, game) = game(YARD);
    let space = game.world.ecs.resource::<SpatialQuery>();
    let entity = |name: &str| game.world.find(name).unwrap();
    let down = space.cast_ray(Vec3::new(0.5, 3.0, 0.5), Vec3::NEG_Y * 7.0, 10.0, ALL).unwrap();
    assert_eq!((down.entity, down.normal), (entity("Floor"), Vec3::Y));
    assert!((down.distance - 3.0).abs() < 1e-5 && down.point.y.abs() < 1e-5);
    let corner = space.cast_ray(Vec3::new(0.0, 1.0, 0.0), Vec3::X, 10.0, ALL).unwrap();
    assert_eq!(corner.entity, entity("Box"));
    assert!((corner.distance - (4.0 - 2.0_f32.sqrt())).abs() < 1e-4, "{corner:?}");
    let top = space.cast_ray(Vec3::new(-4.0, 9.0, 0.0), Vec3::NEG_Y, 10.0, ALL).unwrap();
    assert!(top.entity == entity("Ball") && (top.point.y - 4.0).abs() < 1e-3, "a stretched ball: {top:?}");
    let from_below = space.cast_ray(Vec3::new(8.0, -1.0, 0.0), Vec3::Y, 10.0, ALL).unwrap();
    assert_eq!(from_below.normal, Vec3::NEG_Y, "both sides count");
    for (z, what) in [(9.0, "what is not solid"), (-9.0, "what is hidden")] {
        let way = Vec3::Z * -z;
        assert_eq!(space.cast_ray(Vec3::new(0.0, 1.0, z), way, 12.0, ALL), None, "{what}");
    }
    let box_out = |e| e != entity("Box");
    assert_eq!(space.cast_ray(Vec3::new(0.0, 1.0, 0.0), Vec3::X, 10.0, box_out), None);
    assert_eq!(space.cast_ray(Vec3::new(0.5, 3.0, 0.5), Vec3::NEG_Y, 2.9, ALL), None, "out of reach");
    for nonsense in [Vec3::ZERO, Vec3::NAN] {
        assert_eq!(space.cast_ray(Vec3::Y, nonsense, 10.0, ALL), None);
    }
}

/// Files of versions in which the component was called so still load.
#[test]
fn the_old_name_of_non_solid_is_read() {
    let (_folder, game) = game(r#"(name: "Mist", mesh: Box(size: (1, 1, 1)), components: {"Ghost": ()})"#);
    let mist = game.world.find("Mist").unwrap();
    assert!(game.world.ecs.get::<NonSolid>(mist).is_some());
    let space = game.world.ecs.resource::<SpatialQuery>();
    assert_eq!(space.cast_ray(Vec3::Z * 3.0, Vec3::NEG_Z, 9.0, ALL), None);
}

#[test]
fn a_ball_stops_at_faces_edges_and_corners() {
    let (_folder, game) = game(r#"(name: "Box", mesh: Box(size: (2, 2, 2)))"#);
    let space = game.world.ecs.resource::<SpatialQuery>();
    let sweep = |from: Vec3, motion: Vec3| space.cast_sphere(from, 0.5, motion, ALL);
    let face = sweep(Vec3::new(5.0, 0.2, 0.1), Vec3::new(-10.0, 0.0, 0.0)).unwrap();
    assert!((face.fraction - 0.35).abs() < 1e-5 && face.normal.distance(Vec3::X) < 1e-4, "{face:?}");
    // Towards an edge along z, 45° from above: the centre stops half a metre from the edge.
    let way = Vec3::new(-8.0, -8.0, 0.0);
    let edge = sweep(Vec3::new(5.0, 5.0, 0.3), way).unwrap();
    let expected = (4.0 * 2.0_f32.sqrt() - 0.5) / way.length();
    assert!((edge.fraction - expected).abs() < 1e-4, "{edge:?}, {expected}");
    assert!(edge.normal.distance(Vec3::new(0.5, 0.5, 0.0).normalize()) < 1e-2, "{edge:?}");
    let way = Vec3::splat(-8.0);
    let corner = sweep(Vec3::splat(5.0), way).unwrap();
    assert!((corner.fraction - (4.0 * 3.0_f32.sqrt() - 0.5) / way.length()).abs() < 1e-4, "{corner:?}");
    assert_eq!(sweep(Vec3::new(5.0, 1.6, 0.0), Vec3::new(-10.0, 0.0, 0.0)), None, "passes above");
    let inside = Vec3::new(1.2, 0.0, 0.0);
    assert_eq!(sweep(inside, Vec3::X), None, "leaving is free");
    assert_eq!(sweep(inside, Vec3::NEG_X).unwrap().fraction, 0.0);
    let touches = space.overlap_sphere(inside, 0.5, ALL);
    assert!(touches.len() == 1 && (touches[0].depth - 0.3).abs() < 1e-5 && touches[0].normal.distance(Vec3::X) < 1e-4);
}

#[test]
fn a_box_stops_at_what_it_meets_first() {
    let (_folder, game) = game(r#"(name: "Box", mesh: Box(size: (2, 2, 2)))"#);
    let space = game.world.ecs.resource::<SpatialQuery>();
    let half = Vec3::new(0.5, 0.25, 1.0);
    let sweep = |rotation: Quat, from: Vec3, way: Vec3| space.cast_box(from, half, rotation, way, ALL);
    let face = sweep(Quat::IDENTITY, Vec3::new(5.0, 0.0, 0.0), Vec3::NEG_X * 10.0).unwrap();
    assert!((face.fraction - 0.35).abs() < 1e-5 && face.normal.distance(Vec3::X) < 1e-5, "{face:?}");
    let turned = Quat::from_rotation_y(std::f32::consts::FRAC_PI_2);
    let long = sweep(turned, Vec3::new(5.0, 0.0, 0.0), Vec3::NEG_X * 10.0).unwrap();
    assert!((long.fraction - 0.3).abs() < 1e-5, "{long:?}");
    let tilted = Quat::from_rotation_z(std::f32::consts::FRAC_PI_4);
    let edge = sweep(tilted, Vec3::new(0.0, 5.0, 0.0), Vec3::NEG_Y * 10.0).unwrap();
    let reach = (0.5 + 0.25) / 2.0_f32.sqrt();
    assert!((edge.fraction - (4.0 - reach) / 10.0).abs() < 1e-5, "{edge:?}");
    assert_eq!(sweep(Quat::IDENTITY, Vec3::new(5.0, 1.26, 0.0), Vec3::NEG_X * 10.0), None);
    assert_eq!(sweep(Quat::IDENTITY, Vec3::new(1.2, 0.0, 0.0), Vec3::X), None, "leaving is free");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..Default::default() })]

    /// The ball is free just before the touch and in something just after it; without a touch it is free to the end.
    #[test]
    fn sweeps_agree_with_overlaps(
        from in prop::array::uniform3(-6.0_f32..6.0),
        way in prop::array::uniform3(-9.0_f32..9.0),
        radius in 0.1_f32..0.8,
    ) {
        let (_folder, game) = game(YARD);
        let space = game.world.ecs.resource::<SpatialQuery>();
        let (from, way) = (Vec3::from(from), Vec3::from(way));
        let free = |t: f32, r: f32| space.overlap_sphere(from + way * t, r, ALL).is_empty();
        prop_assume!(free(0.0, radius + 1e-3) && way.length() > 0.1);
        match space.cast_sphere(from, radius, way, ALL) {
            Some(touch) => {
                for i in 0..20 {
                    prop_assert!(free(touch.fraction * i as f32 / 20.0, radius - 2e-3), "before {touch:?}");
                }
                prop_assert!(!free(touch.fraction, radius + 2e-3), "{touch:?}");
                prop_assert!((touch.normal.length() - 1.0).abs() < 1e-3 && way.dot(touch.normal) < 0.0);
            }
            None => for i in 0..=20 {
                prop_assert!(free(i as f32 / 20.0, radius - 2e-3));
            },
        }
    }
}

#[test]
fn a_ball_slides_along_walls_and_rests_in_corners() {
    let (_folder, game) = game(
        r#"(name: "Floor", mesh: Plane(size: (20, 20))),
           (name: "Wall", transform: (translation: (3, 1, 0)), mesh: Box(size: (1, 2, 20))),
           (name: "End", transform: (translation: (0, 1, -3)), mesh: Box(size: (20, 2, 1)))"#,
    );
    let space = game.world.ecs.resource::<SpatialQuery>();
    let mut at = Vec3::new(0.0, 0.5, 4.0);
    for _ in 0..240 {
        (at, _) = space.slide_sphere(at, 0.5, Vec3::new(0.05, -0.02, -0.05), ALL);
        assert!(at.y > 0.49 && at.x < 2.01 && at.z > -2.01, "it went through: {at}");
    }
    assert!(at.distance(Vec3::new(2.0, 0.5, -2.0)) < 0.02, "{at}");
    let (out, contacts) = space.slide_sphere(Vec3::new(0.0, 0.2, 4.0), 0.5, Vec3::ZERO, ALL);
    assert!((out.y - 0.5).abs() < 1e-4 && contacts.len() == 1, "pushed out: {out}");
}

#[test]
fn the_space_follows_the_world() {
    let (_folder, mut game) = game(YARD);
    let cube = game.world.find("Box").unwrap();
    let mist = game.world.find("Mist").unwrap();
    let hit = |game: &Game| {
        game.world.ecs.resource::<SpatialQuery>().cast_ray(Vec3::Y, Vec3::X, 20.0, ALL).map(|h| h.distance)
    };
    let before = hit(&game).unwrap();
    game.add_systems(FixedUpdate, move |mut transforms: bevy_ecs::prelude::Query<&mut Transform>| {
        if let Ok(mut transform) = transforms.get_mut(cube) {
            transform.translation.x += 1.0;
        }
    });
    game.step(&[]).unwrap();
    assert!((hit(&game).unwrap() - before - 1.0).abs() < 1e-4);
    game.world.ecs.entity_mut(mist).remove::<NonSolid>();
    game.world.ecs.despawn(cube);
    game.step(&[]).unwrap();
    assert_eq!(hit(&game), None);
    let space = game.world.ecs.resource::<SpatialQuery>();
    assert!(space.cast_ray(Vec3::new(0.0, 1.0, 9.0), Vec3::NEG_Z, 12.0, ALL).is_some_and(|hit| hit.entity == mist));
}

#[test]
fn direct_light_of_a_probe_is_what_formulas_say() {
    let (_folder, mut game) = game(
        r#"(name: "Up", components: {"LightProbe": (normal: (0, 1, 0), offset: (0, 0.5, 0))}, mesh: Sphere(radius: 0.4)),
           (name: "All", components: {"LightProbe": ()}, transform: (translation: (3, 0.5, 0))),
           (name: "Dark", components: {"LightProbe": ()}, transform: (translation: (0, 0.5, 6))),
           (name: "Lamp", transform: (translation: (0, 2.5, 0)), light: (kind: Point, intensity: 8, color: (1, 0.5, 0))),
           (name: "Wall", transform: (translation: (0, 1, 3)), mesh: Box(size: (20, 20, 0.2)))"#,
    );
    let probe = |game: &Game, name: &str| *game.world.ecs.get::<LightProbe>(game.world.find(name).unwrap()).unwrap();
    let close = |a: Vec3, b: Vec3| assert!(a.distance(b) < 1e-4 * (1.0 + b.length()), "{a} {b}");
    // I·cosθ/d² with d = 2 straight below; the probe's own ball does not shade it.
    close(probe(&game, "Up").irradiance(), Vec3::new(2.0, 1.0, 0.0));
    // A quarter of I/d² = 8/13 on the mean over all normals.
    close(probe(&game, "All").irradiance(), Vec3::new(8.0, 4.0, 0.0) / 13.0 / 4.0);
    close(probe(&game, "Dark").irradiance(), Vec3::ZERO);
    let lamp = game.world.find("Lamp").unwrap();
    let light = |game: &mut Game, kind| {
        let mut light = game.world.ecs.get_mut::<lightwell::world::Light>(lamp).unwrap();
        (light.kind, light.color) = (kind, Vec3::ONE);
        game.world.ecs.get_mut::<Transform>(lamp).unwrap().rotation =
            Quat::from_rotation_x(-std::f32::consts::FRAC_PI_2);
        game.step(&[]).unwrap();
    };
    light(&mut game, lightwell::world::LightKind::Directional);
    close(probe(&game, "Up").irradiance(), Vec3::splat(8.0));
    assert!((probe(&game, "Up").brightness() - 8.0).abs() < 1e-3);
    // Half way between the cones, in their cosines, a quarter of the light is left (glTF: the square).
    let (inner, outer) = (20.0_f32, 60.0_f32);
    let half = 0.5 * (inner.to_radians().cos() + outer.to_radians().cos());
    light(&mut game, lightwell::world::LightKind::Spot { inner, outer });
    let all = game.world.find("All").unwrap();
    game.world.ecs.get_mut::<Transform>(all).unwrap().translation = Vec3::new(half.acos().tan() * 2.0, 0.5, 0.0);
    game.step(&[]).unwrap();
    let d2 = (2.0 / half).powi(2);
    close(probe(&game, "All").irradiance(), Vec3::splat(8.0 / d2 * 0.25 / 4.0));
}

#[test]
fn probes_are_asked_for_from_the_origin_of_the_scene_that_is_drawn() {
    let (_folder, game) = game(
        r#"(name: "Far", transform: (translation: (100000, 0, -200000)), children: [
            (name: "Probe", transform: (translation: (0.001, 2, 0)), components: {"LightProbe": (offset: (0, 0.5, 0))})])"#,
    );
    let origin = DVec3::new(100_000.0, 0.0, -200_000.0);
    let near = game.probe_points(origin)[0].position;
    assert!(near.distance(Vec3::new(0.001, 2.5, 0.0)) < 1e-6, "{near}");
    assert!(game.probe_points(DVec3::ZERO)[0].position.x > 99_999.0);
}
