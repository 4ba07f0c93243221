//! Questions, and what is remembered: saving under another name, opening, prefabs, export, places of the camera.

use super::*;
use egui::{Key, Modifiers};

/// Writes a path where a question asks for one.
pub(super) fn enter_path(bench: &mut Bench, path: &Path) {
    find(bench, "Path").focus();
    bench.run_steps(2);
    press(bench, Modifiers::COMMAND, Key::A);
    bench.event(egui::Event::Text(path.display().to_string()));
    bench.run_steps(3);
}

#[test]
fn another_name_is_asked_for_and_must_be_one() {
    let (mut bench, folder) = bench();
    press(&mut bench, Modifiers::COMMAND | Modifiers::SHIFT, Key::S);
    enter_path(&mut bench, &folder.path().join("new.txt"));
    assert!(find(&bench, "Save").accesskit_node().is_disabled(), "no name of a scene");
    let new = folder.path().join("new.scene.ron");
    enter_path(&mut bench, &new);
    press(&mut bench, Modifiers::NONE, Key::Enter);
    assert_eq!(bench.state().requests, [Request::SaveAs(new)]);
    assert!(bench.query_by_label("Path").is_none(), "answered");
}

#[test]
fn another_scene_is_opened_from_the_list() {
    let (mut bench, folder) = bench();
    std::fs::write(folder.path().join("other.scene.ron"), SCENE).unwrap();
    press(&mut bench, Modifiers::COMMAND, Key::O);
    click(&mut bench, "other.scene.ron");
    click(&mut bench, "Open");
    assert_eq!(bench.state().requests, [Request::Open(folder.path().join("other.scene.ron"))]);
}

#[test]
fn a_prefab_is_made_changed_by_its_instance_and_written_back() {
    let (mut bench, folder) = bench();
    let file = folder.path().join("group.prefab.ron");
    bench.state_mut().select("Group");
    bench.run_steps(2);
    click(&mut bench, "Edit");
    click(&mut bench, "Make a prefab…");
    enter_path(&mut bench, &file);
    press(&mut bench, Modifiers::NONE, Key::Enter);
    let made = std::fs::read_to_string(&file).unwrap();
    assert!(made.contains("Sphere"), "{made}");
    bench.state_mut().select("Group/Ball");
    bench.run_steps(3);
    let at = place_of(&bench, "Radius");
    drag(&mut bench, at, at + egui::vec2(60.0, 0.0));
    assert!(bench.state().text().contains("overrides"), "a change of the instance: {}", bench.state().text());
    bench.state_mut().select("Group");
    bench.run_steps(2);
    click(&mut bench, "Edit");
    click(&mut bench, "Apply to the prefab");
    let applied = std::fs::read_to_string(&file).unwrap();
    assert!(applied != made && applied.contains("radius"), "{applied}");
}

#[test]
fn the_animation_is_exported() {
    let (mut bench, _folder) = bench();
    click(&mut bench, "File");
    click(&mut bench, "Export the animation…");
    click(&mut bench, "Export");
    let asked = bench.state().requests.first().cloned();
    let Some(Request::Export(export)) = asked else { panic!("{asked:?}") };
    assert_eq!(
        (export.frames, export.rate, export.size),
        (120, 30, [640, 400]),
        "four seconds, as large as the picture"
    );
    assert!(!export.video);
}

#[test]
fn places_of_the_camera_are_kept_and_gone_back_to() {
    let (mut bench, _folder) = bench();
    press(&mut bench, Modifiers::COMMAND, Key::Num5);
    let kept = bench.state().camera.place();
    bench.state_mut().select("Group/Ball");
    press(&mut bench, Modifiers::NONE, Key::F);
    let focused = bench.state().camera.place();
    assert!(bench.state().camera.is_free() && focused != kept, "focus goes to the selection");
    press(&mut bench, Modifiers::NONE, Key::Num5);
    let eye = |bench: &Bench| {
        let desk = bench.state();
        desk.camera.apply(&desk.scene.cameras[0]).world_from_view.translation
    };
    let back = eye(&bench);
    assert!((back - desk_camera(&bench)).length() < 1e-4, "{back}");
    press(&mut bench, Modifiers::NONE, Key::C);
    assert!(!bench.state().camera.is_free(), "the scene's own camera");
    assert!(!bench.state().editor.history.is_dirty());
}

fn desk_camera(bench: &Bench) -> glam::Vec3A {
    bench.state().scene.cameras[0].world_from_view.translation
}
