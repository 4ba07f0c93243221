//! Tracks of keys for fields by path.
#![allow(clippy::unwrap_used)]

use crate::world::animation::*;
use crate::world::*;
use bevy_ecs::prelude::*;
use glam::Vec3;
use serde::{Deserialize, Serialize};

fn keys(path: &str, keys: &[(f64, KeyValue)]) -> Track {
    let target = Target::Field(path.to_owned());
    let (interpolation, wrap) = (Interpolation::Linear, Wrap::Loop);
    Track::Keys { node: String::new(), target, keys: keys.to_vec(), interpolation, wrap }
}

fn ramp(path: &str, from: f32, to: f32) -> Track {
    keys(path, &[(0.0, KeyValue::Scalar(from)), (2.0, KeyValue::Scalar(to))])
}

/// A component of a game.
#[derive(Component, Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Door {
    open: bool,
    size: [f32; 2],
    steps: u32,
    name: String,
}

fn world(tracks: Vec<Track>) -> (GameWorld, Entity) {
    let mut world = GameWorld::new();
    world.ecs.resource_mut::<fields::FieldTypes>().add("Door", fields::FieldType::of::<Door>());
    let entity = world.spawn("lamp", None);
    let door = Door { open: false, size: [1.0, 2.0], steps: 3, name: "(a, b)".into() };
    let clpv = Clpv { gain: 0.5, ..Clpv::default() };
    world.ecs.entity_mut(entity).insert((Light::default(), clpv, door, Animation { tracks, ..Animation::default() }));
    world.set_rest_settings(SceneSettings { sky: Vec3::splat(0.25), ..SceneSettings::default() });
    world.update();
    (world, entity)
}

fn at(world: &mut GameWorld, seconds: f64) {
    world.set_seconds(seconds);
    world.update();
}

fn tracks() -> Vec<Track> {
    let (low, high) = (KeyValue::Vector(Vec3::ZERO), KeyValue::Vector(Vec3::new(1.0, 2.0, 4.0)));
    vec![
        keys("scene.sky", &[(0.0, low), (2.0, high)]),
        ramp("scene.exposure", -1.0, 3.0),
        ramp("clpv.gain", 0.1, 0.9),
        ramp("light.rsm_size", 100.0, 200.0),
        keys(
            "light.indirect",
            &[(0.0, KeyValue::Flag(true)), (1.5, KeyValue::Flag(false)), (2.0, KeyValue::Flag(true))],
        ),
        keys("Door.size", &[(0.0, KeyValue::Pair(glam::Vec2::ZERO)), (2.0, KeyValue::Pair(glam::Vec2::new(2.0, 8.0)))]),
        ramp("Door.steps", 0.0, 9.0),
        ramp("Door.open", 0.0, 1.0),
        ramp("transform.translation.y", 0.0, 6.0),
        ramp("transform.rotation.1", 0.0, 80.0),
    ]
}

type Shown = (SceneSettings, Clpv, Light, Door, Transform);

fn shown(world: &GameWorld, entity: Entity) -> Shown {
    let ecs = &world.ecs;
    (
        ecs.resource::<SceneSettings>().clone(),
        ecs.get::<Clpv>(entity).unwrap().clone(),
        ecs.get::<Light>(entity).unwrap().clone(),
        ecs.get::<Door>(entity).unwrap().clone(),
        *ecs.get::<Transform>(entity).unwrap(),
    )
}

#[test]
fn fields_follow_their_keys_however_a_frame_is_reached() {
    let (mut world, entity) = world(tracks());
    at(&mut world, 0.5);
    let (settings, clpv, light, door, transform) = shown(&world, entity);
    assert_eq!((settings.sky, settings.exposure), (Vec3::new(0.25, 0.5, 1.0), 0.0));
    assert_eq!((clpv.gain, clpv.steps), (0.1 + 0.25 * (0.9 - 0.1), Clpv::default().steps));
    assert_eq!((light.rsm_size, light.indirect), (125, true));
    assert_eq!((door.size, door.steps, door.open, door.name.as_str()), ([0.5, 2.0], 2, false, "(a, b)"));
    assert_eq!(transform.translation, Vec3::new(0.0, 1.5, 0.0));
    assert!(transform.rotation.abs_diff_eq(glam::Quat::from_rotation_y(20_f32.to_radians()), 1e-5));
    let first = shown(&world, entity);
    at(&mut world, 1.75);
    let (_, _, light, door, _) = shown(&world, entity);
    assert!(!light.indirect && door.open);
    // Back, and round the loop.
    at(&mut world, 0.5);
    assert_eq!(shown(&world, entity), first);
    at(&mut world, 6.5);
    assert_eq!(shown(&world, entity), first);
    let (mut stepped, other) = self::world(tracks());
    for _ in 0..15 {
        stepped.advance(1);
        stepped.update();
    }
    assert_eq!(shown(&stepped, other), first);
}

