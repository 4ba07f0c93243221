use crate::world::animation::*;
use crate::world::{Clock, Transform};
use glam::{Quat, Vec3};

fn scalar(keys: &[(f64, f32)], interpolation: Interpolation, wrap: Wrap) -> Animation {
    let keys = keys.iter().map(|(t, v)| (*t, KeyValue::Scalar(*v))).collect();
    let track = Track::Keys { node: String::new(), target: Target::LightIntensity, keys, interpolation, wrap };
    Animation { tracks: vec![track], ..Animation::default() }
}

fn at(animation: &Animation, seconds: f64) -> f32 {
    animation.validate().unwrap();
    let sample = animation.sample(&Clock::at_seconds(seconds, 30), &Transform::default());
    sample.intensity.unwrap()
}

#[test]
fn step_linear_and_cubic_give_their_values() {
    let keys = [(0.0, 1.0), (1.0, 3.0), (2.0, 2.0), (4.0, 6.0)];
    let step = scalar(&keys, Interpolation::Step, Wrap::Once);
    let linear = scalar(&keys, Interpolation::Linear, Wrap::Once);
    let cubic = scalar(&keys, Interpolation::Cubic, Wrap::Once);
    for (time, value) in keys {
        for animation in [&step, &linear, &cubic] {
            assert_eq!(at(animation, time), value, "{time} s");
        }
    }
    assert_eq!((at(&step, 0.99), at(&linear, 0.5), at(&linear, 3.0)), (1.0, 2.0, 4.0));
    // Tangents (2−1)/2 = ½ at 1 s and (6−3)/3 = 1 at 2 s; Hermite at the middle: (a+b)/2 + (m₀−m₁)/8.
    assert_eq!(at(&cubic, 1.5), 2.5 + (0.5 - 1.0) / 8.0);
    // Equal steps along a line stay a line.
    let line = scalar(&[(0.0, 0.0), (1.0, 2.0), (2.0, 4.0), (3.0, 6.0)], Interpolation::Cubic, Wrap::Once);
    assert!((at(&line, 1.25) - 2.5).abs() < 1e-6 && (at(&line, 2.9) - 5.8).abs() < 1e-6);
}

#[test]
fn wraps_hold_repeat_and_run_back() {
    let keys = [(0.0, 1.0), (2.0, 3.0)];
    let values = |wrap| [0.5, 2.0, 2.5, 4.5].map(|t| at(&scalar(&keys, Interpolation::Linear, wrap), t));
    assert_eq!(values(Wrap::Once), [1.5, 3.0, 3.0, 3.0]);
    assert_eq!(values(Wrap::Loop), [1.5, 1.0, 1.5, 1.5]);
    assert_eq!(values(Wrap::PingPong), [1.5, 3.0, 2.5, 1.5]);
    let late = scalar(&[(1.0, 5.0), (2.0, 6.0)], Interpolation::Linear, Wrap::Loop);
    assert_eq!([0.0, 1.5, 2.25].map(|t| at(&late, t)), [5.0, 5.5, 5.0]);
    let single = scalar(&[(0.0, 5.0)], Interpolation::Cubic, Wrap::Loop);
    assert_eq!(at(&single, 7.0), 5.0);
}

#[test]
fn speed_and_offset_shift_the_tracks() {
    let keys = [(0.0, 0.0), (10.0, 10.0)];
    let with = |speed, offset| Animation { speed, offset, ..scalar(&keys, Interpolation::Linear, Wrap::Loop) };
    assert_eq!([at(&with(2.0, 1.0), 1.0), at(&with(-1.0, 1.0), 3.0), at(&with(0.0, 4.0), 3.0)], [3.0, 8.0, 4.0]);
}

#[test]
fn a_closed_cubic_loop_is_smooth_over_its_seam() {
    let circle: Vec<(f64, f32)> =
        (0..=8).map(|i| (f64::from(i), 2.0 + (i as f32 * std::f32::consts::FRAC_PI_4).sin())).collect();
    let mut closed = circle.clone();
    closed[8].1 = closed[0].1;
    let animation = scalar(&closed, Interpolation::Cubic, Wrap::Loop);
    let slope = |t: f64| (at(&animation, t + 0.01) - at(&animation, t)) / 0.01;
    assert!((slope(7.99) - slope(0.0)).abs() < 0.02, "{} {}", slope(7.99), slope(0.0));
}

