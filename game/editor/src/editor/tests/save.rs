//! A save writes what was edited, and nothing else.

use super::*;
use egui::{Key, Modifiers};
use lightwell::files::{describe_entity, save_scene_as};
use lightwell_runtime::set;

/// Saves, and gives the lines of the file that are others now.
fn saved_lines(bench: &Bench, before: &str) -> Vec<(String, String)> {
    let desk = bench.state();
    save_scene(&desk.world, &desk.path).unwrap();
    let after = std::fs::read_to_string(&desk.path).unwrap();
    assert_eq!(before.lines().count(), after.lines().count(), "{after}");
    let pairs = before.lines().zip(after.lines()).filter(|(before, after)| before != after);
    pairs.map(|(before, after)| (before.to_owned(), after.to_owned())).collect()
}

/// Sets the intensity of the lamp as the inspector does.
fn set_intensity(bench: &mut Bench, intensity: f32) {
    let id = bench.state().id("Lamp");
    bench.state_mut().with_stage(|editor, stage| {
        let entity = stage.world.entity(id).unwrap();
        let mut now = describe_entity(stage.world, entity, stage.files.path).unwrap();
        now.light.as_mut().unwrap().intensity = intensity;
        editor.edit_components(stage, "change light", &[(id, now)]).unwrap();
        editor.history.close(stage.world).unwrap();
    });
    bench.run_steps(2);
}

const COMMENTED: &str = "// The lamp hangs here.\n        (name: \"Lamp\",";

fn commented() -> (Bench, tempfile::TempDir, String) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("test.scene.ron");
    let text = SCENE.replace("(name: \"Lamp\",", COMMENTED);
    std::fs::write(&path, &text).unwrap();
    (bench_of(&path), folder, text)
}

#[test]
fn an_edit_changes_its_line_alone() {
    let (mut bench, _folder, before) = commented();
    assert_eq!(saved_lines(&bench, &before), []);
    set_intensity(&mut bench, 35.0);
    press(&mut bench, Modifiers::COMMAND, Key::Z);
    assert_eq!(saved_lines(&bench, &before), [], "it was undone");
    set_intensity(&mut bench, 42.0);
    let lines = saved_lines(&bench, &before);
    let [(old, new)] = &lines[..] else { panic!("{lines:?}") };
    assert_eq!(*new, old.replace("intensity: 20", "intensity: 42"));
    assert_eq!(saved_lines(&bench, &before), lines, "saved once more");
    press(&mut bench, Modifiers::COMMAND, Key::Z);
    assert_eq!(saved_lines(&bench, &before), [], "undone and saved again");
}

#[test]
fn a_dragged_row_takes_its_comment_along() {
    let (mut bench, _folder, _) = commented();
    let [lamp, group] = ["Lamp", "Group"].map(|path| bench.state().id(path));
    bench.state_mut().with_stage(|editor, stage| editor.reparent(stage, &[lamp], Some(group))).unwrap();
    save_scene(&bench.state().world, &bench.state().path).unwrap();
    let after = std::fs::read_to_string(&bench.state().path).unwrap();
    assert!(
        after.contains("                // The lamp hangs here.\n                (\n")
            || after.contains("                // The lamp hangs here.\n                (name: \"Lamp\""),
        "{after}"
    );
    press(&mut bench, Modifiers::COMMAND, Key::Z);
    save_scene(&bench.state().world, &bench.state().path).unwrap();
    let back = std::fs::read_to_string(&bench.state().path).unwrap();
    assert!(back.contains("        // The lamp hangs here.\n        ("), "{back}");
    assert_eq!(Desk::new(&bench.state().path).text(), bench.state().text());
}

#[test]
fn what_the_command_line_set_is_marked_and_not_saved() {
    let (mut bench, _folder, before) = commented();
    let sets = [("Lamp.light.intensity", "5"), ("scene.exposure", "3"), ("Group.transform.rotation", "(0, 10, 0)")];
    let sets = sets.map(|(target, value)| (target.to_owned(), value.to_owned()));
    let desk = bench.state_mut();
    let add = |world: &mut GameWorld| {
        world.spawn("For this run", None);
    };
    set::override_values(&mut desk.world, &desk.path, &sets, add).unwrap();
    bench.state_mut().select("Lamp");
    bench.run_steps(3);
    let mark = "Intensity: set by the command line: --set Lamp.light.intensity=5; not saved";
    assert!(bench.query_by_label(mark).is_some());
    assert_eq!(saved_lines(&bench, &before), []);
    // The user's word counts.
    set_intensity(&mut bench, 6.0);
    assert!(bench.query_by_label(mark).is_none());
    let lines = saved_lines(&bench, &before);
    assert!(lines.len() == 1 && lines[0].1.contains("intensity: 6)"), "{lines:?}");
    press(&mut bench, Modifiers::COMMAND, Key::Z);
    assert!(bench.query_by_label(mark).is_some());
    assert_eq!(saved_lines(&bench, &before), []);
}

#[test]
fn undo_after_save_as_finds_the_files_of_the_new_folder() {
    let (mut bench, folder) = bench();
    let prefab = folder.path().join("cup.prefab.ron");
    std::fs::write(&prefab, "Prefab(entities: [(name: \"Cup\", mesh: Cylinder())])").unwrap();
    bench.state_mut().with_stage(|editor, stage| editor.add_file(stage, &prefab)).unwrap();
    bench.state_mut().select("cup");
    press(&mut bench, Modifiers::NONE, Key::Delete);
    let inner = folder.path().join("inner");
    std::fs::create_dir(&inner).unwrap();
    let new = inner.join("new.scene.ron");
    let desk = bench.state_mut();
    let before = desk.path.clone();
    desk.options.trusted.push(folder.path().to_owned());
    save_scene_as(&mut desk.world, &desk.library, &desk.options, &before, &new).unwrap();
    desk.path.clone_from(&new);
    desk.with_stage(|editor, stage| editor.saved_as(&stage.files, &before)).unwrap();
    press(&mut bench, Modifiers::COMMAND, Key::Z);
    save_scene(&bench.state().world, &new).unwrap();
    let text = std::fs::read_to_string(&new).unwrap();
    assert!(text.contains("prefab: \"../cup.prefab.ron\""), "{text}");
}
