#![allow(clippy::unwrap_used)]
use super::*;
use egui::pos2;
use glam::Quat;
use lightwell::scene::SceneCamera;
use lightwell::scene::ViewProjection;
use lightwell::world::Transform;

const PERSPECTIVE: ViewProjection = ViewProjection::Perspective { vertical_fov: 1.0 };
const BOTH: [ViewProjection; 2] = [PERSPECTIVE, ViewProjection::Orthographic { height: 6.0 }];

fn lens(projection: ViewProjection) -> Lens {
    let camera = SceneCamera {
        id: SceneId(1),
        name: "c".into(),
        world_from_view: Affine3A::from_translation(Vec3::new(0.0, 0.0, 5.0)),
        projection,
        near: 0.1,
        far: None,
        primary: true,
        lens: Default::default(),
        grading: None,
    };
    Lens::new(&camera, Rect::from_min_size(pos2(10.0, 20.0), egui::vec2(400.0, 300.0)))
}

fn drag(mode: Mode, grip: Grip, start: Pos2) -> Drag {
    Drag { mode, grip, origin: Vec3::ZERO, axes: Mat3::IDENTITY, start, parts: Vec::new() }
}

#[test]
fn a_drag_along_an_axis_follows_the_pointer() {
    BOTH.iter().for_each(|projection| drag_along_an_axis(&lens(*projection)));
}

fn drag_along_an_axis(lens: &Lens) {
    let (from, to) = (Vec3::X * 0.3, Vec3::X * 1.1);
    let drag = drag(Mode::Move, Grip::Axis(0), lens.point(from).unwrap());
    let Some(Motion::Move(by)) = motion(&drag, lens, lens.point(to).unwrap(), false) else { panic!() };
    assert!(by.abs_diff_eq(Vec3::X * 0.8, 1e-3), "{by}");
    let near = lens.point(to + Vec3::new(0.0, 0.4, 0.0)).unwrap();
    let Some(Motion::Move(by)) = motion(&drag, lens, near, true) else { panic!() };
    assert!((by.x / 0.1 - (by.x / 0.1).round()).abs() < 1e-3 && by.y == 0.0, "{by} is in steps");
}

#[test]
fn handles_are_hit_where_they_are_drawn() {
    BOTH.iter().for_each(|projection| handles_are_hit(&lens(*projection)));
}

fn handles_are_hit(lens: &Lens) {
    let length = lens.length(Vec3::ZERO, LENGTH);
    let axes = Mat3::IDENTITY;
    let at = |p: Vec3| lens.point(p).unwrap();
    assert_eq!(grip_at(lens, Mode::Move, Vec3::ZERO, &axes, at(Vec3::X * length * 0.7)), Some(Grip::Axis(0)));
    assert_eq!(grip_at(lens, Mode::Move, Vec3::ZERO, &axes, at(Vec3::ZERO)), Some(Grip::Center));
    assert_eq!(grip_at(lens, Mode::Rotate, Vec3::ZERO, &axes, at(Vec3::Y * length)), Some(Grip::Axis(0)));
    assert_eq!(grip_at(lens, Mode::Scale, Vec3::ZERO, &axes, at(Vec3::splat(length))), None);
}

#[test]
fn what_lies_before_an_orthographic_camera_is_cut_off() {
    let lens = lens(BOTH[1]);
    assert_eq!((lens.point(Vec3::Z * 4.0).is_some(), lens.point(Vec3::Z * 5.5)), (true, None));
    let (a, b) = lens.segment(Vec3::new(1.0, 0.0, 9.9), Vec3::new(-1.0, 0.0, -0.1)).unwrap();
    assert!((a.x - 210.0).abs() < 1e-2 && (b.x - 160.0).abs() < 1e-2, "{a:?} {b:?}: 50 points a metre");
    // Handles are as large wherever they stand.
    assert_eq!(lens.length(Vec3::ZERO, 50.0), lens.length(Vec3::Z * -30.0, 50.0));
}

