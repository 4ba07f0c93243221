use crate::assets::{Material, Mesh};
use crate::world::animation::*;
use crate::world::*;
use bevy_ecs::prelude::Entity;
use glam::{Quat, Vec3};
use std::sync::Arc;

fn tracks() -> Vec<Track> {
    vec![
        Track::Orbit {
            center: Vec3::new(0.3, 1.0, -0.2),
            axis: Vec3::new(0.1, 2.0, 0.3),
            radius: 1.7,
            period: 3.2,
            phase: 33.0,
            look_at_center: true,
        },
        Track::Spin { axis: Vec3::new(1.0, 0.2, 0.0), degrees_per_second: 112.5 },
        Track::Keys {
            node: String::new(),
            target: Target::Scale,
            keys: vec![
                (0.0, KeyValue::Scalar(1.0)),
                (0.7, KeyValue::Vector(Vec3::new(2.0, 1.0, 0.5))),
                (1.6, KeyValue::Scalar(1.0)),
            ],
            interpolation: Interpolation::Cubic,
            wrap: Wrap::PingPong,
        },
        Track::Keys {
            node: String::new(),
            target: Target::LightIntensity,
            keys: vec![(0.0, KeyValue::Scalar(1.0)), (0.8, KeyValue::Scalar(3.0))],
            interpolation: Interpolation::Linear,
            wrap: Wrap::Loop,
        },
    ]
}

fn animated(animation: Animation) -> (GameWorld, Entity) {
    let mut world = GameWorld::new();
    let entity = world.spawn("lamp", None);
    let transform = Transform { rotation: Quat::from_rotation_z(0.4), ..Transform::default() };
    world.ecs.entity_mut(entity).insert((transform, Light::default(), animation));
    world.update();
    (world, entity)
}

/// All bits that the animation changes.
fn bits(world: &GameWorld, entity: Entity) -> Vec<u32> {
    let place = world.ecs.get::<GlobalTransform>(entity).unwrap().0.to_cols_array();
    let light = world.ecs.get::<Light>(entity).unwrap().intensity;
    place.into_iter().chain([light]).map(f32::to_bits).collect()
}

#[test]
fn a_frame_is_the_same_however_it_is_reached() {
    let (mut stepped, a) = animated(Animation { tracks: tracks(), ..Animation::default() });
    let (mut jumped, b) = animated(Animation { tracks: tracks(), ..Animation::default() });
    for _ in 0..47 {
        stepped.advance(1);
        stepped.update();
    }
    jumped.set_tick(47);
    jumped.update();
    assert_eq!(bits(&stepped, a), bits(&jumped, b));
    jumped.set_tick(900);
    jumped.update();
    assert_ne!(bits(&stepped, a), bits(&jumped, b));
    jumped.set_seconds(47.0 / 30.0);
    jumped.update();
    assert_eq!(bits(&stepped, a), bits(&jumped, b));
}

#[test]
fn loops_close_to_the_bit() {
    for (speed, ticks) in [(1.0, 96), (-1.0, 96), (2.0, 48), (0.5, 192)] {
        let (mut world, entity) = animated(Animation { tracks: tracks(), speed, offset: 0.37, ..Animation::default() });
        for tick in [0, 1, 13, 40] {
            world.set_tick(tick);
            world.update();
            let first = bits(&world, entity);
            for round in [1, 2, 1_000_003] {
                world.set_tick(tick + round * ticks);
                world.update();
                assert_eq!(bits(&world, entity), first, "speed {speed}, tick {tick}, round {round}");
            }
        }
    }
}

#[test]
fn nothing_accumulates_and_the_rest_pose_is_kept() {
    let (mut world, entity) = animated(Animation { tracks: tracks(), ..Animation::default() });
    let rest = Transform { rotation: Quat::from_rotation_z(0.4), ..Transform::default() };
    for _ in 0..10 {
        world.advance(3);
        world.update();
    }
    assert_eq!(world.rest_transform(entity), rest);
    assert_eq!(world.rest_light(entity).unwrap(), Light::default());
    assert_ne!(*world.ecs.get::<Transform>(entity).unwrap(), rest);
    // Moved while it plays.
    let moved = Transform { translation: Vec3::Y, ..rest };
    world.set_rest_transform(entity, moved);
    world.update();
    assert_eq!(world.rest_transform(entity), moved);
    // A clone of it rests where it does.
    let clone = world.clone_subtree(entity).unwrap();
    world.update();
    assert_eq!(world.rest_transform(clone), moved);
    assert_eq!(bits(&world, clone), bits(&world, entity));
    // Paused or without animation: at rest.
    world.ecs.get_mut::<Animation>(entity).unwrap().playing = false;
    world.ecs.entity_mut(clone).remove::<Animation>();
    world.update();
    for e in [entity, clone] {
        assert_eq!(*world.ecs.get::<Transform>(e).unwrap(), moved);
        assert_eq!(*world.ecs.get::<Light>(e).unwrap(), Light::default());
    }
    assert!(world.ecs.get::<RestPose>(clone).is_none());
}

