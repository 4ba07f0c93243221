//! glTF files that are opened directly, without a scene's file.

use super::*;
use egui::{Key, Modifiers};
use lightwell::files::reenter_scene;
use lightwell::world::{GlobalTransform, MeshRenderer};

/// A triangle on a node that stands at (1, 2, 3), with its buffer in a file beside it.
pub(super) fn write_model(folder: &Path) -> PathBuf {
    let corners: [f32; 9] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let bytes: Vec<u8> = corners.iter().flat_map(|value| value.to_le_bytes()).collect();
    std::fs::write(folder.join("tri.bin"), bytes).unwrap();
    let text = r#"{"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],
        "nodes":[{"name":"Leaf","mesh":0,"translation":[1,2,3]}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0},"material":0}]}],
        "materials":[{"name":"paint","pbrMetallicRoughness":{"baseColorFactor":[0.8,0.1,0.1,1]}}],
        "buffers":[{"byteLength":36,"uri":"tri.bin"}],"bufferViews":[{"buffer":0,"byteLength":36}],
        "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}]}"#;
    let path = folder.join("tri.gltf");
    std::fs::write(&path, text).unwrap();
    path
}

/// What is seen: places and colours of all that is drawn, lights and cameras.
fn seen(desk: &Desk) -> String {
    let scene = &desk.scene;
    let parts: Vec<_> = scene
        .primitives
        .iter()
        .map(|p| (desk.world.ecs.get::<MeshRenderer>(desk.world.entity(p.id).unwrap()).unwrap(), p.bounds))
        .map(|(renderer, bounds)| format!("{:?} {bounds:?}", renderer.material.base_color))
        .collect();
    let lights: Vec<_> = scene
        .lights
        .iter()
        .map(|light| format!("{} {:?} {:?} {:?}", light.name, light.shape, light.intensity, light.position))
        .collect();
    let cameras: Vec<_> = scene.cameras.iter().map(|c| format!("{:?} {:?}", c.projection, c.world_from_view)).collect();
    format!("{parts:?} {lights:?} {cameras:?} {:?} {:?}", scene.sky, scene.clpv)
}

fn height(desk: &Desk, path: &str) -> f32 {
    desk.world.ecs.get::<GlobalTransform>(desk.world.find(path).unwrap()).unwrap().position().y
}

#[test]
fn a_model_is_edited_undone_and_saved_as_a_scene() {
    let folder = tempfile::tempdir().unwrap();
    let mut bench = bench_of(&write_model(folder.path()));
    // As its own folder would hold it.
    let written = |bench: &Bench| {
        let path = folder.path().join("written.scene.ron");
        // Anew, and not into what was written before.
        let _ = std::fs::remove_file(&path);
        save_scene(&bench.state().world, &path).unwrap();
        std::fs::read_to_string(path).unwrap()
    };
    let (original, looks) = (written(&bench), seen(bench.state()));
    assert!(!bench.state().editor.history.is_dirty());

    // The model as a whole moves, and what is a part of it stays as its file has it.
    bench.state_mut().select("tri");
    bench.run_steps(3);
    let at = place_of(&bench, "Translation y");
    drag(&mut bench, at, at + egui::vec2(40.0, 0.0));
    let moved = height(bench.state(), "tri/Leaf");
    assert!(moved > 2.05, "{moved}");
    bench.state_mut().select("tri/Leaf");
    press(&mut bench, Modifiers::NONE, Key::Delete);
    assert!(bench.query_by_label_contains("is part of a model").is_some());
    // What was added to it is edited like all else, and new things come.
    bench.state_mut().select("default light");
    bench.run_steps(3);
    click(&mut bench, "Kind");
    click(&mut bench, "Point");
    click(&mut bench, "Add");
    click(&mut bench, "Sphere");
    let edited = written(&bench);
    assert!(edited != original && bench.state().world.find("Sphere").is_some());
    for _ in 0..3 {
        press(&mut bench, Modifiers::COMMAND, Key::Z);
    }
    assert_eq!((written(&bench), seen(bench.state())), (original, looks), "all was undone");
    assert!(!bench.state().editor.history.is_dirty());
    for _ in 0..3 {
        press(&mut bench, Modifiers::COMMAND, Key::Y);
    }
    assert_eq!(written(&bench), edited);

    // Saved beside it, it names the model as its neighbour, so that both can be moved.
    let path = folder.path().join("tri_edited.scene.ron");
    save_scene(&bench.state().world, &path).unwrap();
    let text = std::fs::read_to_string(&path).unwrap();
    assert!(text.contains("path: \"tri.gltf\""), "{text}");
    let again = Desk::new(&path);
    assert_eq!(seen(&again), seen(bench.state()), "it looks the same");
    let moved = tempfile::tempdir().unwrap();
    for file in ["tri.gltf", "tri.bin", "tri_edited.scene.ron"] {
        std::fs::copy(folder.path().join(file), moved.path().join(file)).unwrap();
    }
    assert_eq!(seen(&Desk::new(&moved.path().join("tri_edited.scene.ron"))), seen(&again));
}

