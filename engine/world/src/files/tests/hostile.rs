//! Scenes from elsewhere: they reach no file outside of their project, and take no more of the machine than is allowed.

use super::*;
use crate::assets::LoadBudget;
use crate::measure::{Image, write_image, write_png_rgb8};

const SECRET: &str = "root:secret:0";

/// A project in `game`, and beside it what does not belong to it.
fn outside(scene: &str) -> Folder {
    let folder = Folder::new(&[
        ("secret.txt", SECRET),
        ("outer.prefab.ron", "(entities: [(name: \"A\", mesh: Box())])"),
        ("game/inner.prefab.ron", "(entities: [(name: \"In\", prefab: \"../secret.txt\")])"),
        ("game/a.scene.ron", &scene.replace("OUT", "..")),
    ]);
    write_png_rgb8(&folder.path("red.png"), [1, 1], &[255, 0, 0]).unwrap();
    write_image(&folder.path("sky.exr"), &Image::filled(2, 1, [1.0; 3])).unwrap();
    folder.write("model.glb", &super::models::plain());
    folder
}

fn refused(folder: &Folder, scene: &str) -> FileError {
    let error = folder.load(scene).err().unwrap_or_else(|| panic!("{scene} is read"));
    assert_eq!(error.kind, FileErrorKind::Untrusted, "{error}");
    let text = error.to_string();
    assert!(text.contains("--trust DIR") && !text.contains(SECRET), "{text}");
    error
}

#[test]
fn files_outside_of_the_project_are_refused_until_they_are_trusted() {
    for entity in [
        "prefab: \"OUT/outer.prefab.ron\"",
        "prefab: \"ABS/outer.prefab.ron\"",
        "model: \"OUT/model.glb\"",
        "model: (path: \"ABS/model.glb\")",
        "mesh: Box(), material: (color_texture: \"OUT/red.png\")",
        "mesh: Box(), material: (normal_texture: \"nowhere/OUT/OUT/red.png\")",
    ] {
        let folder = outside("");
        let entity = entity.replace("ABS", &folder.path("").display().to_string().replace('\\', "/"));
        let entity = entity.replace("OUT", "..");
        let is_there = !entity.contains("nowhere");
        folder.write("game/a.scene.ron", format!("Scene(entities: [\n  (name: \"A\", {entity}),\n])").as_bytes());
        let error = refused(&folder, "game/a.scene.ron");
        assert!(error.file.ends_with("a.scene.ron"), "{error}");
        let place = error.place.unwrap();
        assert!(place.line == 2 && place.column > 3, "{error}");
        if is_there {
            let options = LoadOptions { trusted: vec![folder.path("")], ..Default::default() };
            load_scene(&folder.path("game/a.scene.ron"), &mut AssetLibrary::new(), &options).unwrap();
        }
    }
}

#[test]
fn the_image_of_the_sky_is_no_way_out() {
    let folder = outside("Scene(\n  settings: (environment: Image(file: \"OUT/sky.exr\")),\n  entities: [])");
    let error = refused(&folder, "game/a.scene.ron");
    assert_eq!(error.place.unwrap().line, 2, "{error}");
    let options = LoadOptions { trusted: vec![folder.path("")], ..Default::default() };
    load_scene(&folder.path("game/a.scene.ron"), &mut AssetLibrary::new(), &options).unwrap();
}

#[test]
fn a_prefab_is_no_way_out() {
    let folder = outside("Scene(entities: [(name: \"A\", prefab: \"inner.prefab.ron\")])");
    let error = refused(&folder, "game/a.scene.ron");
    assert!(error.file.ends_with("inner.prefab.ron") && error.place.is_some(), "{error}");
}

#[test]
fn other_machines_are_not_asked() {
    for name in [r"\\\\host\\share\\a.prefab.ron", "//host/share/a.prefab.ron", r"\\\\?\\C:\\a.prefab.ron"] {
        let folder = outside(&format!("Scene(entities: [(name: \"A\", prefab: \"{name}\")])"));
        assert_eq!(refused(&folder, "game/a.scene.ron").place.unwrap().line, 1);
    }
}

#[cfg(unix)]
#[test]
fn links_are_no_way_out() {
    let link = |from: &Path, to: &Path| std::os::unix::fs::symlink(from, to).unwrap();
    for entity in
        ["prefab: \"link.ron\"", "model: \"link.glb\"", "mesh: Box(), material: (color_texture: \"all/red.png\")"]
    {
        let folder = outside(&format!("Scene(entities: [(name: \"A\", {entity})])"));
        link(&folder.path("secret.txt"), &folder.path("game/link.ron"));
        link(&folder.path("model.glb"), &folder.path("game/link.glb"));
        link(&folder.path(""), &folder.path("game/all"));
        refused(&folder, "game/a.scene.ron");
    }
    // What is read beside a model without being named.
    let folder = outside("Scene(entities: [(name: \"A\", model: \"m.glb\")])");
    folder.write("game/m.glb", &super::models::plain());
    link(&folder.path("secret.txt"), &folder.path("game/m.import.ron"));
    refused(&folder, "game/a.scene.ron");
    refused(&folder, "game/m.glb");
}