#[test]
fn what_is_not_animated_stays_free() {
    let track = Track::Spin { axis: Vec3::Y, degrees_per_second: 90.0 };
    let (mut world, entity) = animated(Animation { tracks: vec![track], ..Animation::default() });
    world.ecs.get_mut::<Transform>(entity).unwrap().translation = Vec3::X;
    world.ecs.get_mut::<Light>(entity).unwrap().intensity = 7.0;
    world.set_seconds(1.0);
    world.update();
    let now = *world.ecs.get::<Transform>(entity).unwrap();
    assert_eq!((now.translation, world.rest_light(entity).unwrap().intensity), (Vec3::X, 7.0));
    // On top of the rest rotation, about its own axis.
    let expected = Quat::from_rotation_z(0.4) * Quat::from_rotation_y(std::f32::consts::FRAC_PI_2);
    assert!(now.rotation.abs_diff_eq(expected, 1e-6));
}

#[test]
fn an_orbit_starts_at_x_turns_counter_clockwise_and_looks_at_its_centre() {
    let track = Track::Orbit {
        center: Vec3::Y,
        axis: 5.0 * Vec3::Y,
        radius: 2.0,
        period: 4.0,
        phase: 0.0,
        look_at_center: true,
    };
    let (mut world, entity) = animated(Animation { tracks: vec![track], ..Animation::default() });
    for (seconds, direction) in [(0.0, Vec3::X), (1.0, Vec3::NEG_Z), (2.0, Vec3::NEG_X), (3.0, Vec3::Z)] {
        world.set_seconds(seconds);
        world.update();
        let now = *world.ecs.get::<Transform>(entity).unwrap();
        assert!(now.translation.abs_diff_eq(Vec3::Y + 2.0 * direction, 1e-6), "{seconds} s: {}", now.translation);
        assert!((now.rotation * Vec3::NEG_Z).abs_diff_eq(-direction, 1e-6));
        assert!((now.rotation * Vec3::Y).abs_diff_eq(Vec3::Y, 1e-6));
    }
}

#[test]
fn the_height_of_an_orthographic_camera_is_animated_and_kept() {
    let track = Track::Keys {
        node: String::new(),
        target: Target::CameraHeight,
        keys: vec![(0.0, KeyValue::Scalar(2.0)), (1.0, KeyValue::Scalar(4.0))],
        interpolation: Interpolation::Linear,
        wrap: Wrap::Once,
    };
    let mut world = GameWorld::new();
    let entity = world.spawn("eye", None);
    let animation = Animation { tracks: vec![track], ..Animation::default() };
    let of = |height| Camera { projection: Projection::Orthographic { height }, ..Camera::default() };
    world.ecs.entity_mut(entity).insert((of(8.0), animation));
    world.set_seconds(0.5);
    world.update();
    assert_eq!(world.ecs.get::<Camera>(entity).unwrap(), &of(3.0));
    assert_eq!(world.rest_camera(entity).unwrap(), of(8.0));
    // An edit is one of the camera without animation, and a perspective has no height to change.
    world.set_rest_camera(entity, of(5.0));
    world.update();
    assert_eq!((world.ecs.get::<Camera>(entity).unwrap(), world.rest_camera(entity).unwrap()), (&of(3.0), of(5.0)));
    world.set_rest_camera(entity, Camera::default());
    world.update();
    assert_eq!(world.ecs.get::<Camera>(entity).unwrap(), &Camera::default());
}

#[test]
fn a_camera_and_a_material_are_animated_too() {
    let keys = |target, a, b| Track::Keys {
        node: String::new(),
        target,
        keys: vec![(0.0, a), (1.0, b)],
        interpolation: Interpolation::Linear,
        wrap: Wrap::Once,
    };
    let tracks = vec![
        keys(Target::CameraFov, KeyValue::Scalar(40.0), KeyValue::Scalar(60.0)),
        keys(Target::MaterialEmissive, KeyValue::Vector(Vec3::ZERO), KeyValue::Vector(Vec3::ONE)),
    ];
    let mut world = GameWorld::new();
    let entity = world.spawn("screen", None);
    let material = Arc::new(Material::diffuse("wall", Vec3::ONE));
    let renderer = MeshRenderer {
        mesh: Arc::new(Mesh::new("none", Vec::new(), Vec::new())),
        material: material.clone(),
        casts_shadow: true,
        visible: true,
    };
    world.ecs.entity_mut(entity).insert((Camera::default(), renderer, Animation { tracks, ..Animation::default() }));
    let emissive = |world: &GameWorld| world.ecs.get::<MeshRenderer>(entity).unwrap().material.emissive;
    world.set_seconds(0.5);
    world.update();
    assert_eq!((world.ecs.get::<Camera>(entity).unwrap().fov, emissive(&world)), (50.0, Vec3::splat(0.5)));
    assert!(Arc::ptr_eq(&world.rest_material(entity).unwrap(), &material));
    assert_eq!(world.rest_camera(entity).unwrap(), Camera::default());
    let shown = world.ecs.get::<MeshRenderer>(entity).unwrap().material.clone();
    world.update();
    assert!(Arc::ptr_eq(&world.ecs.get::<MeshRenderer>(entity).unwrap().material, &shown));
    // Another material put there is the new one at rest.
    let other = Arc::new(Material::diffuse("other", Vec3::ONE));
    world.ecs.get_mut::<MeshRenderer>(entity).unwrap().material = other.clone();
    world.update();
    assert_eq!(emissive(&world), Vec3::splat(0.5));
    assert!(Arc::ptr_eq(&world.rest_material(entity).unwrap(), &other));
    world.ecs.entity_mut(entity).remove::<Animation>();
    world.update();
    assert!(Arc::ptr_eq(&world.ecs.get::<MeshRenderer>(entity).unwrap().material, &other));
}
