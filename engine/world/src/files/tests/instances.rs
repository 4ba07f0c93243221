//! Prefab instances and their overrides.

use super::*;
use crate::assets::Mesh;
use crate::world::{Fog, Light, MeshRenderer, Particles, Transform};
use glam::{Quat, Vec3};
use std::sync::Arc;

const LAMP: &str = r#"Prefab(
    materials: { "metal": (color: (0.2, 0.2, 0.2)), "glass": (color: (0.9, 0.9, 0.9)) },
    entities: [
        (name: "Pole", mesh: Box(size: (0.1, 2, 0.1)), material: "metal", children: [
            (name: "Bulb", transform: (translation: (0, 1, 0)), mesh: Box(size: (0.2, 0.2, 0.2)), material: "glass",
                light: (kind: Point, intensity: 3)),
            (name: "Sign", mesh: Box(size: (0.3, 0.2, 0.01))),
        ]),
    ],
)"#;

const PAIR: &str = r#"(entities: [
    (name: "Left", prefab: "lamp.prefab.ron"),
    (name: "Right", prefab: "lamp.prefab.ron", overrides: { "Pole/Bulb": (light: (kind: Point, intensity: 5)) }),
])"#;

const SCENE: &str = r#"(
    materials: { "glass": (color: (0, 0, 1)) },
    entities: [
        (name: "Street", prefab: "pair.prefab.ron", transform: (translation: (0, 0, -4)), overrides: {
            "Right/Pole/Bulb": (transform: (translation: (0, 0.5, 0)), material: "glass"),
            "Right/Pole/Sign": (remove: true),
            "Left/Pole/Bulb": (without: [Light], children: [(name: "Fly")]),
        }, children: [(name: "Post")]),
    ],
)"#;

fn street() -> Folder {
    Folder::new(&[("lamp.prefab.ron", LAMP), ("pair.prefab.ron", PAIR), ("street.scene.ron", SCENE)])
}

fn color(world: &GameWorld, path: &str) -> Vec3 {
    let entity = at(world, path).unwrap();
    world.ecs.get::<MeshRenderer>(entity).unwrap().material.base_color.truncate()
}

fn intensity(world: &GameWorld, path: &str) -> Option<f32> {
    world.ecs.get::<Light>(at(world, path).unwrap()).map(|l| l.intensity)
}

fn check_street(world: &GameWorld) {
    assert_eq!(intensity(world, "Street/Left/Pole/Bulb"), None);
    assert_eq!(intensity(world, "Street/Right/Pole/Bulb"), Some(5.0));
    assert_eq!(color(world, "Street/Left/Pole/Bulb"), Vec3::splat(0.9));
    assert_eq!(color(world, "Street/Right/Pole/Bulb"), Vec3::Z);
    assert!(at(world, "Street/Right/Pole/Sign").is_none() && at(world, "Street/Left/Pole/Sign").is_some());
    assert!(at(world, "Street/Left/Pole/Bulb/Fly").is_some() && at(world, "Street/Post").is_some());
    let bulb = world.ecs.get::<Transform>(at(world, "Street/Right/Pole/Bulb").unwrap()).unwrap();
    assert_eq!(bulb.translation, Vec3::new(0.0, 0.5, 0.0));
}

#[test]
fn overrides_reach_nested_instances_and_survive_a_save() {
    let folder = street();
    let world = folder.load("street.scene.ron").unwrap();
    check_street(&world);
    save_scene(&world, &folder.path("saved.scene.ron")).unwrap();
    let saved = folder.read("saved.scene.ron");
    assert!(saved.contains("prefab: \"pair.prefab.ron\"") && !saved.contains("metal"), "{saved}");
    let again = folder.load("saved.scene.ron").unwrap_or_else(|e| panic!("{e}\n{saved}"));
    check_street(&again);
    save_scene(&again, &folder.path("twice.scene.ron")).unwrap();
    assert_eq!(folder.read("twice.scene.ron"), saved);
}

#[test]
fn equal_shapes_and_named_materials_are_shared() {
    let world = street().load("street.scene.ron").unwrap();
    let mesh =
        |path: &str| -> Arc<Mesh> { world.ecs.get::<MeshRenderer>(at(&world, path).unwrap()).unwrap().mesh.clone() };
    assert!(Arc::ptr_eq(&mesh("Street/Left/Pole"), &mesh("Street/Right/Pole")));
}

