//! Images and models that change on disk: the scene follows, and a broken file keeps the last good one.

#![allow(clippy::unwrap_used)]

use lightwell::measure::write_png_rgb8;
use lightwell::scene::SceneView;
use lightwell_runtime::cli::{Common, LookArgs, Only};
use lightwell_runtime::session::Session;

/// A quad that carries its corners in the file itself, and an image beside it.
const MODEL: &str = r#"{
    "asset": { "version": "2.0" },
    "scenes": [{ "nodes": [0] }],
    "nodes": [{ "mesh": 0 }],
    "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0, "TEXCOORD_0": 1 }, "material": 0 }] }],
    "materials": [{ "doubleSided": true, "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }],
    "textures": [{ "source": 0 }],
    "images": [{ "uri": "wall.png" }],
    "buffers": [{ "uri": "wall.bin", "byteLength": 60 }],
    "bufferViews": [
        { "buffer": 0, "byteLength": 36 }, { "buffer": 0, "byteOffset": 36, "byteLength": 24 }
    ],
    "accessors": [
        { "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [-9, -9, 0], "max": [9, 9, 0] },
        { "bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC2" }
    ]
}"#;

/// Mean of a layer of a small image.
fn mean(session: &mut Session) -> [f64; 3] {
    let view = SceneView { camera: session.camera().unwrap(), size: [16, 16], jitter: [0.0; 2] };
    let settings = session.render_settings(false);
    session.render(&view, &settings).unwrap();
    let image = session.radiance().unwrap();
    let count = image.pixels().len() as f64;
    [0, 1, 2].map(|c| image.pixels().iter().map(|p| f64::from(p[c])).sum::<f64>() / count)
}

#[test]
fn a_changed_image_shows_and_a_broken_one_keeps_the_last_good() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name);
    let corners: [f32; 15] = [-9.0, -9.0, 0.0, 9.0, -9.0, 0.0, 0.0, 9.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.5, 1.0];
    std::fs::write(file("wall.gltf"), MODEL).unwrap();
    std::fs::write(file("wall.bin"), corners.map(f32::to_le_bytes).concat()).unwrap();
    write_png_rgb8(&file("wall.png"), [1, 1], &[255, 0, 0]).unwrap();
    let scene = r#"Scene(entities: [
        (name: "Camera", transform: (translation: (0, -2, 3)), camera: (fov: 40)),
        (name: "Wall", model: "wall.gltf"),
    ])"#;
    std::fs::write(file("a.scene.ron"), scene).unwrap();
    let look = LookArgs { only: Only::Albedo, ..LookArgs::default() };
    let path = file("a.scene.ron");
    let mut session = Session::headless(path.to_str().unwrap(), &look, &Common::default()).unwrap();
    assert_eq!(mean(&mut session), [1.0, 0.0, 0.0]);
    let names = |session: &Session| -> Vec<String> {
        session.files().iter().map(|path| path.file_name().unwrap().to_string_lossy().into_owned()).collect()
    };
    assert_eq!(names(&session), ["wall.bin", "wall.gltf", "wall.png"], "all are to be watched");

    write_png_rgb8(&file("wall.png"), [1, 1], &[0, 255, 0]).unwrap();
    session.reload().unwrap();
    assert_eq!(mean(&mut session), [0.0, 1.0, 0.0]);

    for broken in ["wall.png", "wall.bin", "wall.gltf"] {
        let good = std::fs::read(file(broken)).unwrap();
        std::fs::write(file(broken), "no such thing").unwrap();
        let error = format!("{:#}", session.reload().unwrap_err());
        assert!(error.contains("wall."), "{broken}: {error}");
        assert_eq!(mean(&mut session), [0.0, 1.0, 0.0], "{broken}: the last good one");
        std::fs::write(file(broken), good).unwrap();
        session.reload().unwrap();
    }
}
