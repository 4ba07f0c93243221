//! Clips, skins and morph targets in the world.

use crate::assets::{
    AlphaMode, Between, Clip, Curve, Deform, Influences, Material, Mesh, MorphTarget, NodeCurves, Shape,
};
use crate::scene::{Extractor, Scene};
use crate::world::animation::{Animation, Track, Wrap};
use crate::world::*;
use bevy_ecs::prelude::Entity;
use glam::Vec3;
use std::collections::BTreeMap;
use std::sync::Arc;

fn curve(values: &[f32], width: usize) -> Option<Curve> {
    let times = (0..values.len() / width).map(|i| i as f32).collect();
    Some(Curve { times, values: values.to_vec(), width, between: Between::Linear, is_rotation: false })
}

/// Node 1 rises by 3 m a second for 2 s, and the weight goes to 1 and back.
fn clips() -> Clips {
    let rise = NodeCurves { translation: curve(&[0., 1., 0., 0., 4., 0., 0., 7., 0.], 3), ..Default::default() };
    let swell = NodeCurves { weights: curve(&[0., 1., 0.], 1), ..Default::default() };
    let clip = |name: &str, nodes| Clip { name: name.into(), duration: 2.0, nodes };
    Clips(Arc::new(vec![clip("rise", BTreeMap::from([(1, rise)])), clip("swell", BTreeMap::from([(2, swell)]))]))
}

/// A cube whose upper vertices follow joint 1, and which swells sideways.
fn cube() -> Arc<Mesh> {
    let mut mesh = Shape::Box { size: [2.0; 3] }.mesh().unwrap();
    let mut skin = Influences::default();
    mesh.vertices.iter().for_each(|v| skin.push([(u16::from(v.position[1] > 0.0), 1.0)].into_iter()));
    let positions = mesh.vertices.iter().map(|v| [v.position[0], 0.0, 0.0]).collect();
    let targets = vec![MorphTarget { positions, ..Default::default() }];
    mesh.deform = Some(Arc::new(Deform { skin: Some(skin), targets, flat: false }));
    Arc::new(mesh)
}

struct Rig {
    world: GameWorld,
    model: Entity,
}

fn rig(tracks: Vec<Track>) -> Rig {
    let mut world = GameWorld::new();
    let model = world.spawn("model", None);
    world.ecs.entity_mut(model).insert((clips(), Animation { tracks, ..Default::default() }));
    let [low, high, body] = ["low", "high", "body"].map(|name| world.spawn(name, Some(model)));
    for (node, entity) in [(1, high), (2, body)] {
        world.ecs.entity_mut(entity).insert(ClipTarget { player: model, node });
    }
    let rest = cube();
    let posed = Posed::new(rest.clone(), Some(body)).with_skin(
        model,
        vec![low, high],
        Arc::new(vec![glam::Affine3A::IDENTITY, glam::Affine3A::from_translation(Vec3::NEG_Y)]),
    );
    world.ecs.entity_mut(high).insert(Transform { translation: Vec3::Y, ..Default::default() });
    let renderer =
        MeshRenderer { mesh: rest, material: Arc::new(Material::new("skin")), casts_shadow: true, visible: true };
    world.ecs.entity_mut(body).insert((MorphWeights(vec![0.0]), posed, renderer));
    Rig { world, model }
}

fn play(name: &str) -> Track {
    Track::Clip { name: name.into(), speed: 1.0, offset: 0.0, wrap: Wrap::Loop }
}

fn mesh_of(world: &GameWorld, path: &str) -> Arc<Mesh> {
    let entity = world.find(path).unwrap();
    world.ecs.get::<MeshRenderer>(entity).unwrap().mesh.clone()
}

fn positions(world: &GameWorld, path: &str) -> Vec<u32> {
    mesh_of(world, path).vertices.iter().flat_map(|v| v.position).map(f32::to_bits).collect()
}