#[test]
fn a_quarter_turn_is_a_quarter_turn() {
    let lens = lens(PERSPECTIVE);
    let center = lens.point(Vec3::ZERO).unwrap();
    let drag = drag(Mode::Rotate, Grip::Axis(2), center + egui::vec2(50.0, 0.0));
    let Some(Motion::Rotate(q)) = motion(&drag, &lens, center + egui::vec2(0.0, -50.0), false) else { panic!() };
    assert!((q * Vec3::X).abs_diff_eq(Vec3::Y, 1e-4), "counter-clockwise, seen from +Z");
}

#[test]
fn parents_are_taken_into_account() {
    let parent = Affine3A::from_scale_rotation_translation(
        Vec3::splat(2.0),
        Quat::from_rotation_y(TAU / 4.0),
        Vec3::new(1.0, 2.0, 3.0),
    );
    let before = Transform { translation: Vec3::new(0.5, 0.0, 0.0), ..Transform::default() };
    let place = |t: &Transform| (parent * t.matrix()).translation;
    let now = moved(&before, &parent, Vec3::ZERO, Motion::Move(Vec3::X));
    assert!((place(&now) - place(&before)).abs_diff_eq(Vec3::X.into(), 1e-5));
    let turn = Quat::from_rotation_y(0.3);
    let around: Vec3 = place(&before).into();
    let now = moved(&before, &parent, around, Motion::Rotate(turn));
    assert_eq!(now.translation, before.translation, "a turn around itself moves nothing");
    let world = |t: &Transform| (parent * t.matrix()).to_scale_rotation_translation().1;
    assert!(world(&now).abs_diff_eq(turn * world(&before), 1e-5));
}

#[test]
fn lines_are_cut_at_the_camera() {
    let lens = lens(PERSPECTIVE);
    assert!(lens.segment(Vec3::new(0.0, 0.0, 20.0), Vec3::new(0.0, 0.0, 30.0)).is_none());
    let (a, b) = lens.segment(Vec3::new(0.5, 0.0, 20.0), Vec3::new(0.5, 0.0, 0.0)).unwrap();
    assert!(a.x.is_finite() && b.x.is_finite());
}

#[test]
fn tracks_move_along_with_what_they_place() {
    use super::animated::Pose;
    use lightwell::world::Animation;
    use lightwell::world::animation::{Interpolation, KeyValue, Target, Track, Wrap};
    let keys = |target, values: [KeyValue; 2]| Track::Keys {
        node: String::new(),
        target,
        keys: vec![(0.0, values[0]), (1.0, values[1])],
        interpolation: Interpolation::Linear,
        wrap: Wrap::Once,
    };
    let tracks = vec![
        keys(Target::Translation, [KeyValue::Vector(Vec3::ZERO), KeyValue::Vector(Vec3::X * 4.0)]),
        keys(Target::Scale, [KeyValue::Scalar(1.0), KeyValue::Scalar(3.0)]),
        keys(Target::Rotation, [KeyValue::Vector(Vec3::ZERO), KeyValue::Vector(Vec3::Y * 720.0)]),
    ];
    let shown = Transform { translation: Vec3::X * 2.0, scale: Vec3::splat(2.0), ..Transform::default() };
    let animation = Some(Animation { tracks, ..Animation::default() });
    let before = Pose { shown, rest: Transform::default(), animation };
    let now = Transform { translation: Vec3::new(2.0, 1.0, 0.0), scale: Vec3::splat(4.0), ..shown };
    let (moved, refused) = before.shown_at(&now);
    assert_eq!((moved.rest.translation, moved.rest.scale, refused), (Vec3::Y, Vec3::splat(2.0), None));
    let tracks = moved.animation.unwrap().tracks;
    let wanted = [KeyValue::Vector(Vec3::Y), KeyValue::Vector(Vec3::new(4.0, 1.0, 0.0))];
    assert_eq!(tracks[0], keys(Target::Translation, wanted));
    assert_eq!(tracks[1], keys(Target::Scale, [KeyValue::Scalar(2.0), KeyValue::Scalar(6.0)]));
    let turned = Transform { rotation: Quat::from_rotation_y(0.5), ..shown };
    let (moved, refused) = before.shown_at(&turned);
    assert!(refused.is_some_and(|why| why.contains("Animation")));
    assert_eq!(moved.animation, before.animation, "angles stay");
}
