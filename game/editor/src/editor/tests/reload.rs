//! Files that are read anew: the history goes on, and what was edited can be brought back.

use super::*;
use egui::{Key, Modifiers};
use lightwell::files::reenter_scene;
use lightwell::world::Light;

/// What the window does when the scene's file is to be read anew.
fn reload(bench: &mut Bench) {
    let desk = bench.state_mut();
    let before = desk.editor.before_reload(&mut desk.world).unwrap();
    desk.library = AssetLibrary::new();
    reenter_scene(&mut desk.world, &mut desk.library, &desk.options, &desk.path).unwrap();
    desk.editor.reloaded(&mut desk.world, before).unwrap();
    bench.run_steps(2);
}

fn file(bench: &Bench) -> String {
    std::fs::read_to_string(&bench.state().path).unwrap()
}

fn write(bench: &Bench, from: &str, to: &str) {
    let text = file(bench);
    assert!(text.contains(from), "{from} is in {text}");
    std::fs::write(&bench.state().path, text.replace(from, to)).unwrap();
}

fn undo(bench: &mut Bench) {
    press(bench, Modifiers::COMMAND, Key::Z);
}

fn intensity(bench: &Bench) -> f32 {
    let desk = bench.state();
    desk.world.ecs.get::<Light>(desk.world.find("Lamp").unwrap()).unwrap().intensity
}

#[test]
fn the_history_survives_a_reload() {
    let (mut bench, _folder) = bench();
    let [lamp, ball] = ["Lamp", "Group/Ball"].map(|path| bench.state().id(path));
    let original = bench.state().text();
    bench.state_mut().select("Lamp");
    bench.run_steps(3);
    let at = place_of(&bench, "Intensity");
    drag(&mut bench, at, at + egui::vec2(60.0, 0.0));
    let edited = intensity(&bench);
    bench.state_mut().select("Group/Cube");
    press(&mut bench, Modifiers::NONE, Key::Delete);
    save_scene(&bench.state().world, &bench.state().path).unwrap();
    bench.state_mut().editor.history.mark_saved();
    let saved = bench.state().text();
    bench.state_mut().select("Group/Ball");

    // Another program changes the ball's material and puts an entity before all others.
    write(&bench, "color: (0.6, 0.05, 0.05)", "color: (0.1, 0.05, 0.05)");
    write(&bench, "entities: [", "entities: [(name: \"First\", mesh: Cone()),");
    reload(&mut bench);
    let desk = bench.state();
    assert!(!desk.editor.history.is_dirty());
    assert_eq!((desk.id("Lamp"), desk.id("Group/Ball")), (lamp, ball), "identities stay");
    assert_eq!(desk.editor.selection, [ball], "and with them the selection");
    let loaded = desk.text();
    assert!(loaded.contains("color: (0.1, 0.05, 0.05)"), "{loaded}");
    assert_eq!(loaded, Desk::new(&desk.path).text(), "in the order of the file");

    undo(&mut bench);
    assert!(bench.state().editor.history.is_dirty());
    assert_eq!(bench.state().text(), saved, "the reload is a step");
    undo(&mut bench);
    assert!(bench.state().world.find("Group/Cube").is_some());
    undo(&mut bench);
    assert_eq!((intensity(&bench), bench.state().text()), (20.0, original));
    for _ in 0..3 {
        press(&mut bench, Modifiers::COMMAND, Key::Y);
    }
    assert_eq!((intensity(&bench), bench.state().text()), (edited, loaded));
    assert!(!bench.state().editor.history.is_dirty(), "as the file says it");

    // Edits go on in what was loaded.
    bench.state_mut().select("Lamp");
    press(&mut bench, Modifiers::NONE, Key::Delete);
    undo(&mut bench);
    assert_eq!(bench.state().id("Lamp"), lamp);
}

#[test]
fn edits_that_a_reload_took_away_come_back() {
    let (mut bench, _folder) = bench();
    bench.state_mut().select("Group/Cube");
    press(&mut bench, Modifiers::NONE, Key::Delete);
    bench.state_mut().select("Lamp");
    bench.run_steps(3);
    click(&mut bench, "Kind");
    click(&mut bench, "Spot");
    let mine = bench.state().text();
    write(&bench, "color: (0.6, 0.05, 0.05)", "color: (0, 0, 1)");
    reload(&mut bench);
    assert!(bench.state().world.find("Group/Cube").is_some());
    let material = |bench: &Bench| {
        let desk = bench.state();
        let ball = desk.world.find("Group/Ball").unwrap();
        desk.world.ecs.get::<lightwell::world::MeshRenderer>(ball).unwrap().material.base_color.truncate()
    };
    assert_eq!(material(&bench), glam::Vec3::Z);
    undo(&mut bench);
    assert_eq!(bench.state().text(), mine);
    assert_eq!(material(&bench).x, 0.6);
    press(&mut bench, Modifiers::COMMAND, Key::Y);
    assert_eq!(material(&bench), glam::Vec3::Z);
}

#[test]
fn a_file_that_cannot_be_read_changes_nothing() {
    let (mut bench, _folder) = bench();
    bench.state_mut().select("Group/Cube");
    press(&mut bench, Modifiers::NONE, Key::Delete);
    let mine = bench.state().text();
    write(&bench, "intensity: 20", "intensity: bright");
    let desk = bench.state_mut();
    let before = desk.editor.before_reload(&mut desk.world).unwrap();
    assert!(reenter_scene(&mut desk.world, &mut desk.library, &desk.options, &desk.path).is_err());
    desk.editor.not_reloaded(&mut desk.world, before);
    assert_eq!(bench.state().text(), mine);
    undo(&mut bench);
    assert!(bench.state().world.find("Group/Cube").is_some());
}