#[test]
fn edits_inside_an_instance_become_overrides() {
    let folder = street();
    let mut world = folder.load("street.scene.ron").unwrap();
    let pole = at(&world, "Street/Left/Pole").unwrap();
    let mut material = (*world.ecs.get::<MeshRenderer>(pole).unwrap().material).clone();
    material.roughness = 0.25;
    material.id = crate::assets::AssetId::fresh();
    world.ecs.get_mut::<MeshRenderer>(pole).unwrap().material = Arc::new(material);
    let sign = at(&world, "Street/Left/Pole/Sign").unwrap();
    world.ecs.despawn(sign);
    let right = at(&world, "Street/Right").unwrap();
    let turned = Transform { rotation: Quat::from_rotation_y(1.0), ..Default::default() };
    world.ecs.entity_mut(right).insert(turned);
    save_scene(&world, &folder.path("saved.scene.ron")).unwrap();
    let again = folder.load("saved.scene.ron").unwrap();
    assert_eq!(
        again.ecs.get::<MeshRenderer>(at(&again, "Street/Left/Pole").unwrap()).unwrap().material.roughness,
        0.25
    );
    assert!(at(&again, "Street/Left/Pole/Sign").is_none());
    assert_eq!(*again.ecs.get::<Transform>(at(&again, "Street/Right").unwrap()).unwrap(), turned);
    assert_eq!(intensity(&again, "Street/Right/Pole/Bulb"), Some(5.0));
}