fn rotations(keys: Vec<(f64, KeyValue)>, interpolation: Interpolation) -> Animation {
    let track = Track::Keys { node: String::new(), target: Target::Rotation, keys, interpolation, wrap: Wrap::Once };
    Animation { tracks: vec![track], ..Animation::default() }
}

#[test]
fn rotations_take_the_shortest_arc_at_even_speed() {
    let end = Quat::from_rotation_y(2.0);
    for end in [end, -end, end * 3.0] {
        let keys = vec![(0.0, KeyValue::Vector(Vec3::ZERO)), (1.0, KeyValue::Quaternion(end))];
        for interpolation in [Interpolation::Linear, Interpolation::Cubic] {
            let animation = rotations(keys.clone(), interpolation);
            for s in [0.0, 0.25, 0.5, 1.0] {
                let sample = animation.sample(&Clock::at_seconds(s, 30), &Transform::default());
                let q = sample.rotation.unwrap();
                assert!(q.is_normalized());
                let tolerance = if interpolation == Interpolation::Linear { 1e-3 } else { 0.1 };
                assert!(
                    q.angle_between(Quat::from_rotation_y(2.0 * s as f32)) < tolerance,
                    "{s} {interpolation:?} {q}"
                );
            }
        }
    }
    assert!(
        rotation_from_degrees(Vec3::new(0.0, 90.0, 0.0)).abs_diff_eq(Quat::from_rotation_y(90_f32.to_radians()), 1e-6)
    );
}

fn spin(axis: Vec3, degrees_per_second: f64) -> Track {
    Track::Spin { axis, degrees_per_second }
}

fn orbit(radius: f32, period: f64) -> Track {
    Track::Orbit { center: Vec3::ZERO, axis: Vec3::Y, radius, period, phase: 0.0, look_at_center: true }
}

fn keys(target: Target, keys: Vec<(f64, KeyValue)>) -> Track {
    Track::Keys { node: String::new(), target, keys, interpolation: Interpolation::Cubic, wrap: Wrap::Loop }
}

#[test]
fn meaningless_input_is_named() {
    use KeyValue::{Quaternion, Scalar, Vector};
    let fault = |track| Animation { tracks: vec![track], ..Animation::default() }.validate().unwrap_err();
    for axis in [Vec3::ZERO, Vec3::NAN, Vec3::INFINITY] {
        assert!(matches!(fault(spin(axis, 1.0)), AnimationError::Axis { track: 0, .. }));
    }
    for rate in [f64::NAN, f64::INFINITY, 1e300, 1e-300] {
        assert!(matches!(fault(spin(Vec3::Y, rate)), AnimationError::Number { field: "degrees_per_second", .. }));
    }
    for period in [0.0, f64::NAN, f64::INFINITY, 1e-300] {
        assert!(matches!(fault(orbit(1.0, period)), AnimationError::Number { field: "period", .. }));
    }
    for radius in [-1.0, f32::NAN, f32::INFINITY] {
        assert!(matches!(fault(orbit(radius, 1.0)), AnimationError::Number { field: "radius", .. }));
    }
    let number = |t| (t, Scalar(1.0));
    let intensity = Target::LightIntensity;
    assert!(matches!(fault(keys(intensity.clone(), vec![])), AnimationError::NoKeys { track: 0 }));
    for (a, b) in [(1.0, 0.5), (1.0, 1.0)] {
        assert!(matches!(
            fault(keys(intensity.clone(), vec![number(a), number(b)])),
            AnimationError::Unsorted { key: 1, .. }
        ));
    }
    for t in [f64::NAN, -1.0, f64::INFINITY] {
        assert!(matches!(fault(keys(intensity.clone(), vec![number(t)])), AnimationError::Time { key: 0, .. }));
    }
    for (target, value) in [
        (intensity.clone(), Scalar(f32::NAN)),
        (intensity.clone(), Vector(Vec3::ONE)),
        (Target::Translation, Scalar(1.0)),
        (Target::Translation, Vector(Vec3::NAN)),
        (Target::Rotation, Scalar(1.0)),
        (Target::Rotation, Quaternion(Quat::from_xyzw(0.0, 0.0, 0.0, 0.0))),
        (Target::MaterialEmissive, Quaternion(Quat::IDENTITY)),
    ] {
        assert!(
            matches!(fault(keys(target.clone(), vec![(0.0, value)])), AnimationError::Value { key: 0, .. }),
            "{target:?}"
        );
    }
    let timed = Animation { speed: f64::NAN, ..Animation::default() };
    assert!(matches!(timed.validate(), Err(AnimationError::Timing { field: "speed", .. })));
    let text = fault(keys(intensity.clone(), vec![number(1.0), number(0.5)])).to_string();
    assert_eq!(text, "track 0, key 1: time 0.5 does not come after 1, that of the key before: sort the keys");
}

