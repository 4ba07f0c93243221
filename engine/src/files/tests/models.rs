//! glTF models in scenes and as scenes.

use super::*;
use crate::world::{Camera, Clpv, GlobalTransform, Light, LightKind, MeshRenderer};
use glam::Vec3;

/// A binary glTF of two triangles: node `Root` (moved up by 1) with child `Leaf` (moved right by 2), both drawn.
/// `extra`: more nodes and what they need, as JSON members of the top object, and the list of the scene's nodes.
fn glb(nodes: &str, scene: &str, extra: &str) -> Vec<u8> {
    let positions: [f32; 9] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let bin: Vec<u8> = positions.iter().flat_map(|v| v.to_le_bytes()).collect();
    let mut json = format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[{scene}]}}],
        "nodes":[{{"name":"Root","mesh":0,"translation":[0,1,0],"children":[1]}},{{"name":"Leaf","mesh":0,"translation":[2,0,0]}}{nodes}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}}],
        "bufferViews":[{{"buffer":0,"byteLength":36}}],"buffers":[{{"byteLength":36}}]{extra}}}"#
    );
    while json.len() % 4 != 0 {
        json.push(' ');
    }
    let mut bytes = b"glTF".to_vec();
    for word in [2, 12 + 8 + json.len() + 8 + bin.len(), json.len()] {
        bytes.extend((word as u32).to_le_bytes());
    }
    bytes.extend(b"JSON");
    bytes.extend(json.bytes());
    bytes.extend((bin.len() as u32).to_le_bytes());
    bytes.extend(b"BIN\0");
    bytes.extend(bin);
    bytes
}

fn plain() -> Vec<u8> {
    glb("", "0", "")
}

fn all<T: bevy_ecs::prelude::Component + Clone>(world: &mut GameWorld) -> Vec<T> {
    world.ecs.query::<&T>().iter(&world.ecs).cloned().collect()
}

#[test]
fn a_bare_model_opens_as_a_scene_with_camera_light_and_volumes() {
    let folder = Folder::new(&[]);
    folder.write("m.glb", &plain());
    let mut world = folder.load("m.glb").unwrap();
    let leaf = at(&world, "m/Root/Leaf").unwrap();
    let place = world.ecs.get::<GlobalTransform>(leaf).unwrap().0.translation;
    assert_eq!(Vec3::from(place), Vec3::new(2.0, 1.0, 0.0));
    assert!(matches!(all::<Light>(&mut world)[..], [Light { kind: LightKind::Directional, .. }]));
    assert_eq!(all::<Clpv>(&mut world), [Clpv::default()]);
    assert_eq!(all::<Camera>(&mut world).len(), 1);
    // The camera sees all of the model.
    let camera = at(&world, "framing camera").unwrap();
    let view = crate::scene::SceneView {
        camera: crate::scene::SceneCamera {
            id: crate::scene::SceneId(0),
            name: String::new(),
            world_from_view: world.ecs.get::<GlobalTransform>(camera).unwrap().0,
            vertical_fov: world.ecs.get::<Camera>(camera).unwrap().fov.to_radians(),
            near: 0.01,
            far: None,
            primary: true,
        },
        size: [64, 64],
        jitter: [0.0; 2],
    };
    for point in [Vec3::new(0.0, 1.0, 0.0), Vec3::new(3.0, 1.0, 0.0), Vec3::new(2.0, 2.0, 0.0)] {
        let clip = view.clip_from_world() * point.extend(1.0);
        assert!(clip.w > 0.0 && clip.x.abs() < clip.w && clip.y.abs() < clip.w, "{clip}");
    }
}

#[test]
fn cameras_and_lights_of_a_model_are_kept() {
    let nodes = r#",{"name":"Eye","camera":0},{"name":"Lamp","extensions":{"KHR_lights_punctual":{"light":0}}}"#;
    let extra = r#","cameras":[{"type":"perspective","perspective":{"yfov":1,"znear":0.1}}],
        "extensionsUsed":["KHR_lights_punctual"],"extensions":{"KHR_lights_punctual":{"lights":[{"type":"point","intensity":7}]}}"#;
    let folder = Folder::new(&[("a.scene.ron", "(entities: [(name: \"M\", model: \"m.glb\")])")]);
    folder.write("m.glb", &glb(nodes, "0,2,3", extra));
    let mut world = folder.load("m.glb").unwrap();
    assert!(at(&world, "framing camera").is_none() && at(&world, "default light").is_none());
    assert!(matches!(all::<Light>(&mut world)[..], [Light { kind: LightKind::Point, intensity: 7.0, .. }]));
    assert!((all::<Camera>(&mut world)[0].fov - 1f32.to_degrees()).abs() < 1e-4);
    let mut scene = folder.load("a.scene.ron").unwrap();
    assert_eq!((all::<Light>(&mut scene).len(), all::<Camera>(&mut scene).len()), (0, 0));
}