#[test]
fn buffers_and_images_of_models_stay_in_their_folder() {
    let buffer = r#"{"asset":{"version":"2.0"},"buffers":[{"byteLength":4,"uri":"../secret.txt"}]}"#;
    let image = r#"{"asset":{"version":"2.0"},"images":[{"uri":"../red.png"}],"textures":[{"source":0}],
        "materials":[{"pbrMetallicRoughness":{"baseColorTexture":{"index":0}}}]}"#;
    for gltf in [buffer, image] {
        let folder = outside("Scene(entities: [(name: \"A\", model: \"m.gltf\")])");
        folder.write("game/m.gltf", gltf.as_bytes());
        // Nothing is drawn of them: the model loads, with a warning.
        let mut library = AssetLibrary::new();
        load_scene(&folder.path("game/a.scene.ron"), &mut library, &LoadOptions::default())
            .unwrap_or_else(|e| panic!("{e}"));
        let told = library.warnings().collect::<Vec<_>>().join("\n");
        assert!(told.contains("leads out of the asset's folder") && !told.contains(SECRET), "{told}");
        assert!(library.files().iter().all(|file| file.ends_with("m.gltf")), "{:?}", library.files());
    }
}

#[test]
fn a_project_reaches_from_its_scenes_to_its_prefabs_and_models_lie_elsewhere() {
    let folder = Folder::new(&[
        ("p/scenes/deep/a.scene.ron", "Scene(entities: [(name: \"A\", prefab: \"../../prefabs/a.prefab.ron\")])"),
        ("p/prefabs/a.prefab.ron", "(entities: [(name: \"M\", model: \"m.glb\")])"),
    ]);
    folder.write("models/m.glb", &super::models::plain());
    let options = LoadOptions { models: Some(folder.path("models")), ..Default::default() };
    load_scene(&folder.path("p/scenes/deep/a.scene.ron"), &mut AssetLibrary::new(), &options).unwrap();
}

/// Loads with a budget, which is exceeded.
fn over(folder: &Folder, budget: LoadBudget) -> String {
    let options = LoadOptions { budget, ..Default::default() };
    let result = load_scene(&folder.path("a.scene.ron"), &mut AssetLibrary::new(), &options);
    let error = result.err().unwrap_or_else(|| panic!("it is loaded with {options:?}"));
    assert_eq!(error.kind, FileErrorKind::Budget, "{error}");
    assert!(error.place.is_some(), "{error}");
    error.to_string()
}

#[test]
fn repeats_of_repeats_end_at_the_budget() {
    let mut folder = Folder::new(&[("0.prefab.ron", "(entities: [(name: \"A\", mesh: Box())])")]);
    for level in 1..4 {
        let text = format!(
            "(entities: [(name: \"R\", prefab: \"{}.prefab.ron\", repeat: Grid(count: (100, 1, 100), spacing: (1, 1, 1)))])",
            level - 1
        );
        folder.write(&format!("{level}.prefab.ron"), text.as_bytes());
    }
    folder.write("a.scene.ron", b"Scene(entities: [(name: \"A\", prefab: \"3.prefab.ron\")])");
    let budget = LoadBudget { entities: 5000, ..Default::default() };
    let message = over(&folder, budget);
    assert!(message.contains("5001 entities") && message.contains("--budget entities="), "{message}");

    // Nodes of models are entities too.
    folder = Folder::new(&[]);
    folder.write("m.glb", &super::models::plain());
    folder.write("p.prefab.ron", b"(entities: [(name: \"M\", model: \"m.glb\")])");
    let scene = "Scene(entities: [(name: \"R\", prefab: \"p.prefab.ron\", repeat: Ring(count: 20, radius: 1))])";
    folder.write("a.scene.ron", scene.as_bytes());
    assert!(over(&folder, LoadBudget { entities: 70, ..Default::default() }).contains("entities"));
    folder.load("a.scene.ron").unwrap();
}

#[test]
fn large_images_files_and_meshes_end_at_the_budget() {
    let entity = |name: &str| format!("(name: \"{name}\", mesh: Box(), material: (color_texture: \"{name}.png\"))");
    let folder = Folder::new(&[("a.scene.ron", &format!("Scene(entities: [{}, {}])", entity("a"), entity("b")))]);
    for name in ["a.png", "b.png"] {
        write_png_rgb8(&folder.path(name), [64, 64], &[7; 3 * 64 * 64]).unwrap();
    }
    let message = over(&folder, LoadBudget { texels: 5000, ..Default::default() });
    assert!(message.contains("b.png") && message.contains("8192 texels"), "the sum of both: {message}");
    assert!(message.contains("--budget texels=8192"), "{message}");
    assert!(over(&folder, LoadBudget { bytes: 10, ..Default::default() }).contains("bytes"));
    assert!(over(&folder, LoadBudget { triangles: 11, ..Default::default() }).contains("12 triangles"));
    let options = LoadOptions { budget: LoadBudget { texels: 8192, ..Default::default() }, ..Default::default() };
    let mut library = AssetLibrary::new();
    for _ in 0..3 {
        load_scene(&folder.path("a.scene.ron"), &mut library, &options).unwrap();
    }
}

#[test]
fn images_of_models_count_together() {
    let folder = Folder::new(&[("a.scene.ron", "Scene(entities: [(name: \"A\", model: \"m.gltf\")])")]);
    for name in ["a.png", "b.png"] {
        write_png_rgb8(&folder.path(name), [64, 64], &[7; 3 * 64 * 64]).unwrap();
    }
    let gltf = r#"{"asset":{"version":"2.0"},"images":[{"uri":"a.png"},{"uri":"b.png"}],
        "textures":[{"source":0},{"source":1}],"materials":[
            {"pbrMetallicRoughness":{"baseColorTexture":{"index":0}}},
            {"pbrMetallicRoughness":{"baseColorTexture":{"index":1}}}]}"#;
    folder.write("m.gltf", gltf.as_bytes());
    assert!(over(&folder, LoadBudget { texels: 5000, ..Default::default() }).contains("8192 texels"));
}
