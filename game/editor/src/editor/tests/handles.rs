//! Handles in the view by mouse: move, rotate and scale, with and without steps.

use super::*;
use crate::editor::gizmo::Lens;
use egui::{Key, Modifiers, Pos2};
use glam::Vec3;
use lightwell::world::{GlobalTransform, Transform};

const PATH: &str = "Group/Cube";

fn rest(bench: &Bench) -> Transform {
    let desk = bench.state();
    desk.world.rest_transform(desk.world.find(PATH).unwrap())
}

/// A point so many points aside of the origin of the handles, along directions of the screen.
fn beside(bench: &Bench, right: f32, up: f32) -> Pos2 {
    let desk = bench.state();
    let lens = Lens::new(&desk.scene.cameras[0], bench.get_by_label("Picture").rect());
    let entity = desk.world.find(PATH).unwrap();
    let origin: Vec3 = desk.world.ecs.get::<GlobalTransform>(entity).unwrap().position();
    lens.point(origin).unwrap() + egui::vec2(right, -up)
}

fn selected(mode: &str) -> (Bench, tempfile::TempDir) {
    let (mut bench, folder) = bench();
    bench.state_mut().select(PATH);
    bench.run_steps(3);
    // Buttons of the bar; the inspector has fields of these names too.
    let bar = bench.query_all_by_label(mode).find(|node| node.rect().top() < 25.0).unwrap().rect().center();
    bench.hover_at(bar);
    bench.drag_at(bar);
    bench.drop_at(bar);
    bench.run_steps(3);
    (bench, folder)
}

#[test]
fn a_ring_rotates_in_steps_if_that_is_wanted() {
    let (mut bench, _folder) = selected("Rotate");
    let before = (rest(&bench), bench.state().text());
    // The ring about the axis towards the eye, where no other ring passes; by some 40° counter-clockwise.
    let at = |angle: f32| (80.0 * angle.to_radians().cos(), 80.0 * angle.to_radians().sin());
    let ((x, y), (u, v)) = (at(45.0), at(85.0));
    let (from, to) = (beside(&bench, x, y), beside(&bench, u, v));
    drag(&mut bench, from, to);
    let angle = |bench: &Bench| rest(bench).rotation.angle_between(before.0.rotation).to_degrees();
    assert!((angle(&bench) - 40.0).abs() < 6.0, "{}", angle(&bench));
    assert_eq!(bench.state().editor.history.undo_label(), Some("rotate"));
    assert!((rest(&bench).translation - before.0.translation).length() < 1e-5, "it turns about itself");
    press(&mut bench, Modifiers::COMMAND, Key::Z);
    assert_eq!(bench.state().text(), before.1);
    click(&mut bench, "snap");
    drag(&mut bench, from, to);
    let steps = angle(&bench) / 15.0;
    assert!((steps - steps.round()).abs() < 1e-2 && steps > 1.5, "in steps of 15°: {}", angle(&bench));
}

#[test]
fn a_knob_scales_in_steps_if_that_is_wanted() {
    let (mut bench, _folder) = selected("Scale");
    let before = bench.state().text();
    let (from, to) = (beside(&bench, 0.0, 0.0), beside(&bench, 33.0, 30.0));
    drag(&mut bench, from, to);
    let scale = rest(&bench).scale;
    assert!((scale - Vec3::splat(1.0 + 63.0 / 80.0)).length() < 0.03, "the middle scales all axes alike: {scale}");
    assert_eq!(bench.state().editor.history.undo_label(), Some("scale"));
    press(&mut bench, Modifiers::COMMAND, Key::Z);
    assert_eq!(bench.state().text(), before);
    // Up is an axis of its own.
    click(&mut bench, "snap");
    let (from, to) = (beside(&bench, 0.0, 70.0), beside(&bench, 0.0, 113.0));
    drag(&mut bench, from, to);
    let scale = rest(&bench).scale;
    let steps = scale.y / 0.1;
    assert!(scale.x == 1.0 && scale.z == 1.0 && scale.y > 1.3, "{scale}");
    assert!((steps - steps.round()).abs() < 1e-3, "in steps of a tenth: {scale}");
}

#[test]
fn a_move_goes_in_steps_if_that_is_wanted() {
    let (mut bench, _folder) = selected("Move");
    // The button of the handle that is shown takes it away; once more brings it back.
    assert_eq!(bench.state().editor.view.mode, crate::editor::gizmo::Mode::None);
    press(&mut bench, Modifiers::NONE, Key::Num1);
    click(&mut bench, "snap");
    let before = rest(&bench).translation;
    let (from, to) = (beside(&bench, 0.0, 40.0), beside(&bench, 7.0, 83.0));
    drag(&mut bench, from, to);
    let by = rest(&bench).translation - before;
    let steps = by.y / 0.1;
    assert!(by.x.abs() < 1e-5 && by.z.abs() < 1e-5 && by.y > 0.15, "{by}");
    assert!((steps - steps.round()).abs() < 1e-3, "in steps of 0.1 m: {by}");
}