#[test]
fn models_are_found_shared_and_saved_by_reference() {
    let scene = r#"(
        materials: { "red": (color: (1, 0, 0)) },
        entities: [
            (name: "All", model: "sub/m.glb"),
            (name: "Part", model: (path: "sub/m.glb", node: "Leaf"), material: "red", casts_shadow: false),
        ],
    )"#;
    let folder = Folder::new(&[("scenes/a.scene.ron", scene)]);
    folder.write("models/sub/m.glb", &plain());
    let options = LoadOptions { models: Some(folder.path("models")) };
    let mut library = AssetLibrary::new();
    let path = folder.path("scenes/a.scene.ron");
    let world = load_scene(&path, &mut library, &options).unwrap_or_else(|e| panic!("{e}"));
    let renderer = |p: &str| world.ecs.get::<MeshRenderer>(at(&world, p).unwrap()).unwrap().clone();
    let (whole, part) = (renderer("All/Root/Leaf"), renderer("Part/Root/Leaf"));
    assert_eq!(whole.mesh.id, part.mesh.id);
    assert_eq!(part.material.base_color.truncate(), Vec3::X);
    assert!(whole.casts_shadow && !part.casts_shadow);
    let place = world.ecs.get::<GlobalTransform>(at(&world, "Part/Root/Leaf").unwrap()).unwrap().0.translation;
    assert_eq!(Vec3::from(place), Vec3::new(2.0, 1.0, 0.0));
    assert!(world.ecs.get::<MeshRenderer>(at(&world, "Part/Root").unwrap()).is_none());
    save_scene(&world, &path).unwrap();
    let saved = folder.read("scenes/a.scene.ron");
    assert!(saved.contains("model: (path: \"sub/m.glb\", node: \"Leaf\")") && !saved.contains("Root"), "{saved}");
    load_scene(&path, &mut library, &options).unwrap_or_else(|e| panic!("{e}"));
    // Without the models' folder the file is looked for beside the scene.
    let error = load_scene(&path, &mut library, &LoadOptions::default()).err().unwrap();
    assert_eq!(error.kind, FileErrorKind::MissingFile);
}

#[test]
fn an_unknown_node_and_a_broken_model_are_named() {
    let folder = Folder::new(&[
        ("a.scene.ron", "(entities: [(name: \"M\", model: (path: \"m.glb\", node: \"Laef\"))])"),
        ("b.scene.ron", "(entities: [\n(name: \"M\", model: \"broken.glb\")])"),
    ]);
    folder.write("m.glb", &plain());
    folder.write("broken.glb", &plain()[..100]);
    let error = folder.load("a.scene.ron").err().unwrap();
    assert!(error.kind == FileErrorKind::UnknownName && error.to_string().contains("`Leaf`"), "{error}");
    let error = folder.load("b.scene.ron").err().unwrap();
    assert!(error.kind == FileErrorKind::Asset && error.message.contains("broken.glb"), "{error}");
    assert_eq!(error.place.map(|p| p.line), Some(2));
    assert_eq!(folder.load("broken.glb").err().unwrap().kind, FileErrorKind::Asset);
}

#[test]
fn an_opened_model_saves_as_a_scene() {
    let folder = Folder::new(&[]);
    folder.write("m.glb", &plain());
    let world = folder.load("m.glb").unwrap();
    save_scene(&world, &folder.path("sub.scene.ron")).unwrap();
    let again = folder.load("sub.scene.ron").unwrap_or_else(|e| panic!("{e}"));
    assert!(at(&again, "m/Root/Leaf").is_some() && at(&again, "framing camera").is_some());
}

#[test]
fn sponza_says_where_to_get_its_model() {
    let error = load_scene(&shipped("scenes/sponza.scene.ron"), &mut AssetLibrary::new(), &LoadOptions::default())
        .err()
        .unwrap();
    assert_eq!(error.kind, FileErrorKind::MissingModel, "{error}");
    let text = error.to_string();
    for part in ["sponza/Sponza.gltf", "glTF-Sample-Assets", "--models", "cornell"] {
        assert!(text.contains(part), "{part} in {text}");
    }
}

#[test]
fn real_models_open() {
    let Some(models) = std::env::var_os("LIGHTWELL_MODELS").map(PathBuf::from) else {
        eprintln!("skipped: LIGHTWELL_MODELS is not set");
        return;
    };
    let options = LoadOptions { models: Some(models) };
    let mut world = load_scene(&shipped("scenes/sponza.scene.ron"), &mut AssetLibrary::new(), &options)
        .unwrap_or_else(|e| panic!("{e}"));
    let triangles: usize = all::<MeshRenderer>(&mut world).iter().map(|r| r.mesh.triangle_count()).sum();
    assert!((262_267..300_000).contains(&triangles), "{triangles}");
}

#[test]
fn reference_scenes_open_with_their_camera_and_light() {
    let Some(folder) = std::env::var_os("LIGHTWELL_REFERENCE").map(PathBuf::from) else {
        eprintln!("skipped: LIGHTWELL_REFERENCE is not set");
        return;
    };
    let mut world = load_scene(&folder.join("cornell/scene.glb"), &mut AssetLibrary::new(), &LoadOptions::default())
        .unwrap_or_else(|e| panic!("{e}"));
    assert!(at(&world, "framing camera").is_none() && at(&world, "default light").is_none());
    assert!(!all::<Camera>(&mut world).is_empty() && !all::<Light>(&mut world).is_empty());
}
