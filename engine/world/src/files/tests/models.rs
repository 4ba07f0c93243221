//! glTF models in scenes and as scenes.

use super::*;
use crate::world::{Camera, Clpv, GlobalTransform, Light, LightKind, MeshRenderer, SceneSettings};
use glam::Vec3;
use lightwell_needs::needs;

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
    while !json.len().is_multiple_of(4) {
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

pub(super) fn plain() -> Vec<u8> {
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
    assert!(world.ecs.resource::<SceneSettings>().sky.min_element() > 0.0, "metals need something to mirror");
    let camera = at(&world, "framing camera").unwrap();
    let view = crate::scene::SceneView {
        camera: crate::scene::SceneCamera {
            id: crate::core::SceneId(0),
            name: String::new(),
            world_from_view: world.ecs.get::<GlobalTransform>(camera).unwrap().0,
            projection: crate::scene::ViewProjection::Perspective {
                vertical_fov: world.ecs.get::<Camera>(camera).unwrap().fov.to_radians(),
            },
            near: 0.01,
            far: None,
            primary: true,
            lens: Default::default(),
            grading: None,
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
    assert_eq!(world.ecs.resource::<SceneSettings>().sky, Vec3::ZERO, "light as the file has it");
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
    let options = LoadOptions { models: Some(folder.path("models")), ..Default::default() };
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

/// A scene with a third-party model.
struct WithModel {
    scene: &'static str,
    model: &'static str,
    /// A word of where to get it.
    source: &'static str,
    stand_in: &'static str,
    /// Least and most triangles of the whole scene, and primitives.
    triangles: [usize; 2],
    primitives: [usize; 2],
}

const WITH_MODELS: [WithModel; 4] = [
    WithModel {
        scene: "conference",
        model: "conference/conference.glb",
        source: "casual-effects",
        stand_in: "meeting_room",
        triangles: [328_000, 345_000],
        primitives: [33, 80],
    },
    WithModel {
        scene: "dabrovic",
        model: "sponza-dabrovic/sponza-dabrovic.glb",
        source: "casual-effects",
        stand_in: "night_court",
        triangles: [100_000, 200_000],
        primitives: [37, 400],
    },
    WithModel {
        scene: "sibenik",
        model: "sibenik/sibenik.glb",
        source: "casual-effects",
        stand_in: "cathedral",
        triangles: [73_564, 90_000],
        primitives: [1_200, 2_500],
    },
    WithModel {
        scene: "sponza",
        model: "sponza/Sponza.gltf",
        source: "glTF-Sample-Assets",
        stand_in: "courtyard",
        triangles: [262_267, 300_000],
        primitives: [381, 420],
    },
];

#[test]
fn scenes_say_where_to_get_their_models_and_what_to_play_instead() {
    for WithModel { scene, model, source, stand_in, .. } in WITH_MODELS {
        let path = shipped(&format!("scenes/{scene}.scene.ron"));
        let error = load_scene(&path, &mut AssetLibrary::new(), &LoadOptions::default()).err().unwrap();
        assert_eq!(error.kind, FileErrorKind::MissingModel, "{error}");
        let text = error.to_string();
        for part in [model, source, stand_in, "--models"] {
            assert!(text.contains(part), "{part} in {text}");
        }
        assert!(shipped(&format!("scenes/{stand_in}.scene.ron")).is_file());
    }
}

/// Triangles and primitives of a scene; prints them with the time that loading takes.
fn size(scene: &str, options: &LoadOptions) -> [usize; 2] {
    let start = std::time::Instant::now();
    let mut world = load_scene(&shipped(&format!("scenes/{scene}.scene.ron")), &mut AssetLibrary::new(), options)
        .unwrap_or_else(|e| panic!("{e}"));
    let time = start.elapsed();
    let drawn = all::<MeshRenderer>(&mut world);
    let triangles: usize = drawn.iter().map(|r| r.mesh.triangle_count()).sum();
    eprintln!(
        "{scene}: {triangles} triangles, {} primitives, loaded in {:.0} ms",
        drawn.len(),
        1e3 * time.as_secs_f64()
    );
    [triangles, drawn.len()]
}

fn assert_within(scene: &str, [triangles, primitives]: [usize; 2], t: [usize; 2], p: [usize; 2]) {
    assert!((t[0]..=t[1]).contains(&triangles), "{scene}: {triangles} triangles");
    assert!((p[0]..=p[1]).contains(&primitives), "{scene}: {primitives} primitives");
}

#[needs("LIGHTWELL_MODELS")]
fn real_models_open() {
    let models = std::env::var_os("LIGHTWELL_MODELS").map(PathBuf::from).expect("LIGHTWELL_MODELS is not set");
    let options = LoadOptions { models: Some(models), ..Default::default() };
    for WithModel { scene, triangles, primitives, .. } in WITH_MODELS {
        assert_within(scene, size(scene, &options), triangles, primitives);
    }
}

#[test]
fn stand_ins_are_as_rich_as_what_they_stand_for() {
    for (scene, triangles, primitives) in [
        ("meeting_room", [150_000, 600_000], [500, 3_000]),
        ("night_court", [60_000, 400_000], [600, 4_000]),
        ("cathedral", [50_000, 250_000], [1_200, 5_000]),
        ("courtyard", [200_000, 600_000], [600, 4_000]),
    ] {
        assert_within(scene, size(scene, &LoadOptions::default()), triangles, primitives);
    }
}

#[needs("LIGHTWELL_REFERENCE")]
fn reference_scenes_open_with_their_camera_and_light() {
    let folder = std::env::var_os("LIGHTWELL_REFERENCE").map(PathBuf::from).expect("LIGHTWELL_REFERENCE is not set");
    let mut world = load_scene(&folder.join("cornell/scene.glb"), &mut AssetLibrary::new(), &LoadOptions::default())
        .unwrap_or_else(|e| panic!("{e}"));
    assert!(at(&world, "framing camera").is_none() && at(&world, "default light").is_none());
    assert!(!all::<Camera>(&mut world).is_empty() && !all::<Light>(&mut world).is_empty());
}

#[test]
fn models_are_imported_as_the_scene_or_the_file_beside_them_says() {
    let folder = Folder::new(&[
        ("beside.scene.ron", "(entities: [(name: \"M\", model: \"m.glb\")])"),
        ("here.scene.ron", "(entities: [(name: \"M\", model: (path: \"m.glb\", import: (scale: 3)))])"),
        ("m.import.ron", "// Half as large.\nImport(scale: 0.5, up: Y)"),
    ]);
    folder.write("m.glb", &plain());
    let leaf = |scene: &str, path: &str| {
        let world = folder.load(scene).unwrap_or_else(|e| panic!("{e}"));
        Vec3::from(world.ecs.get::<GlobalTransform>(at(&world, path).unwrap()).unwrap().0.translation)
    };
    assert_eq!(leaf("beside.scene.ron", "M/Root/Leaf"), Vec3::new(1.0, 0.5, 0.0));
    assert_eq!(leaf("m.glb", "m/Root/Leaf"), Vec3::new(1.0, 0.5, 0.0));
    assert_eq!(leaf("here.scene.ron", "M/Root/Leaf"), Vec3::new(6.0, 3.0, 0.0));
    let world = folder.load("here.scene.ron").unwrap();
    save_scene(&world, &folder.path("again.scene.ron")).unwrap();
    let saved = folder.read("again.scene.ron");
    assert!(saved.contains("import: (scale: 3)"), "{saved}");
    assert_eq!(leaf("again.scene.ron", "M/Root/Leaf"), Vec3::new(6.0, 3.0, 0.0));
}

#[test]
fn faults_of_import_settings_are_placed() {
    let scene = |import: &str| format!("(entities: [\n(name: \"M\", model: (path: \"m.glb\", import: ({import})))])");
    let fails = |import: &str, beside: &str| {
        let folder = Folder::new(&[
            ("a.scene.ron", &scene(import)),
            ("b.scene.ron", "(entities: [(name: \"M\", model: \"m.glb\")])"),
        ]);
        folder.write("m.glb", &plain());
        if !beside.is_empty() {
            folder.write("m.import.ron", beside.as_bytes());
        }
        folder.load(if beside.is_empty() { "a.scene.ron" } else { "b.scene.ron" }).err().unwrap()
    };
    for (import, said) in [
        ("scale: 0", "`scale` is 0"),
        ("normals: Smooth(crease: 200)", "0 to 180"),
        ("ignore: [\"Root\", \"\"]", "empty"),
        ("ignore: [\"Blind*\"]", "`Blind*`"),
    ] {
        let error = fails(import, "");
        assert!(error.message.contains(said), "{error}");
        assert_eq!(error.place.map(|p| p.line), Some(2), "{error}");
    }
    let error = fails("", "Import(\n    scale: 1,\n    ignore: [\"Leaf\",\n    \"Lamp ?\"],\n)");
    assert!(error.file.ends_with("m.import.ron") && error.message.contains("`Lamp ?`"), "{error}");
    assert_eq!(error.place.map(|p| p.line), Some(4), "{error}");
    let error = fails("", "(scalle: 2)");
    assert!(error.to_string().contains("did you mean `scale`?"), "{error}");
}

#[test]
fn presets_are_kept_and_their_faults_placed() {
    let folder = Folder::new(&[
        ("a.scene.ron", "(presets: { \"soft\": [\"clpv.steps=8\"] }, entities: [])"),
        ("b.scene.ron", "(presets: {\n\"soft\": [\n\"clpv.steps\"] }, entities: [])"),
    ]);
    let world = folder.load("a.scene.ron").unwrap_or_else(|e| panic!("{e}"));
    save_scene(&world, &folder.path("c.scene.ron")).unwrap();
    let again = folder.load("c.scene.ron").unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(again.ecs.resource::<SceneInfo>().presets["soft"], ["clpv.steps=8"]);
    let error = folder.load("b.scene.ron").err().unwrap();
    assert!(error.message.contains("`clpv.steps`") && error.place.map(|p| p.line) == Some(3), "{error}");
}

/// Where cameras, lights and meshes are at a time, and how strong the lights are.
fn places(world: &mut GameWorld, seconds: f64) -> [Vec<String>; 3] {
    world.set_seconds(seconds);
    world.update();
    let mut query = world.ecs.query::<(&GlobalTransform, Option<&Camera>, Option<&Light>, Option<&MeshRenderer>)>();
    let mut found = <[Vec<String>; 3]>::default();
    for (place, camera, light, mesh) in query.iter(&world.ecs) {
        let place = format!("{place:?}");
        found[0].extend(camera.map(|_| place.clone()));
        found[1].extend(light.map(|light| format!("{place} {light:?}")));
        found[2].extend(mesh.map(|_| place.clone()));
    }
    found
}

#[test]
fn cameras_lights_and_objects_move_in_every_shipped_scene() {
    for scene in ["cornell", "bleeding_gloss", "meeting_room", "night_court", "cathedral", "courtyard"] {
        let path = shipped(&format!("scenes/{scene}.scene.ron"));
        let mut world = load_scene(&path, &mut AssetLibrary::new(), &LoadOptions::default()).unwrap();
        let length = f64::from(world.rest_settings().duration.unwrap_or_else(|| panic!("{scene} has no loop")));
        let [start, later] = [0.0, 0.4 * length].map(|time| places(&mut world, time));
        for (i, what) in ["camera", "light", "object"].iter().enumerate() {
            assert!(!start[i].is_empty() && start[i] != later[i], "no {what} of {scene} moves");
        }
    }
}

/// A model that is saved as a scene is named by the way to it: both can be moved together.
#[test]
fn a_saved_model_moves_with_its_folder() {
    for scene in ["art/room.scene.ron", "art/scenes/room.scene.ron", "art/models/room.scene.ron"] {
        let folder = Folder::new(&[]);
        folder.write("art/models/m.glb", &plain());
        std::fs::create_dir_all(folder.path("art/scenes")).unwrap();
        let options = LoadOptions { trusted: vec![folder.path("")], ..Default::default() };
        let (model, scene) = (folder.path("art/models/m.glb"), folder.path(scene));
        let mut library = AssetLibrary::new();
        let mut world = load_scene(&model, &mut library, &options).unwrap_or_else(|e| panic!("{e}"));
        crate::files::save_scene_as(&mut world, &library, &options, &model, &scene).unwrap_or_else(|e| panic!("{e}"));
        // And once more to another place.
        let again = folder.path("art/again.scene.ron");
        crate::files::save_scene_as(&mut world, &library, &options, &scene, &again).unwrap_or_else(|e| panic!("{e}"));
        std::fs::rename(folder.path("art"), folder.path("moved")).unwrap();
        for file in [scene, again] {
            let moved = folder.path("moved").join(file.strip_prefix(folder.path("art")).unwrap());
            let text = std::fs::read_to_string(&moved).unwrap();
            assert!(!text.contains(&*folder.path("").to_string_lossy()), "{text}");
            let world = load_scene(&moved, &mut AssetLibrary::new(), &options).unwrap_or_else(|e| panic!("{e}"));
            assert!(at(&world, "m/Root/Leaf").is_some() && world.ecs.resource::<SceneSettings>().auto_exposure);
        }
    }
}

/// What shines lights a model: no other light is added to it.
#[test]
fn emissive_surfaces_count_as_light() {
    for (material, is_lit) in [
        (r#"{"emissiveFactor":[1,0.5,0]}"#, true),
        (r#"{"emissiveFactor":[0,0,0]}"#, false),
        (r#"{"extensions":{"KHR_materials_unlit":{}}}"#, false),
    ] {
        let folder = Folder::new(&[]);
        let extra = format!(r#","materials":[{material}]"#);
        let mut whole = glb("", "0", &extra);
        replace(&mut whole, r#""attributes":{"POSITION":0}}"#, r#""material":0,"attributes":{"POSITION":0}}"#);
        folder.write("m.glb", &whole);
        let mut world = folder.load("m.glb").unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(all::<Light>(&mut world).is_empty(), is_lit, "{material}");
        assert_eq!(world.ecs.resource::<SceneSettings>().sky == Vec3::ZERO, is_lit, "{material}");
    }
}

/// Replaces text in the JSON of a binary file.
fn replace(glb: &mut Vec<u8>, from: &str, to: &str) {
    let length = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
    let mut json = String::from_utf8(glb[20..20 + length].to_vec()).unwrap().replace(from, to);
    while !json.len().is_multiple_of(4) {
        json.push(' ');
    }
    glb.splice(20..20 + length, json.bytes());
    let (all, json) = (glb.len() as u32, json.len() as u32);
    glb[8..12].copy_from_slice(&all.to_le_bytes());
    glb[12..16].copy_from_slice(&json.to_le_bytes());
}

/// Very small and very large models are seen as one of a metre is.
#[test]
fn models_of_any_size_are_framed() {
    for size in [1e-5f32, 1e-3, 1.0, 1e3, 1e5] {
        let folder = Folder::new(&[]);
        let mut bytes = plain();
        replace(&mut bytes, r#""translation":[0,1,0]"#, &format!(r#""scale":[{size},{size},{size}]"#));
        folder.write("m.glb", &bytes);
        let mut world = folder.load("m.glb").unwrap_or_else(|e| panic!("{e}"));
        let camera = at(&world, "framing camera").unwrap();
        let settings = world.ecs.get::<Camera>(camera).unwrap().clone();
        let place = world.ecs.get::<GlobalTransform>(camera).unwrap().0;
        // The model spans 3 by 1 of its sizes.
        let center = size * Vec3::new(1.5, 0.5, 0.0);
        let distance = Vec3::from(place.translation).distance(center) / size;
        assert!((3.0..6.0).contains(&distance), "{size} m: seen from {distance} times as far");
        assert!(settings.near < 0.1 * distance * size && settings.near > 1e-5 * distance * size, "{size} m");
        let mut scene = crate::scene::Scene::default();
        crate::scene::Extractor::new().extract(&mut world, &mut scene);
        assert!(scene.warnings.is_empty(), "{size} m: {:?}", scene.warnings);
    }
}

/// Many nodes load in linear time, however they hang together and are called.
#[test]
fn many_nodes_load_in_linear_time() {
    const COUNT: usize = 100_000;
    let chained = |i: usize| if i + 1 < COUNT { format!("{{\"children\":[{}]}}", i + 1) } else { "{}".into() };
    let named = |_: usize| "{\"name\":\"n\"}".to_owned();
    let all = (0..COUNT).map(|i| i.to_string()).collect::<Vec<_>>().join(",");
    for (node, roots) in [(&chained as &dyn Fn(usize) -> String, "0".to_owned()), (&named, all)] {
        let nodes = (0..COUNT).map(node).collect::<Vec<_>>().join(",");
        let folder = Folder::new(&[]);
        let json = format!(r#"{{"asset":{{"version":"2.0"}},"scenes":[{{"nodes":[{roots}]}}],"nodes":[{nodes}]}}"#);
        folder.write("m.gltf", json.as_bytes());
        let start = std::time::Instant::now();
        folder.load("m.gltf").unwrap_or_else(|e| panic!("{e}"));
        eprintln!("{COUNT} nodes: {:?}", start.elapsed());
        assert!(start.elapsed().as_secs() < 60, "{:?}", start.elapsed());
    }
}

/// So do they when they are read again, and the entities keep their identities.
#[test]
fn many_nodes_reload_in_linear_time() {
    const COUNT: usize = 100_000;
    let node = |i: usize| match i + 1 < COUNT {
        true => format!("{{\"name\":\"n{i}\",\"children\":[{}]}}", i + 1),
        false => "{\"name\":\"end\"}".into(),
    };
    let nodes = (0..COUNT).map(node).collect::<Vec<_>>().join(",");
    let folder = Folder::new(&[]);
    let json = format!(r#"{{"asset":{{"version":"2.0"}},"scenes":[{{"nodes":[0]}}],"nodes":[{nodes}]}}"#);
    folder.write("m.gltf", json.as_bytes());
    let mut world = folder.load("m.gltf").unwrap_or_else(|e| panic!("{e}"));
    let before = world.identities();
    let start = std::time::Instant::now();
    let (mut library, options) = (AssetLibrary::new(), LoadOptions::default());
    crate::files::reenter_scene(&mut world, &mut library, &options, &folder.path("m.gltf")).unwrap();
    eprintln!("{COUNT} nodes again: {:?}", start.elapsed());
    assert!(start.elapsed().as_secs() < 60, "{:?}", start.elapsed());
    assert!(before == world.identities() && before.ids().count() > COUNT);
}
