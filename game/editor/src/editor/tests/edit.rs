//! Edits through the inspector and the view, with undo.

use super::*;
use egui::{Key, Modifiers};
use lightwell::world::{
    Bloom, Camera, Clpv, DepthOfField, Fog, FogShape, Lens, Light, LightKind, Particles, Transform,
};

fn light(desk: &Desk) -> Light {
    desk.world.rest_light(desk.world.find("Lamp").unwrap()).unwrap()
}

#[test]
fn looking_changes_nothing() {
    let (mut bench, _folder) = bench();
    let before = (bench.state().scene.revisions, bench.state().text());
    for path in ["Camera", "Lamp", "Group", "Group/Ball", "Mover"] {
        bench.state_mut().select(path);
        for pane in super::super::layout::PANES {
            open(&mut bench, pane);
        }
    }
    bench.run_steps(10);
    let desk = bench.state();
    assert_eq!((desk.scene.revisions, desk.text()), before);
    assert!(!desk.editor.history.is_dirty());
}

#[test]
fn a_kind_is_chosen_undone_and_done_again() {
    let (mut bench, _folder) = bench();
    let before = bench.state().text();
    bench.state_mut().select("Lamp");
    bench.run_steps(3);
    click(&mut bench, "Kind");
    click(&mut bench, "Spot");
    assert_eq!(light(bench.state()).kind, LightKind::Spot { inner: 20.0, outer: 30.0 });
    assert!(bench.state().editor.history.is_dirty());
    press(&mut bench, Modifiers::COMMAND, Key::Z);
    assert_eq!((light(bench.state()).kind, bench.state().text()), (LightKind::Point, before));
    assert!(!bench.state().editor.history.is_dirty(), "as it was saved");
    press(&mut bench, Modifiers::COMMAND, Key::Y);
    assert!(matches!(light(bench.state()).kind, LightKind::Spot { .. }));
}

#[test]
fn a_drag_is_one_step() {
    let (mut bench, _folder) = bench();
    bench.state_mut().select("Lamp");
    bench.run_steps(3);
    let at = place_of(&bench, "Intensity");
    drag(&mut bench, at, at + egui::vec2(60.0, 0.0));
    let changed = light(bench.state()).intensity;
    assert!(changed > 20.5, "{changed}");
    press(&mut bench, Modifiers::COMMAND, Key::Z);
    assert_eq!(light(bench.state()).intensity, 20.0);
    assert_eq!(bench.state().editor.history.undo_label(), None, "one step, not one a frame");
}

#[test]
fn components_come_and_go() {
    let (mut bench, _folder) = bench();
    bench.state_mut().select("Group/Ball");
    bench.run_steps(3);
    click(&mut bench, "Add component");
    click(&mut bench, "Clpv");
    let has = |bench: &Bench| {
        let desk = bench.state();
        desk.world.ecs.get::<Clpv>(desk.world.find("Group/Ball").unwrap()).cloned()
    };
    assert_eq!(has(&bench), Some(Clpv::default()));
    click(&mut bench, "Remove Clpv");
    assert_eq!(has(&bench), None);
    press(&mut bench, Modifiers::COMMAND, Key::Z);
    assert_eq!(has(&bench), Some(Clpv::default()));
}

/// Types a number into a field.
fn enter(bench: &mut Bench, field: &str, number: &str) {
    find(bench, field).focus();
    bench.run_steps(2);
    press(bench, Modifiers::COMMAND, Key::A);
    bench.event(egui::Event::Text(number.into()));
    press(bench, Modifiers::NONE, Key::Enter);
}

#[test]
fn fog_is_added_edited_and_undone() {
    let (mut bench, _folder) = bench();
    let before = bench.state().text();
    click(&mut bench, "Add");
    click(&mut bench, "Fog");
    let fog = |bench: &Bench| {
        let desk = bench.state();
        desk.world.find("Fog").map(|entity| *desk.world.ecs.get::<Fog>(entity).unwrap())
    };
    let added = fog(&bench).unwrap();
    assert!(matches!(added.shape, FogShape::Box { .. }) && bench.state().scene.media.len() == 1, "{added:?}");
    enter(&mut bench, "Extinction", "0.75");
    assert_eq!(fog(&bench), Some(Fog { extinction: 0.75, ..added }));
    assert_eq!(bench.state().scene.media[0].extinction, 0.75);
    enter(&mut bench, "Anisotropy", "-7");
    assert_eq!(fog(&bench).unwrap().anisotropy, -0.95, "within its range");
    click(&mut bench, "Shape");
    click(&mut bench, "Everywhere");
    assert_eq!(fog(&bench).unwrap().shape, FogShape::Everywhere);
    for _ in 0..4 {
        press(&mut bench, Modifiers::COMMAND, Key::Z);
    }
    assert_eq!((fog(&bench), bench.state().text()), (None, before));
    assert!(bench.state().scene.media.is_empty());
    press(&mut bench, Modifiers::COMMAND, Key::Y);
    press(&mut bench, Modifiers::COMMAND, Key::Y);
    assert_eq!(fog(&bench).unwrap().extinction, 0.75);
    let text = bench.state().text();
    assert!(text.contains("extinction: 0.75"), "{text}");
}

