//! Tracks of keys for entities below the animated one: nodes of its model and parts of its prefab.

use super::*;
use crate::assets::rig_tests::rigged;
use crate::world::animation::Track;
use crate::world::{Animation, MeshRenderer, MorphWeights, Transform};
use glam::Vec3;

fn folder(scene: &str) -> Folder {
    let folder = Folder::new(&[("s.scene.ron", scene)]);
    let (file, rest) = rigged();
    folder.write("rig.glb", &file.glb(&rest));
    folder
}

fn transform(world: &GameWorld, path: &str) -> Transform {
    *world.ecs.get::<Transform>(at(world, path).unwrap()).unwrap()
}

fn weight(world: &GameWorld, path: &str) -> f32 {
    world.ecs.get::<MorphWeights>(at(world, path).unwrap()).unwrap().0[0]
}

const MODEL: &str = r#"(entities: [(name: "M", model: "rig.glb", animation: (tracks: [
    Clip(name: "walk"),
    Keys(node: "knee", target: Translation, keys: [(0, (0, 0, 1)), (2, (0, 4, 1))], wrap: Once),
    Keys(node: "rigid", target: MorphWeight(0), keys: [(0, 0), (2, 1)], wrap: PingPong),
    Keys(target: Translation, keys: [(0, (0, 0, 0)), (2, (8, 0, 0))]),
]))])"#;

#[test]
fn tracks_move_nodes_and_weights_of_a_model() {
    let folder = folder(MODEL);
    let mut world = folder.load("s.scene.ron").unwrap();
    world.set_seconds(0.5);
    world.update();
    // The clip moves the hip, the track the knee below it, and the entity itself goes its way.
    assert_eq!(transform(&world, "M/hip").translation, Vec3::X);
    assert_eq!(transform(&world, "M/hip/knee").translation, Vec3::new(0.0, 1.0, 1.0));
    assert_eq!((weight(&world, "M/rigid"), transform(&world, "M").translation), (0.25, Vec3::X * 2.0));
    let skin = world.ecs.get::<MeshRenderer>(at(&world, "M/skinned skin").unwrap()).unwrap();
    assert_eq!(skin.mesh.vertices[1].position, [2.0, 1.0, 1.5], "the skin follows the knee");
    // Saved and loaded again it plays the same; nothing of what moved is in the file.
    save_scene(&world, &folder.path("again.scene.ron")).unwrap();
    let text = folder.read("again.scene.ron");
    assert!(text.contains("node: \"knee\"") && text.contains("MorphWeight(0)") && !text.contains("hip"), "{text}");
    let mut again = folder.load("again.scene.ron").unwrap();
    again.set_seconds(3.0);
    again.update();
    world.set_seconds(3.0);
    world.update();
    assert_eq!(transform(&again, "M/hip/knee"), transform(&world, "M/hip/knee"));
    assert_eq!((weight(&again, "M/rigid"), weight(&world, "M/rigid")), (0.5, 0.5));
}

#[test]
fn names_of_several_need_a_path_and_the_outermost_has_the_last_word() {
    let scene = |node: &str| {
        let outer = format!("Keys(node: \"{node}\", target: Translation, keys: [(0, (0, 9, 0))])");
        let inner = "Keys(node: \"knee\", target: Translation, keys: [(0, (1, 1, 1))]), \
                     Keys(node: \"hip\", target: Translation, keys: [(0, (2, 2, 2))])";
        folder(&format!(
            "(entities: [(name: \"M\", model: \"rig.glb\", animation: (tracks: [{outer}]), children: [\
             (name: \"N\", model: \"rig.glb\", animation: (tracks: [{inner}]))])])"
        ))
    };
    let error = scene("knee").load("s.scene.ron").err().unwrap().to_string();
    assert!(error.contains("2 entities below `M` are named `knee`") && error.contains("such as `hip/knee`"), "{error}");
    let folder = scene("N/hip/knee");
    let mut world = folder.load("s.scene.ron").unwrap();
    world.update();
    let [mine, hip, knee] = ["M/hip/knee", "M/N/hip", "M/N/hip/knee"].map(|path| transform(&world, path).translation);
    assert_eq!((mine, hip, knee), (Vec3::Z, Vec3::splat(2.0), Vec3::Y * 9.0));
}