/// A step of many changes, one of which cannot be taken back: the image that it needs is gone.
#[test]
fn a_step_that_fails_changes_nothing_and_stays() {
    let (mut bench, folder) = bench();
    let sky = folder.path().join("sky.exr");
    let image = lightwell::measure::Image::filled(2, 1, [1.0; 3]);
    lightwell::measure::write_image(&sky, &image).unwrap();
    let plain = file(&bench);
    write(&bench, "duration: 4", "duration: 4, environment: Image(file: \"sky.exr\")");
    reload(&mut bench);
    std::fs::write(&bench.state().path, plain).unwrap();
    write(&bench, "entities: [", "entities: [(name: \"First\", mesh: Cone()),");
    reload(&mut bench);
    let (now, first) = (bench.state().text(), bench.state().id("First"));
    std::fs::remove_file(&sky).unwrap();

    undo(&mut bench);
    let desk = bench.state();
    let (said, is_error, _) = desk.editor.notice.clone().unwrap();
    assert!(is_error && said.contains("sky.exr") && said.contains("changes nothing"), "{said}");
    assert_eq!((desk.text(), desk.id("First")), (now.clone(), first));
    assert_eq!(desk.editor.history.undo_label(), Some("load the file"), "the step is still there");
    assert_eq!(desk.editor.history.redo_label(), None);

    lightwell::measure::write_image(&sky, &image).unwrap();
    undo(&mut bench);
    assert!(bench.state().world.find("First").is_none() && bench.state().text().contains("sky.exr"));
    undo(&mut bench);
    let loaded = bench.state().text();
    std::fs::remove_file(&sky).unwrap();
    press(&mut bench, Modifiers::COMMAND, Key::Y);
    assert_eq!(bench.state().text(), loaded, "the same where it is done again");
    assert_eq!(bench.state().editor.history.redo_label(), Some("load the file"));
    lightwell::measure::write_image(&sky, &image).unwrap();
    press(&mut bench, Modifiers::COMMAND, Key::Y);
    press(&mut bench, Modifiers::COMMAND, Key::Y);
    assert_eq!(bench.state().text(), now);
}

/// For each panel that changes the scene: edit, undo, do again, save, load: the same file.
#[test]
fn edits_of_every_panel_are_undone_saved_and_loaded() {
    type Edit = fn(&mut Bench);
    let tree: Edit = |bench| {
        bench.state_mut().select("Group/Cube");
        press(bench, Modifiers::COMMAND, Key::D);
    };
    let inspector: Edit = |bench| {
        bench.state_mut().select("Camera");
        bench.run_steps(3);
        let at = place_of(bench, "Fov");
        drag(bench, at, at + egui::vec2(30.0, 0.0));
    };
    let view: Edit = |bench| {
        bench.state_mut().select("Group/Cube");
        bench.run_steps(3);
        let rect = bench.get_by_label("Picture").rect();
        let desk = bench.state();
        let lens = crate::editor::gizmo::Lens::new(&desk.scene.cameras[0], rect);
        let cube = desk.world.find("Group/Cube").unwrap();
        let place = desk.world.ecs.get::<lightwell::world::GlobalTransform>(cube).unwrap();
        let origin: glam::Vec3 = place.0.translation.into();
        let point = |height: f32| lens.point(origin + glam::Vec3::Y * height).unwrap();
        drag(bench, point(0.3), point(0.7));
    };
    let scene: Edit = |bench| {
        open(bench, Pane::Scene);
        let at = place_of(bench, "Exposure");
        drag(bench, at, at + egui::vec2(50.0, 0.0));
    };
    for (panel, edit) in [("tree", tree), ("inspector", inspector), ("view", view), ("scene", scene)] {
        let (mut bench, _folder) = bench();
        let before = bench.state().text();
        edit(&mut bench);
        let after = bench.state().text();
        assert_ne!(after, before, "{panel}");
        undo(&mut bench);
        assert_eq!(bench.state().text(), before, "{panel}: undone");
        press(&mut bench, Modifiers::COMMAND, Key::Y);
        assert_eq!(bench.state().text(), after, "{panel}: done again");
        press(&mut bench, Modifiers::COMMAND, Key::S);
        assert!(bench.state().requests.contains(&Request::Save), "{panel}");
        save_scene(&bench.state().world, &bench.state().path).unwrap();
        let desk = bench.state();
        assert_eq!(desk.text(), file(&bench), "{panel}: as it was saved");
        reload(&mut bench);
        assert_eq!(bench.state().text(), after, "{panel}: loaded again");
    }
}

#[test]
fn what_does_not_count_is_greyed_out() {
    let (mut bench, _folder) = bench();
    bench.state_mut().select("Camera");
    bench.run_steps(3);
    click(&mut bench, "Add component");
    click(&mut bench, "Clpv");
    let disabled = |bench: &Bench, name: &str| find(bench, name).accesskit_node().is_disabled();
    assert!(!disabled(&bench, "Quality") && disabled(&bench, "Steps"), "by default it sweeps");
    click(&mut bench, "Transport");
    click(&mut bench, "Diffusion");
    assert!(disabled(&bench, "Quality") && !disabled(&bench, "Steps"));
    undo(&mut bench);
    assert!(!disabled(&bench, "Quality"));
}