#[test]
fn particles_are_added_edited_and_saved() {
    let (mut bench, _folder) = bench();
    let before = bench.state().text();
    click(&mut bench, "Add");
    click(&mut bench, "Particles");
    let particles = |bench: &Bench| {
        let desk = bench.state();
        desk.world.find("Particles").map(|entity| *desk.world.ecs.get::<Particles>(entity).unwrap())
    };
    let count = |bench: &Bench| bench.state().scene.primitives.iter().filter(|p| p.is_particles()).count();
    assert_eq!((particles(&bench), count(&bench)), (Some(Particles::default()), 1));
    enter(&mut bench, "Rate", "75");
    enter(&mut bench, "Speed variation", "7");
    let wanted = Particles { rate: 75.0, speed_variation: 1.0, ..Particles::default() };
    assert_eq!(particles(&bench), Some(wanted), "within its range");
    let text = bench.state().text();
    assert!(text.contains("particles: (rate: 75") && text.contains("speed_variation: 1"), "{text}");
    for _ in 0..3 {
        press(&mut bench, Modifiers::COMMAND, Key::Z);
    }
    assert_eq!((particles(&bench), count(&bench), bench.state().text()), (None, 0, before));
}

/// Each shape that is chosen begins with sizes that a fog may have.
#[test]
fn a_component_of_fog_takes_any_shape() {
    let (mut bench, _folder) = bench();
    bench.state_mut().select("Mover");
    bench.run_steps(3);
    click(&mut bench, "Add component");
    click(&mut bench, "Fog");
    let fog = |bench: &Bench| {
        let desk = bench.state();
        desk.world.ecs.get::<Fog>(desk.world.find("Mover").unwrap()).copied()
    };
    assert_eq!(fog(&bench), Some(Fog::default()));
    for shape in ["Box", "Sphere", "Everywhere"] {
        click(&mut bench, "Shape");
        click(&mut bench, shape);
        assert!(bench.state().editor.problem.is_none(), "{shape}: {:?}", bench.state().editor.problem);
        assert!(format!("{:?}", fog(&bench)).contains(shape), "{shape}: {:?}", fog(&bench));
    }
    click(&mut bench, "Remove Fog");
    assert_eq!(fog(&bench), None);
}

#[test]
fn the_lens_of_a_camera_is_edited_and_undone() {
    let (mut bench, _folder) = bench();
    bench.state_mut().select("Camera");
    bench.run_steps(3);
    let lens = |bench: &Bench| {
        let desk = bench.state();
        desk.world.ecs.get::<Camera>(desk.world.find("Camera").unwrap()).unwrap().lens.clone()
    };
    let before = bench.state().text();
    for part in ["Depth of field on", "Bloom on", "Grading on"] {
        click(&mut bench, part);
    }
    click(&mut bench, "Exposure");
    click(&mut bench, "Photographic");
    let found = lens(&bench);
    assert_eq!((found.depth_of_field, found.bloom), (Some(DepthOfField::default()), Some(Bloom::default())));
    assert!(found.exposure.ev100().is_some() && found.fault().is_none() && found.grading.is_some(), "{found:?}");
    assert!(bench.state().editor.problem.is_none(), "{:?}", bench.state().editor.problem);
    for _ in 0..4 {
        press(&mut bench, Modifiers::COMMAND, Key::Z);
    }
    assert_eq!((lens(&bench), bench.state().text()), (Lens::default(), before));
}

#[test]
fn faulty_values_change_nothing_and_say_why() {
    let (mut bench, _folder) = bench();
    bench.state_mut().select("Camera");
    bench.run_steps(3);
    let before = bench.state().text();
    let id = bench.state().id("Camera");
    let mut stage_edit = |fov: f32| {
        let desk = bench.state_mut();
        let camera = Camera { fov, ..desk.world.rest_camera(desk.world.find("Camera").unwrap()).unwrap() };
        let now = lightwell::files::OverrideFile { camera: Some(camera), ..Default::default() };
        desk.with_stage(|editor, stage| editor.edit_components(stage, "change camera", &[(id, now)]))
    };
    let error = stage_edit(400.0).unwrap_err().to_string();
    assert!(error.contains("fov"), "{error}");
    assert_eq!(bench.state().text(), before);
}