#[test]
fn a_path_reaches_through_models_and_prefabs() {
    let scene = r#"(entities: [
        (name: "A", model: "rig.glb", animation: (tracks: [
            Keys(node: "hip", target: Translation, keys: [(0, (5, 5, 5))]),
            Clip(name: "walk"),
            Keys(node: "rigid", target: MorphWeight(0), keys: [(0, 0.75)])])),
        (name: "B", prefab: "p.prefab.ron", animation: (tracks: [
            Keys(node: "Lamp/Bulb", target: LightIntensity, keys: [(0, 1), (2, 3)]),
            Keys(node: "Bulb", target: Visible, keys: [(0, 0)])])),
    ])"#;
    let folder = folder(scene);
    let prefab = r#"(entities: [(name: "Lamp", children: [(name: "Bulb", mesh: Sphere(radius: 1), light: (kind: Point, intensity: 7))])])"#;
    folder.write("p.prefab.ron", prefab.as_bytes());
    let mut world = folder.load("s.scene.ron").unwrap();
    world.set_seconds(1.0);
    world.update();
    // The clip comes after the first track, and before the last.
    assert_eq!((transform(&world, "A/hip").translation, weight(&world, "A/rigid")), (Vec3::X * 2.0, 0.75));
    let bulb = at(&world, "B/Lamp/Bulb").unwrap();
    assert_eq!(world.ecs.get::<crate::world::Light>(bulb).unwrap().intensity, 2.0);
    assert!(!world.ecs.get::<MeshRenderer>(bulb).unwrap().visible);
    // Without the tracks it is as it was.
    let animation = world.ecs.get::<Animation>(at(&world, "B").unwrap()).unwrap().clone();
    world.ecs.entity_mut(at(&world, "B").unwrap()).remove::<Animation>();
    world.update();
    assert_eq!(world.ecs.get::<crate::world::Light>(bulb).unwrap().intensity, 7.0);
    assert!(world.ecs.get::<MeshRenderer>(bulb).unwrap().visible);
    // A clone plays the tracks on its own parts.
    world.ecs.entity_mut(at(&world, "B").unwrap()).insert(animation);
    world.update();
    let clone = world.clone_subtree(at(&world, "B").unwrap()).unwrap();
    world.update();
    let cloned = world.below(clone, "Bulb").unwrap();
    assert_eq!(world.ecs.get::<crate::world::Light>(cloned).unwrap().intensity, 2.0);
    assert_eq!(world.rest_light(cloned).unwrap().intensity, 7.0);
}

#[test]
fn what_is_not_there_is_named() {
    let model = |track: &str| format!(r#"(entities: [(name: "M", model: "rig.glb", animation: (tracks: [{track}]))])"#);
    for (track, words) in [
        ("Keys(node: \"kneee\", target: Visible, keys: [(0, 1)])", ["no `kneee` below `M`", "did you mean `knee`"]),
        ("Keys(node: \"hip/kne\", target: Visible, keys: [(0, 1)])", ["`hip/kne`", "did you mean `hip/knee`"]),
        ("Keys(node: \"tail\", target: Visible, keys: [(0, 1)])", ["`tail`", "known here: `hip`"]),
        ("Keys(node: \"rigid\", target: MorphWeight(1), keys: [(0, 1)])", ["one morph target", "MorphWeight(0)"]),
        ("Keys(node: \"hip\", target: MorphWeight(0), keys: [(0, 1)])", ["no morph targets", "node"]),
        ("Keys(target: MorphWeight(0), keys: [(0, 1)])", ["`M` has no morph targets", "name the node"]),
        ("Keys(node: \"rigid\", target: MorphWeight(99999), keys: [(0, 1)])", ["MorphWeight is 99999", "65535"]),
    ] {
        let message = folder(&model(track)).load("s.scene.ron").err().unwrap().to_string();
        assert!(words.iter().all(|word| message.contains(word)), "{words:?}: {message}");
    }
    let place = folder(&model(
        "Spin(axis: (0, 1, 0), degrees_per_second: 9),\n Keys(target: Visible, keys: [(0, 1)], node: \"kneee\")",
    ));
    let message = place.load("s.scene.ron").err().unwrap().to_string();
    assert!(message.contains("s.scene.ron:2:"), "the place of the track: {message}");
}

#[test]
fn tracks_survive_being_read_and_written() {
    let folder = folder(MODEL);
    let world = folder.load("s.scene.ron").unwrap();
    let tracks = &world.ecs.get::<Animation>(at(&world, "M").unwrap()).unwrap().tracks;
    let text = ::ron::to_string(tracks).unwrap();
    assert_eq!(&::ron::from_str::<Vec<Track>>(&text).unwrap(), tracks);
    // A track for the entity itself names no node.
    assert_eq!(text.matches("node:").count(), 2, "{text}");
}
