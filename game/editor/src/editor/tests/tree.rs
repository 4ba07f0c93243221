//! The tree of entities.

use super::*;
use egui::{Key, Modifiers};
use lightwell::world::GlobalTransform;

#[test]
fn entities_are_added_deleted_and_brought_back() {
    let (mut bench, _folder) = bench();
    let before = bench.state().text();
    click(&mut bench, "Add");
    click(&mut bench, "Torus");
    let torus = bench.state().world.find("Torus").expect("it was added");
    assert_eq!(bench.state().editor.selection, [bench.state().world.id(torus).unwrap()]);
    let with = bench.state().text();
    press(&mut bench, Modifiers::NONE, Key::Delete);
    assert_eq!(bench.state().text(), before);
    press(&mut bench, Modifiers::COMMAND, Key::Z);
    assert_eq!(bench.state().text(), with);
    press(&mut bench, Modifiers::COMMAND, Key::Z);
    assert_eq!(bench.state().text(), before);
    press(&mut bench, Modifiers::COMMAND, Key::Y);
    assert_eq!(bench.state().text(), with);
}

#[test]
fn a_group_is_deleted_and_comes_back_in_its_place() {
    let (mut bench, _folder) = bench();
    let before = bench.state().text();
    let ids = ["Group", "Group/Ball", "Group/Cube"].map(|path| bench.state().id(path));
    click(&mut bench, "Group");
    press(&mut bench, Modifiers::NONE, Key::Delete);
    assert!(bench.state().world.find("Group").is_none());
    assert_eq!(bench.state().scene.primitives.len(), 1);
    press(&mut bench, Modifiers::COMMAND, Key::Z);
    assert_eq!(bench.state().text(), before);
    assert_eq!(["Group", "Group/Ball", "Group/Cube"].map(|path| bench.state().id(path)), ids);
    assert_eq!(bench.state().scene.primitives.len(), 3);
}

#[test]
fn a_copy_stands_beside_the_original() {
    let (mut bench, _folder) = bench();
    click(&mut bench, "Group");
    press(&mut bench, Modifiers::COMMAND, Key::D);
    let desk = bench.state();
    assert!(desk.world.find("Group 2/Ball").is_some());
    assert_eq!(desk.editor.selection, [desk.id("Group 2")]);
    assert!(desk.text().contains("\"Group 2\""));
    press(&mut bench, Modifiers::COMMAND, Key::Z);
    assert!(bench.state().world.find("Group 2").is_none());
}

#[test]
fn the_search_finds_what_is_folded_away() {
    let (mut bench, _folder) = bench();
    assert!(bench.query_by_label("Cube").is_none());
    bench.get_by_label("Search").focus();
    bench.run_steps(2);
    bench.get_by_label("Search").type_text("cu");
    bench.run_steps(3);
    assert!(bench.query_by_label("Lamp").is_none());
    click(&mut bench, "Cube");
    assert_eq!(bench.state().editor.selection, [bench.state().id("Group/Cube")]);
}

#[test]
fn a_dragged_row_gets_another_parent_and_stays_where_it_is() {
    let (mut bench, _folder) = bench();
    let before = bench.state().text();
    let place =
        |desk: &Desk, path: &str| desk.world.ecs.get::<GlobalTransform>(desk.world.find(path).unwrap()).unwrap().0;
    click(&mut bench, "Open Group");
    let was = place(bench.state(), "Group/Ball");
    let [from, to] = ["Ball", "Lamp"].map(|label| place_of(&bench, label));
    drag(&mut bench, from, to);
    let now = place(bench.state(), "Lamp/Ball");
    assert!(now.abs_diff_eq(was, 1e-5));
    press(&mut bench, Modifiers::COMMAND, Key::Z);
    assert_eq!(bench.state().text(), before);
}