#[test]
fn clips_move_joints_and_weights_and_the_mesh_follows() {
    let mut rig = rig(vec![play("rise"), play("swell")]);
    rig.world.set_seconds(0.5);
    rig.world.update();
    // The lid has risen by 1.5 m, and half the swelling is there.
    let bounds = mesh_of(&rig.world, "model/body").bounds;
    assert!((bounds.max - Vec3::new(1.5, 2.5, 1.0)).length() < 1e-5, "{bounds:?}");
    assert!((bounds.min - Vec3::new(-1.5, -1.0, -1.0)).length() < 1e-5, "{bounds:?}");
}

/// Clips and keyed tracks on joints and weights, in all the ways they may run.
fn ways() -> impl Iterator<Item = (f64, f64, Wrap)> {
    let speeds = [1.0, -1.3, 0.37, 2.0, 0.0];
    let offsets = [0.0, 0.61, -7.3];
    speeds.into_iter().flat_map(move |speed| {
        offsets.into_iter().flat_map(move |offset| {
            [Wrap::Once, Wrap::Loop, Wrap::PingPong].into_iter().map(move |wrap| (speed, offset, wrap))
        })
    })
}

fn rig_in_motion(speed: f64, offset: f64, wrap: Wrap) -> Rig {
    use crate::world::animation::{Interpolation, KeyValue, Target};
    let keys = |node: &str, target, values: [KeyValue; 3]| Track::Keys {
        node: node.into(),
        target,
        keys: [0.0, 0.45, 1.3].into_iter().zip(values).collect(),
        interpolation: Interpolation::Cubic,
        wrap,
    };
    let turn = |y| KeyValue::Vector(Vec3::new(0.0, y, 10.0));
    let tracks = vec![
        Track::Clip { name: "rise".into(), speed, offset, wrap },
        Track::Clip { name: "swell".into(), speed: 0.7, offset: 0.1, wrap },
        keys("low", Target::Rotation, [turn(0.0), turn(80.0), turn(-30.0)]),
        keys("body", Target::MorphWeight(0), [0.0, 1.0, 0.2].map(KeyValue::Scalar)),
    ];
    let mut rig = rig(tracks);
    let mut animation = rig.world.ecs.get_mut::<Animation>(rig.model).unwrap();
    (animation.speed, animation.offset) = (speed, offset);
    rig
}

#[test]
fn a_pose_is_the_same_however_it_is_reached() {
    for (speed, offset, wrap) in ways() {
        let rigs = || rig_in_motion(speed, offset, wrap);
        let mut stepped = rigs();
        for _ in 0..37 {
            stepped.world.advance(1);
            stepped.world.update();
        }
        let expected = positions(&stepped.world, "model/body");
        let mut jumped = rigs();
        jumped.world.set_tick(37);
        jumped.world.update();
        assert_eq!(positions(&jumped.world, "model/body"), expected, "speed {speed}, offset {offset}, {wrap:?}");
        // From the future, between frames, and past a pause.
        for ticks in [&[900_u64, 37][..], &[37, 36, 38, 37], &[1, 5, 37]] {
            let mut other = rigs();
            for tick in ticks {
                other.world.set_seconds(*tick as f64 / 30.0 - 0.01);
                other.world.update();
                other.world.ecs.get_mut::<Animation>(other.model).unwrap().playing = false;
                other.world.update();
                other.world.ecs.get_mut::<Animation>(other.model).unwrap().playing = true;
                other.world.set_tick(*tick);
                other.world.update();
            }
            assert_eq!(positions(&other.world, "model/body"), expected, "speed {speed}, {wrap:?}, by {ticks:?}");
        }
    }
}

#[test]
fn a_round_of_a_clip_later_all_is_the_same_again() {
    let mut rig = rig(vec![play("rise"), play("swell")]);
    rig.world.set_tick(37);
    rig.world.update();
    let expected = positions(&rig.world, "model/body");
    rig.world.set_tick(37 + 5 * 60);
    rig.world.update();
    assert_eq!(positions(&rig.world, "model/body"), expected);
}