#[test]
fn the_history_of_a_model_survives_that_its_file_is_read_anew() {
    let folder = tempfile::tempdir().unwrap();
    let path = write_model(folder.path());
    let mut bench = bench_of(&path);
    let original = bench.state().text();
    bench.state_mut().select("default light");
    bench.run_steps(3);
    click(&mut bench, "Kind");
    click(&mut bench, "Point");
    let edited = bench.state().text();
    let light = bench.state().id("default light");

    let text = std::fs::read_to_string(&path).unwrap();
    std::fs::write(&path, text.replace("[1,2,3]", "[1,5,3]")).unwrap();
    let desk = bench.state_mut();
    let before = desk.editor.before_reload(&mut desk.world).unwrap();
    desk.library = AssetLibrary::new();
    reenter_scene(&mut desk.world, &mut desk.library, &desk.options, &desk.path).unwrap();
    desk.editor.reloaded(&mut desk.world, before).unwrap();
    bench.run_steps(2);
    assert_eq!((height(bench.state(), "tri/Leaf"), bench.state().id("default light")), (5.0, light));
    assert_eq!(bench.state().world.roots().len(), Desk::new(&path).world.roots().len(), "nothing is there twice");
    press(&mut bench, Modifiers::COMMAND, Key::Z);
    assert_eq!(
        (bench.state().text(), height(bench.state(), "tri/Leaf")),
        (edited, 2.0),
        "the model before, with edits"
    );
    press(&mut bench, Modifiers::COMMAND, Key::Z);
    assert_eq!(bench.state().text(), original);
    press(&mut bench, Modifiers::COMMAND, Key::Y);
    press(&mut bench, Modifiers::COMMAND, Key::Y);
    assert_eq!(height(bench.state(), "tri/Leaf"), 5.0);

    // A broken file changes nothing.
    std::fs::write(&path, "{").unwrap();
    let desk = bench.state_mut();
    let before = desk.editor.before_reload(&mut desk.world).unwrap();
    assert!(reenter_scene(&mut desk.world, &mut AssetLibrary::new(), &desk.options, &desk.path).is_err());
    desk.editor.not_reloaded(&mut desk.world, before);
    bench.run_steps(2);
    assert_eq!(height(bench.state(), "tri/Leaf"), 5.0);
}

#[test]
fn a_model_that_is_dropped_is_added() {
    let (mut bench, folder) = bench();
    let before = bench.state().text();
    let model = write_model(folder.path());
    super::tree::drop_file(&mut bench, &model);
    assert!(bench.state().world.find("tri/Leaf").is_some());
    press(&mut bench, Modifiers::COMMAND, Key::Z);
    assert_eq!(bench.state().text(), before);
}