#[test]
fn no_entity_becomes_its_own_grandchild() {
    let (mut bench, _folder) = bench();
    let before = bench.state().text();
    let [group, ball] = ["Group", "Group/Ball"].map(|path| bench.state().id(path));
    let result = bench.state_mut().with_stage(|editor, stage| editor.reparent(stage, &[group], Some(ball)));
    assert!(result.is_err());
    assert_eq!(bench.state().text(), before);
    assert!(!bench.state().editor.history.is_dirty());
}

#[test]
fn prefabs_are_made_instanced_and_broken() {
    let (mut bench, folder) = bench();
    let prefabs = folder.path().join("../prefabs");
    let file = folder.path().join("group.prefab.ron");
    assert!(!prefabs.join("group.prefab.ron").exists());
    bench.state_mut().select("Group");
    bench.state_mut().with_stage(|editor, stage| editor.make_prefab(stage, &file)).unwrap();
    bench.run_steps(2);
    let desk = bench.state();
    assert!(desk.text().contains("prefab: \"group.prefab.ron\""), "{}", desk.text());
    assert!(desk.world.find("Group/Ball").is_some());
    bench.state_mut().with_stage(|editor, stage| editor.add_file(stage, &file)).unwrap();
    assert!(bench.state().world.find("group/Cube").is_some());
    bench.state_mut().with_stage(|editor, stage| editor.break_prefab(stage)).unwrap();
    let text = bench.state().text();
    assert_eq!(text.matches("prefab: ").count(), 1, "{text}");
    let path = folder.path().join("broken.scene.ron");
    save_scene(&bench.state().world, &path).unwrap();
    assert_eq!(Desk::new(&path).text(), text);
}

/// A file that the system hands over.
#[derive(Debug)]
struct Dropped(PathBuf);

impl egui::DroppedFile for Dropped {
    fn path(&self) -> &Path {
        &self.0
    }

    fn bytes(&self) -> Result<Vec<u8>, String> {
        std::fs::read(&self.0).map_err(|error| error.to_string())
    }
}

pub(super) fn drop_file(bench: &mut Bench, path: &Path) {
    bench.input_mut().dropped_files.push(std::sync::Arc::new(Dropped(path.to_owned())));
    bench.run_steps(3);
}

#[test]
fn files_dropped_on_the_window_are_added_played_or_refused() {
    let (mut bench, folder) = bench();
    let before = bench.state().text();
    let prefab = folder.path().join("cup.prefab.ron");
    std::fs::write(&prefab, "Prefab(entities: [(name: \"Cup\", mesh: Cylinder())])").unwrap();
    drop_file(&mut bench, &prefab);
    assert!(bench.state().world.find("cup/Cup").is_some());
    assert_eq!(bench.state().editor.selection, [bench.state().id("cup")]);
    press(&mut bench, Modifiers::COMMAND, Key::Z);
    assert_eq!(bench.state().text(), before);
    drop_file(&mut bench, &folder.path().join("notes.txt"));
    assert_eq!(bench.state().text(), before);
    assert!(bench.query_by_label_contains("`notes.txt` is no .glb").is_some());
    let scene = folder.path().join("other.scene.ron");
    drop_file(&mut bench, &scene);
    assert_eq!(bench.state().requests, [Request::Open(scene)]);
}

#[test]
fn dropped_files_are_added_or_refused() {
    let (mut bench, folder) = bench();
    let prefab = folder.path().join("cup.prefab.ron");
    std::fs::write(&prefab, "Prefab(entities: [(name: \"Cup\", mesh: Cylinder())])").unwrap();
    bench.state_mut().with_stage(|editor, stage| editor.add_file(stage, &prefab)).unwrap();
    assert!(bench.state().world.find("cup/Cup").is_some());
    let text = folder.path().join("notes.txt");
    let error = bench.state_mut().with_stage(|editor, stage| editor.add_file(stage, &text)).unwrap_err();
    assert!(error.to_string().contains(".glb"), "{error}");
}
