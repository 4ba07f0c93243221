//! Models that play clips, in scenes and as scenes.

use super::*;
use crate::assets::rig_tests::rigged;
use crate::world::animation::Track;
use crate::world::{Animation, MeshRenderer, SceneSettings};

fn folder(scene: &str) -> Folder {
    let folder = Folder::new(&[("s.scene.ron", scene)]);
    let (file, rest) = rigged();
    folder.write("rig.glb", &file.glb(&rest));
    folder
}

/// How far a skinned mesh reaches to the right.
fn reach(world: &GameWorld, model: &str) -> f32 {
    let skin = at(world, &format!("{model}/skinned skin")).unwrap();
    world.ecs.get::<MeshRenderer>(skin).unwrap().mesh.bounds.max.x
}

#[test]
fn a_bare_model_plays_its_first_clip() {
    let folder = folder("()");
    let mut world = folder.load("rig.glb").unwrap();
    let model = at(&world, "rig").unwrap();
    let tracks = &world.ecs.get::<Animation>(model).unwrap().tracks;
    assert!(matches!(&tracks[..], [Track::Clip { name, .. }] if name == "walk"), "{tracks:?}");
    assert_eq!(world.ecs.resource::<SceneSettings>().duration, Some(2.0));
    // Joints say where the mesh is: the node's own place plays no part, and the hip is at 2 half-way.
    assert_eq!(reach(&world, "rig"), 1.0);
    world.set_seconds(1.0);
    world.update();
    assert_eq!(reach(&world, "rig"), 3.0);
}

#[test]
fn instances_of_a_model_play_on_their_own() {
    let folder = folder(
        r#"Scene(entities: [
            (name: "Still", model: "rig.glb"),
            (name: "Slow", model: "rig.glb", animation: (tracks: [Clip(name: "walk", speed: 0.5)])),
            (name: "Late", model: "rig.glb", animation: (tracks: [Clip(offset: 0.5, wrap: Once)])),
            (name: "A", prefab: "p.prefab.ron"),
            (name: "B", prefab: "p.prefab.ron", overrides: {"Rig": (animation: (playing: false, tracks: [Clip()]))}),
        ])"#,
    );
    let prefab = r#"Prefab(entities: [(name: "Rig", model: "rig.glb", animation: (tracks: [Clip(name: "walk", wrap: PingPong)]))])"#;
    folder.write("p.prefab.ron", prefab.as_bytes());
    let mut world = folder.load("s.scene.ron").unwrap();
    world.set_seconds(1.0);
    world.update();
    let reaches = ["Still", "Slow", "Late", "A/Rig", "B/Rig"].map(|name| reach(&world, name));
    assert_eq!(reaches, [1.0, 2.0, 4.0, 3.0, 1.0]);
    world.set_seconds(3.0);
    world.update();
    assert_eq!([reach(&world, "Late"), reach(&world, "A/Rig")], [5.0, 3.0]);
    // What is saved is what was loaded.
    save_scene(&world, &folder.path("again.scene.ron")).unwrap();
    let mut again = folder.load("again.scene.ron").unwrap();
    again.set_seconds(3.0);
    again.update();
    assert_eq!([reach(&again, "Slow"), reach(&again, "B/Rig")], [reach(&world, "Slow"), reach(&world, "B/Rig")]);
}

#[test]
fn a_part_of_a_model_brings_the_joints_that_it_follows() {
    let folder = folder(
        r#"(entities: [(name: "M", model: (path: "rig.glb", node: "skinned"), animation: (tracks: [Clip()]))])"#,
    );
    let mut world = folder.load("s.scene.ron").unwrap();
    world.set_seconds(1.0);
    world.update();
    assert_eq!(reach(&world, "M"), 3.0);
    assert!(at(&world, "M/hip/knee").is_some() && at(&world, "M/rigid").is_none());
}

#[test]
fn clips_that_are_not_there_are_named() {
    for (scene, words) in [
        (
            r#"(entities: [(name: "M", model: "rig.glb", animation: (tracks: [Clip(name: "wolk")]))])"#,
            ["`wolk`", "`walk`"],
        ),
        (r#"(entities: [(name: "M", animation: (tracks: [Clip(name: "walk")]))])"#, ["no model", "`model`"]),
        (r#"(entities: [(name: "M", model: "rig.glb", animation: (tracks: [Clip(speed: 1e9)]))])"#, ["speed", "1e6"]),
    ] {
        let message = folder(scene).load("s.scene.ron").err().unwrap().to_string();
        assert!(words.iter().all(|word| message.contains(word)), "{words:?}: {message}");
    }
}