#[test]
fn a_pose_that_does_not_change_costs_nothing() {
    let mut rig = rig(vec![play("rise")]);
    rig.world.set_seconds(0.7);
    let (mut extractor, mut scene) = (Extractor::new(), Scene::default());
    rig.world.update();
    extractor.extract(&mut rig.world, &mut scene);
    let (mesh, revisions) = (scene.primitives[0].mesh.clone(), scene.revisions);
    rig.world.update();
    extractor.extract(&mut rig.world, &mut scene);
    assert_eq!(scene.revisions, revisions);
    // The model as a whole moves, and its pose stays.
    rig.world.ecs.entity_mut(rig.model).insert(Transform { translation: Vec3::X, ..Default::default() });
    rig.world.update();
    extractor.extract(&mut rig.world, &mut scene);
    assert!(Arc::ptr_eq(&scene.primitives[0].mesh, &mesh) && scene.revisions.geometry > revisions.geometry);
    let bounds = scene.primitives[0].bounds;
    rig.world.set_seconds(1.0);
    rig.world.update();
    extractor.extract(&mut rig.world, &mut scene);
    assert!(!Arc::ptr_eq(&scene.primitives[0].mesh, &mesh) && scene.primitives[0].bounds.max.y > bounds.max.y + 0.5);
    assert_eq!(scene.primitives[0].mesh.topology(), mesh.topology());
}

#[test]
fn a_clone_plays_its_own_clip() {
    let mut rig = rig(vec![play("rise")]);
    let clone = rig.world.clone_subtree(rig.model).unwrap();
    let slow = Track::Clip { name: "rise".into(), speed: 0.5, offset: 0.0, wrap: Wrap::Once };
    rig.world.ecs.entity_mut(clone).insert(Animation { tracks: vec![slow], ..Default::default() });
    rig.world.set_seconds(1.0);
    rig.world.update();
    let tops = ["model/body", "model 2/body"].map(|path| mesh_of(&rig.world, path).bounds.max.y);
    assert!((tops[0] - 4.0).abs() < 1e-5 && (tops[1] - 2.5).abs() < 1e-5, "{tops:?}");
    rig.world.ecs.entity_mut(clone).remove::<Animation>();
    rig.world.update();
    assert!((mesh_of(&rig.world, "model 2/body").bounds.max.y - 1.0).abs() < 1e-5);
}

#[test]
fn a_lost_joint_leaves_the_rest_in_place() {
    let mut rig = rig(vec![play("rise")]);
    let high = rig.world.find("model/high").unwrap();
    rig.world.despawn_later(high);
    rig.world.set_seconds(1.0);
    for _ in 0..2 {
        rig.world.update();
    }
    let bounds = mesh_of(&rig.world, "model/body").bounds;
    assert!(bounds.min.is_finite() && bounds.max.is_finite() && bounds.max.y == 0.0, "{bounds:?}");
}