#[test]
fn own_values_are_kept_and_come_back() {
    let (mut world, entity) = world(tracks());
    let (before, door) = (world.rest_settings(), world.ecs.get::<Door>(entity).cloned().unwrap());
    at(&mut world, 0.7);
    assert_eq!((before.sky, world.rest_settings()), (Vec3::splat(0.25), before.clone()));
    assert_eq!(world.rest_component::<Clpv>(entity, "clpv").unwrap().gain, 0.5);
    assert_eq!(world.rest_light(entity), Some(Light::default()));
    let rest: Door = world.rest_component(entity, "Door").unwrap();
    assert!(rest.steps == 3 && rest.size == [1.0, 2.0] && rest != door);
    // A copy plays on with own values of its own.
    let copy = world.clone_subtree(entity).unwrap();
    at(&mut world, 0.9);
    assert_eq!(world.rest_component::<Clpv>(copy, "clpv").unwrap().gain, 0.5);
    for entity in [entity, copy] {
        world.ecs.entity_mut(entity).remove::<Animation>();
    }
    world.update();
    world.update();
    assert_eq!(*world.ecs.resource::<SceneSettings>(), before);
    for entity in [entity, copy] {
        assert_eq!(
            (world.ecs.get::<Door>(entity), world.ecs.get::<Light>(entity)),
            (Some(&rest), Some(&Light::default()))
        );
        assert!(world.ecs.get::<RestPose>(entity).is_none());
    }
}

#[test]
fn a_new_value_becomes_the_own_one_while_it_plays() {
    let (mut world, entity) = world(tracks());
    at(&mut world, 0.5);
    // By whoever writes to the component: a game, the command line.
    world.ecs.get_mut::<Clpv>(entity).unwrap().gain = 0.75;
    world.ecs.resource_mut::<SceneSettings>().exposure = 9.0;
    world.update();
    let shown = world.ecs.get::<Clpv>(entity).unwrap().gain;
    assert!((shown - 0.3).abs() < 1e-6 && world.ecs.resource::<SceneSettings>().exposure == 0.0);
    assert_eq!(
        (world.rest_component::<Clpv>(entity, "clpv").unwrap().gain, world.rest_settings().exposure),
        (0.75, 9.0)
    );
    // By an edit, even to what is shown at that moment.
    world.release_fields(entity, "clpv");
    world.ecs.get_mut::<Clpv>(entity).unwrap().gain = shown;
    world.set_rest_settings(SceneSettings { exposure: 0.0, ..world.rest_settings() });
    world.update();
    assert_eq!(
        (world.rest_component::<Clpv>(entity, "clpv").unwrap().gain, world.rest_settings().exposure),
        (shown, 0.0)
    );
    at(&mut world, 1.0);
    assert_eq!(
        (world.rest_component::<Clpv>(entity, "clpv").unwrap().gain, world.rest_settings().exposure),
        (shown, 0.0)
    );
}

#[test]
fn the_last_track_holds_and_paths_mean_what_names_mean() {
    let both = vec![
        ramp("light.intensity", 1.0, 1.0),
        Track::Keys {
            node: String::new(),
            target: Target::LightIntensity,
            keys: vec![(0.0, KeyValue::Scalar(7.0))],
            interpolation: Interpolation::Linear,
            wrap: Wrap::Once,
        },
        ramp("scene.exposure", 1.0, 1.0),
        ramp("scene.exposure", 2.0, 2.0),
    ];
    let (mut world, entity) = world(both);
    let second = world.spawn("second", None);
    let animation = Animation { tracks: vec![ramp("scene.exposure", 4.0, 4.0)], ..Animation::default() };
    assert_eq!((shown(&world, entity).2.intensity, shown(&world, entity).0.exposure), (7.0, 2.0));
    assert_eq!(world.rest_light(entity).unwrap().intensity, 1.0);
    // The entity that was made later has the last word over the scene.
    world.ecs.entity_mut(second).insert(animation);
    world.update();
    assert_eq!(shown(&world, entity).0.exposure, 4.0);
    world.ecs.get_mut::<Animation>(second).unwrap().playing = false;
    world.update();
    assert_eq!(shown(&world, entity).0.exposure, 2.0);
}

#[test]
fn what_does_not_change_is_not_written() {
    let (mut world, _) = world(vec![ramp("clpv.gain", 0.1, 0.9), ramp("scene.exposure", 0.0, 1.0)]);
    at(&mut world, 0.3);
    #[derive(Resource, Default)]
    struct Written(u32);
    world.ecs.init_resource::<Written>();
    world.add_systems(
        |changed: Query<(), Changed<Clpv>>, settings: Res<SceneSettings>, mut written: ResMut<Written>| {
            written.0 += u32::from(!changed.is_empty()) + u32::from(settings.is_changed());
        },
    );
    world.update();
    world.ecs.resource_mut::<Written>().0 = 0;
    world.update();
    world.update();
    assert_eq!(world.ecs.resource::<Written>().0, 0);
    at(&mut world, 0.4);
    world.update();
    assert!(world.ecs.resource::<Written>().0 > 0);
}

#[test]
fn splines_of_fields_do_not_swing_below_zero() {
    let cubic = |path: &str, values: [f32; 4]| Track::Keys {
        node: String::new(),
        target: Target::Field(path.to_owned()),
        keys: [0.0, 1.0, 2.0, 3.0].into_iter().zip(values.map(KeyValue::Scalar)).collect(),
        interpolation: Interpolation::Cubic,
        wrap: Wrap::Once,
    };
    let (mut world, entity) =
        world(vec![cubic("clpv.gain", [4.0, 0.0, 0.0, 4.0]), cubic("scene.exposure", [4.0, 0.0, 0.0, -4.0])]);
    at(&mut world, 1.5);
    assert_eq!(shown(&world, entity).1.gain, 0.0);
    at(&mut world, 2.2);
    assert!(shown(&world, entity).0.exposure < 0.0);
}