#[test]
fn edits_go_to_the_rest_pose_and_not_to_the_animated_value() {
    let (mut bench, _folder) = bench();
    bench.state_mut().clock.seek(2.0);
    bench.run_steps(2);
    let desk = bench.state();
    let mover = desk.world.find("Mover").unwrap();
    assert_eq!(desk.world.ecs.get::<Transform>(mover).unwrap().translation.x, 2.0);
    assert_eq!(desk.world.rest_transform(mover).translation.x, 0.0);
    let before = desk.text();
    // Play, pause, step and scrub leave the file alone.
    press(&mut bench, Modifiers::NONE, Key::Period);
    click(&mut bench, "Preview");
    bench.run_steps(4);
    click(&mut bench, "Pause preview");
    assert_eq!(bench.state().text(), before);
    assert!(!bench.state().editor.history.is_dirty());
    bench.state_mut().select("Mover");
    bench.run_steps(3);
    let at = place_of(&bench, "Translation y");
    drag(&mut bench, at, at + egui::vec2(40.0, 0.0));
    let desk = bench.state();
    let rest = desk.world.rest_transform(mover).translation;
    assert!(rest.y > 0.05 && rest.x == 0.0, "{rest}");
    let shown = desk.world.ecs.get::<Transform>(mover).unwrap().translation;
    assert!(shown.x > 1.9 && shown.y == 0.0, "the animation goes on: {shown}");
}

#[test]
fn a_handle_moves_what_is_selected() {
    let (mut bench, _folder) = bench();
    bench.state_mut().select("Group/Cube");
    bench.run_steps(3);
    let rect = bench.get_by_label("Picture").rect();
    let desk = bench.state();
    let camera = desk.scene.cameras[0].clone();
    let lens = super::super::gizmo::Lens::new(&camera, rect);
    let cube = desk.world.find("Group/Cube").unwrap();
    let place = |desk: &Desk| desk.world.ecs.get::<lightwell::world::GlobalTransform>(cube).unwrap().0.translation;
    let before = place(desk);
    let origin: glam::Vec3 = before.into();
    let grip = lens.point(origin + glam::Vec3::Y * 0.3).unwrap();
    let to = lens.point(origin + glam::Vec3::Y * 0.8).unwrap();
    drag(&mut bench, grip, to);
    let by = place(bench.state()) - before;
    assert!((by.y - 0.5).abs() < 0.05 && by.x.abs() < 1e-4 && by.z.abs() < 1e-4, "{by}");
    assert_eq!(bench.state().editor.history.undo_label(), Some("move"));
    press(&mut bench, Modifiers::COMMAND, Key::Z);
    assert_eq!(place(bench.state()), before, "to the bit");
}

#[test]
fn a_handle_moves_what_is_animated_with_its_track() {
    let (mut bench, _folder) = bench();
    bench.state_mut().clock.seek(2.0);
    bench.state_mut().select("Mover");
    bench.run_steps(3);
    assert!(bench.query_by_label_contains("animated: the transform is that without the animation").is_some());
    let before = bench.state().text();
    let rect = bench.get_by_label("Picture").rect();
    let desk = bench.state();
    let lens = super::super::gizmo::Lens::new(&desk.scene.cameras[0], rect);
    let mover = desk.world.find("Mover").unwrap();
    let place = |desk: &Desk| desk.world.ecs.get::<lightwell::world::GlobalTransform>(mover).unwrap().position();
    let was = place(desk);
    assert_eq!(was.x, 2.0);
    let point = |height: f32| lens.point(was + glam::Vec3::Y * height).unwrap();
    let (grip, to) = (point(0.3), point(0.8));
    drag(&mut bench, grip, to);
    let by = place(bench.state()) - was;
    assert!((by.y - 0.5).abs() < 0.05 && by.x.abs() < 1e-4, "what is shown follows the pointer: {by}");
    bench.state_mut().clock.seek(3.0);
    bench.run_steps(2);
    let later = place(bench.state());
    assert!((later.x - 3.0).abs() < 1e-4 && (later.y - was.y - by.y).abs() < 1e-4, "and its path with it: {later}");
    press(&mut bench, Modifiers::COMMAND, Key::Z);
    assert_eq!(bench.state().text(), before);
}