#[test]
fn every_field_of_lights_and_materials_can_be_keyed() {
    use crate::world::animation::{Interpolation, KeyValue, Target};
    let key = |target, value| Track::Keys {
        node: String::new(),
        target,
        keys: vec![(0.0, value), (1.0, value)],
        interpolation: Interpolation::Linear,
        wrap: Wrap::Loop,
    };
    let number = KeyValue::Scalar;
    let tracks = vec![
        key(Target::LightRange, number(7.0)),
        key(Target::LightInner, number(10.0)),
        key(Target::LightOuter, number(25.0)),
        key(Target::MaterialColor, KeyValue::Vector(Vec3::new(0.1, 0.2, 0.3))),
        key(Target::MaterialAlpha, number(0.5)),
        key(Target::MaterialMetallic, number(0.25)),
        key(Target::MaterialRoughness, number(2.0)),
        key(Target::Visible, number(0.4)),
        key(Target::Field("casts_shadow".into()), KeyValue::Flag(false)),
        key(Target::Field("material.specular".into()), number(0.25)),
        key(Target::Field("material.specular_color".into()), KeyValue::Vector(Vec3::X)),
        key(Target::Field("material.normal_scale".into()), number(2.0)),
        key(Target::Field("material.alpha_mode.0".into()), number(0.75)),
        key(Target::Field("material.double_sided".into()), KeyValue::Flag(true)),
        key(Target::Field("material.clearcoat.factor".into()), number(1.5)),
        key(Target::Field("material.clearcoat.roughness".into()), number(0.25)),
        key(Target::Field("material.sheen.color".into()), KeyValue::Vector(Vec3::new(0.5, 2.0, -1.0))),
        key(Target::Field("material.sheen.roughness".into()), number(0.5)),
        key(Target::Field("material.anisotropy.strength".into()), number(0.75)),
        key(Target::Field("material.anisotropy.rotation".into()), number(180.0)),
        key(Target::Field("material.iridescence.factor".into()), number(0.125)),
        key(Target::Field("material.iridescence.thickness".into()), number(250.0)),
        key(Target::Field("material.dispersion".into()), number(-2.0)),
    ];
    let mut world = GameWorld::new();
    let entity = world.spawn("lamp", None);
    let light = Light { kind: LightKind::Spot { inner: 20.0, outer: 30.0 }, ..Default::default() };
    let mesh = Arc::new(Shape::Box { size: [1.0; 3] }.mesh().unwrap());
    let own = Arc::new(Material { alpha_mode: AlphaMode::Mask(0.5), ..Material::new("own") });
    let renderer = MeshRenderer { mesh, material: own.clone(), casts_shadow: true, visible: true };
    world.ecs.entity_mut(entity).insert((light.clone(), renderer, Animation { tracks, ..Default::default() }));
    world.update();
    let now = world.ecs.get::<Light>(entity).unwrap().clone();
    assert_eq!((now.range, now.kind), (Some(7.0), LightKind::Spot { inner: 10.0, outer: 25.0 }));
    let drawn = world.ecs.get::<MeshRenderer>(entity).unwrap().clone();
    let m = &drawn.material;
    assert_eq!((m.base_color.to_array(), m.metallic, m.roughness), ([0.1, 0.2, 0.3, 0.5], 0.25, 1.0));
    assert_eq!((m.specular, m.specular_color, m.normal_scale), (0.25, Vec3::X, 2.0));
    assert!(m.alpha_mode == AlphaMode::Mask(0.75) && m.double_sided);
    assert_eq!((m.clearcoat.factor, m.clearcoat.roughness), (1.0, 0.25));
    assert_eq!((m.sheen.color, m.sheen.roughness), (Vec3::new(0.5, 1.0, 0.0), 0.5));
    assert_eq!((m.anisotropy.strength, m.anisotropy.rotation), (0.75, std::f32::consts::PI));
    assert_eq!((m.iridescence.factor, m.iridescence.thickness, m.dispersion), (0.125, 250.0, 0.0));
    assert!(!drawn.visible && world.rest_visible(entity) == Some(true));
    assert!(!drawn.casts_shadow && world.rest_casts_shadow(entity) == Some(true));
    assert_eq!(
        (world.rest_light(entity), world.rest_material(entity).map(|m| m.id)),
        (Some(light.clone()), Some(own.id))
    );
    world.ecs.entity_mut(entity).remove::<Animation>();
    world.update();
    let drawn = world.ecs.get::<MeshRenderer>(entity).unwrap();
    assert!(drawn.visible && drawn.casts_shadow && Arc::ptr_eq(&drawn.material, &own));
    assert_eq!(world.ecs.get::<Light>(entity), Some(&light));
}