#[test]
fn fog_of_a_prefab_is_overridden_and_taken_away() {
    let scene = r#"(entities: [
        (name: "A", prefab: "mist.prefab.ron"),
        (name: "B", prefab: "mist.prefab.ron"),
        (name: "C", prefab: "mist.prefab.ron"),
    ])"#;
    let mist = r#"Prefab(entities: [(name: "Mist", fog: (extinction: 0.5))])"#;
    let folder = Folder::new(&[("mist.prefab.ron", mist), ("s.scene.ron", scene)]);
    let mut world = folder.load("s.scene.ron").unwrap();
    let [b, c] = ["B/Mist", "C/Mist"].map(|path| at(&world, path).unwrap());
    world.ecs.get_mut::<Fog>(b).unwrap().extinction = 0.25;
    world.ecs.entity_mut(c).remove::<Fog>();
    save_scene(&world, &folder.path("s.scene.ron")).unwrap();
    let text = folder.read("s.scene.ron");
    assert!(text.contains(r#"overrides: {"Mist": (fog: (extinction: 0.25))}"#), "{text}");
    assert!(text.contains(r#"overrides: {"Mist": (without: [Fog])}"#), "{text}");
    let again = folder.load("s.scene.ron").unwrap();
    let found = ["A", "B", "C"].map(|instance| {
        let entity = at(&again, &format!("{instance}/Mist")).unwrap();
        again.ecs.get::<Fog>(entity).map(|fog| fog.extinction)
    });
    assert_eq!(found, [Some(0.5), Some(0.25), None]);
}

#[test]
fn apply_writes_what_an_instance_changes_into_its_prefab() {
    let folder = street();
    let world = folder.load("street.scene.ron").unwrap();
    let (scene, prefab) = (folder.path("street.scene.ron"), folder.path("pair.prefab.ron"));
    apply_to_prefab(&world, at(&world, "Street").unwrap(), &scene, &prefab).unwrap();
    let pair = folder.read("pair.prefab.ron");
    let inner = "prefab: \"lamp.prefab.ron\",\n        overrides: {\"Pole/Bulb\": (without: [Light], children: [(name: \"Fly\")])},";
    assert!(pair.contains(inner), "{pair}");
    folder.write("plain.scene.ron", b"(entities: [(name: \"Street\", prefab: \"pair.prefab.ron\")])");
    check_street(&folder.load("plain.scene.ron").unwrap_or_else(|error| panic!("{error}\n{pair}")));
    let error = apply_to_prefab(&world, at(&world, "Street/Left").unwrap(), &scene, &prefab).unwrap_err();
    assert!(error.message.contains("belongs to another prefab"), "{error}");
    assert_eq!(folder.read("pair.prefab.ron"), pair);
}

#[test]
fn a_broken_instance_with_instances_inside_is_plain() {
    let folder = street();
    let mut world = folder.load("street.scene.ron").unwrap();
    let instance = at(&world, "Street").unwrap();
    break_prefab(&mut world, instance);
    save_scene(&world, &folder.path("plain.scene.ron")).unwrap();
    let plain = folder.read("plain.scene.ron");
    assert!(!plain.contains("prefab"), "{plain}");
    check_street(&folder.load("plain.scene.ron").unwrap_or_else(|error| panic!("{error}\n{plain}")));
}

#[test]
fn a_mesh_made_by_code_cannot_be_saved_and_leaves_the_file_alone() {
    let folder = street();
    let mut world = folder.load("street.scene.ron").unwrap();
    let entity = world.spawn("Code", None);
    let renderer = MeshRenderer {
        mesh: Arc::new(Mesh::new("made", Vec::new(), Vec::new())),
        material: Arc::new(crate::assets::Material::new("m")),
        casts_shadow: true,
        visible: true,
    };
    world.ecs.entity_mut(entity).insert(renderer);
    let error = save_scene(&world, &folder.path("street.scene.ron")).unwrap_err();
    assert_eq!(error.kind, FileErrorKind::Unsavable);
    assert!(error.message.contains("`Code`"), "{error}");
    assert_eq!(folder.read("street.scene.ron"), SCENE);
    world.ecs.entity_mut(entity).remove::<MeshRenderer>();
    world.ecs.entity_mut(entity).insert(Light { intensity: f32::NAN, ..Default::default() });
    let error = save_scene(&world, &folder.path("street.scene.ron")).unwrap_err();
    assert!(error.message.contains("`Code`, light, intensity"), "{error}");
}

#[test]
fn particles_of_a_prefab_are_overridden_and_taken_away() {
    let scene = r#"(entities: [(name: "A", prefab: "fire.prefab.ron"), (name: "B", prefab: "fire.prefab.ron")])"#;
    let fire = r#"Prefab(entities: [(name: "Sparks", particles: (rate: 9))])"#;
    let folder = Folder::new(&[("fire.prefab.ron", fire), ("s.scene.ron", scene)]);
    let mut world = folder.load("s.scene.ron").unwrap();
    let [a, b] = ["A/Sparks", "B/Sparks"].map(|path| at(&world, path).unwrap());
    world.ecs.get_mut::<Particles>(a).unwrap().seed = 4;
    world.ecs.entity_mut(b).remove::<Particles>();
    save_scene(&world, &folder.path("s.scene.ron")).unwrap();
    let text = folder.read("s.scene.ron");
    assert!(text.contains(r#"overrides: {"Sparks": (particles: (rate: 9, seed: 4))}"#), "{text}");
    assert!(text.contains(r#"overrides: {"Sparks": (without: [Particles])}"#), "{text}");
    let again = folder.load("s.scene.ron").unwrap();
    let seed = |path| again.ecs.get::<Particles>(at(&again, path).unwrap()).map(|particles| particles.seed);
    assert_eq!((seed("A/Sparks"), seed("B/Sparks")), (Some(4), None));
}

#[test]
fn a_prefab_opens_as_a_scene_that_frames_and_lights_it() {
    let pole = PAIR.replace("(entities", "Prefab(entities");
    let box_only = r#"Prefab(entities: [(name: "Box", mesh: Box(size: (2, 2, 2)))])"#;
    let folder = Folder::new(&[("lamp.prefab.ron", LAMP), ("pair.prefab.ron", &pole), ("BOX.Prefab.RON", box_only)]);
    let open = |name: &str| load_scene(&folder.path(name), &mut AssetLibrary::new(), &LoadOptions::default());
    let world = open("pair.prefab.ron").unwrap();
    assert_eq!(intensity(&world, "pair/Right/Pole/Bulb"), Some(5.0));
    assert!(at(&world, "framing camera").is_some() && at(&world, "light volumes").is_some());
    assert!(at(&world, "default light").is_some(), "whatever lights it has of its own");
    let mut world = open("BOX.Prefab.RON").unwrap();
    // Read anew, with what has changed.
    folder.write("BOX.Prefab.RON", box_only.replace("\"Box\"", "\"Cube\"").as_bytes());
    reenter_scene(&mut world, &mut AssetLibrary::new(), &LoadOptions::default(), &folder.path("BOX.Prefab.RON"))
        .unwrap();
    assert!(at(&world, "BOX/Cube").is_some() && at(&world, "BOX/Box").is_none());
    assert_eq!(world.roots().len(), 4, "camera, light and volumes are not doubled");
    let refused = load_scene(&folder.path("none.prefab.ron"), &mut AssetLibrary::new(), &LoadOptions::default());
    assert!(refused.err().unwrap().to_string().contains("none.prefab.ron"));
}