#[test]
fn meaningless_input_never_reaches_the_pose() {
    use crate::world::{Animation as Component, GameWorld, GlobalTransform};
    for track in [
        spin(Vec3::ZERO, 1.0),
        orbit(f32::NAN, 0.0),
        keys(Target::Translation, vec![(0.0, KeyValue::Vector(Vec3::NAN))]),
    ] {
        let mut world = GameWorld::new();
        let entity = world.spawn("bad", None);
        world.ecs.entity_mut(entity).insert(Component { tracks: vec![track], ..Component::default() });
        world.set_seconds(1.3);
        world.update();
        assert_eq!(*world.ecs.get::<GlobalTransform>(entity).unwrap(), GlobalTransform::default());
        world.ecs.get_mut::<Component>(entity).unwrap().tracks = vec![orbit(1.0, 4.0)];
        world.update();
        assert_ne!(*world.ecs.get::<GlobalTransform>(entity).unwrap(), GlobalTransform::default());
    }
    // Valid, but too large for the spline: no infinity comes out.
    let huge = keys(
        Target::Translation,
        vec![
            (0.0, KeyValue::Vector(Vec3::MAX)),
            (0.1, KeyValue::Vector(Vec3::MIN)),
            (9.0, KeyValue::Vector(Vec3::MAX)),
        ],
    );
    let animation = Animation { tracks: vec![huge], ..Animation::default() };
    animation.validate().unwrap();
    for i in 0..100 {
        let sample = animation.sample(&Clock::at_tick(i, 10), &Transform::default());
        assert!(sample.translation.is_none_or(Vec3::is_finite));
    }
}

#[test]
fn animations_survive_a_file() {
    let text = "(tracks: [
        Spin(axis: (0, 1, 0), degrees_per_second: 45),
        Orbit(radius: 2, period: 4.5, look_at_center: true),
        Keys(target: Rotation, keys: [(0, (0, 90, 0)), (1.5, (0.0, 0.0, 0.0, 1.0))], interpolation: Cubic, wrap: Once),
        Keys(target: LightIntensity, keys: [(0.0, 1), (2, 3.5)]),
    ], speed: 2)";
    let animation: Animation = ron::from_str(text).unwrap();
    animation.validate().unwrap();
    assert_eq!(animation.tracks.len(), 4);
    let Track::Keys { keys, wrap, .. } = &animation.tracks[2] else { panic!() };
    assert_eq!((keys[0].1, *wrap), (KeyValue::Vector(Vec3::new(0.0, 90.0, 0.0)), Wrap::Once));
    assert_eq!(keys[1].1, KeyValue::Quaternion(Quat::IDENTITY));
    let again: Animation = ron::from_str(&ron::to_string(&animation).unwrap()).unwrap();
    assert_eq!(again, animation);
    for bad in [
        "(trakcs: [])",
        "(tracks: [Spin(axis: (0, 1, 0), degrees: 1)])",
        "(tracks: [Keys(target: Scale, keys: [(0, (1, 2, 3, 4, 5))])])",
    ] {
        assert!(ron::from_str::<Animation>(bad).is_err(), "{bad}");
    }
    let error = ron::from_str::<Animation>("(tracks: [Keys(target: Scale, keys: [(0, ())])])").unwrap_err();
    assert!(error.to_string().contains("a number, (x, y), (x, y, z), (x, y, z, w), true or false"), "{error}");
}