/// Where frames take long, the end of the way and the release come together.
#[test]
fn the_last_part_of_a_drag_counts() {
    let (mut bench, _folder) = bench();
    bench.state_mut().select("Group/Cube");
    bench.run_steps(3);
    let rect = bench.get_by_label("Picture").rect();
    let desk = bench.state();
    let lens = super::super::gizmo::Lens::new(&desk.scene.cameras[0], rect);
    let cube = desk.world.find("Group/Cube").unwrap();
    let place = |desk: &Desk| desk.world.ecs.get::<lightwell::world::GlobalTransform>(cube).unwrap().position();
    let before = place(desk);
    let point = |height: f32| lens.point(before + glam::Vec3::Y * height).unwrap();
    let (grip, between, to) = (point(0.3), point(0.4), point(0.8));
    bench.hover_at(grip);
    bench.run_steps(1);
    bench.drag_at(grip);
    bench.run_steps(1);
    bench.hover_at(between);
    bench.run_steps(1);
    bench.hover_at(to);
    bench.drop_at(to);
    bench.run_steps(3);
    let by = place(bench.state()) - before;
    assert!((by.y - 0.5).abs() < 0.05, "{by}");
    press(&mut bench, Modifiers::COMMAND, Key::Z);
    assert_eq!(place(bench.state()), before, "one step");
}

#[test]
fn a_click_in_the_picture_asks_what_is_there() {
    let (mut bench, _folder) = bench();
    let rect = bench.get_by_label("Picture").rect();
    let at = rect.min + rect.size() * 0.26;
    bench.hover_at(at);
    bench.run_steps(1);
    bench.drag_at(at);
    bench.run_steps(1);
    bench.drop_at(at);
    bench.run_steps(2);
    assert_eq!(bench.state().requests, [Request::Pick { pixel: [166, 104], add: false }]);
    let ball = bench.state().id("Group/Ball");
    let desk = bench.state_mut();
    desk.editor.picked(&desk.world, Some(ball), false, false);
    assert_eq!(desk.editor.selection, [ball]);
    desk.editor.picked(&desk.world, None, false, false);
    assert!(desk.editor.selection.is_empty());
}

#[test]
fn a_change_is_made_to_all_that_are_selected() {
    let (mut bench, _folder) = bench();
    let ids = ["Group/Ball", "Group/Cube"].map(|path| bench.state().id(path));
    bench.state_mut().editor.selection = ids.to_vec();
    bench.run_steps(3);
    click(&mut bench, "Add component");
    click(&mut bench, "Casts shadow");
    click(&mut bench, "Casts shadow");
    let desk = bench.state();
    for path in ["Group/Ball", "Group/Cube"] {
        let entity = desk.world.find(path).unwrap();
        let renderer = desk.world.ecs.get::<lightwell::world::MeshRenderer>(entity).unwrap();
        assert!(!renderer.casts_shadow, "{path}");
    }
}

#[test]
fn what_is_saved_is_loaded_again() {
    let (mut bench, folder) = bench();
    bench.state_mut().select("Lamp");
    bench.run_steps(3);
    click(&mut bench, "Kind");
    click(&mut bench, "Directional");
    press(&mut bench, Modifiers::COMMAND, Key::S);
    assert_eq!(bench.state().requests, [Request::Save]);
    let path = folder.path().join("test.scene.ron");
    save_scene(&bench.state().world, &path).unwrap();
    bench.state_mut().editor.history.mark_saved();
    assert!(!bench.state().editor.history.is_dirty());
    let again = Desk::new(&path);
    assert_eq!(again.text(), bench.state().text());
    assert_eq!(light(&again).kind, LightKind::Directional);
    assert_eq!(std::fs::read_to_string(path.with_extension("ron.bak")).unwrap(), SCENE, "the file before is kept");
}

#[test]
fn unsaved_edits_are_asked_for() {
    let (mut bench, _folder) = bench();
    bench.state_mut().editor.ask(Request::Quit);
    bench.run_steps(2);
    assert_eq!(bench.state().requests, [Request::Quit], "nothing is unsaved");
    bench.state_mut().requests.clear();
    bench.state_mut().select("Lamp");
    press(&mut bench, Modifiers::NONE, Key::Delete);
    bench.state_mut().editor.ask(Request::Quit);
    bench.run_steps(2);
    assert!(bench.state().requests.is_empty());
    click(&mut bench, "Cancel");
    assert!(bench.state().requests.is_empty());
    bench.state_mut().editor.ask(Request::Quit);
    bench.run_steps(2);
    click(&mut bench, "Save and go on");
    assert_eq!(bench.state().requests, [Request::Save, Request::Quit]);
}

#[test]
fn a_changed_file_loses_no_edits() {
    let (mut bench, _folder) = bench();
    assert_eq!(bench.state_mut().editor.file_changed(None), Some(Request::Reload), "nothing would be lost");
    bench.state_mut().select("Lamp");
    press(&mut bench, Modifiers::NONE, Key::Delete);
    assert_eq!(bench.state_mut().editor.file_changed(None), None);
    bench.run_steps(2);
    click(&mut bench, "Keep mine");
    assert!(bench.state().requests.is_empty() && bench.state().editor.history.is_dirty());
    bench.state_mut().editor.file_changed(None);
    bench.run_steps(2);
    click(&mut bench, "Load the file");
    assert_eq!(bench.state().requests, [Request::Reload]);
}
