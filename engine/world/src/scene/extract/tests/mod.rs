//! Tests of the extraction: what is new after which change.
#![allow(clippy::unwrap_used)]

mod media;
mod moving;
mod particles;
mod ranges;
mod sky;

use super::Extractor;
use crate::assets::{Material, Mesh, Vertex};
use crate::scene::{LightShape, Revisions, Scene, SceneId, ViewProjection};
use crate::world::animation::{Animation, Track};
use crate::world::*;
use bevy_ecs::prelude::{Bundle, Component, Entity};
use glam::{Quat, Vec2, Vec3};
use std::sync::Arc;

fn mesh() -> Arc<Mesh> {
    let at = |position| Vertex { position, normal: [0.0, 1.0, 0.0], tangent: [1.0, 0.0, 0.0, 1.0], uv: [0.0; 2] };
    let vertices = vec![at([0.0; 3]), at([0.0, 0.0, 1.0]), at([1.0, 0.0, 0.0])];
    Arc::new(Mesh::new("triangle", vertices, vec![0, 1, 2]))
}

fn renderer() -> MeshRenderer {
    MeshRenderer { mesh: mesh(), material: Arc::new(Material::new("white")), casts_shadow: true, visible: true }
}

/// A world with one of everything, what was extracted from it, and the means to do that again.
struct Stage {
    world: GameWorld,
    extractor: Extractor,
    scene: Scene,
    group: Entity,
    thing: Entity,
    lamp: Entity,
    eye: Entity,
    volume: Entity,
}

impl Stage {
    fn new() -> Self {
        let mut world = GameWorld::new();
        let group = world.spawn("group", None);
        let thing = world.spawn("thing", Some(group));
        world.ecs.entity_mut(thing).insert(renderer());
        let lamp = world.spawn("lamp", None);
        world.ecs.entity_mut(lamp).insert(Light::default());
        let eye = world.spawn("eye", None);
        world.ecs.entity_mut(eye).insert(Camera::default());
        let volume = world.spawn("volume", None);
        world.ecs.entity_mut(volume).insert(Clpv::default());
        let (extractor, scene) = (Extractor::new(), Scene::default());
        let mut stage = Self { world, extractor, scene, group, thing, lamp, eye, volume };
        stage.frame();
        stage
    }

    fn frame(&mut self) -> Revisions {
        self.world.update();
        self.extractor.extract(&mut self.world, &mut self.scene);
        self.scene.revisions
    }

    /// Changes a component and runs a frame; which revisions are new: geometry, materials, lights, cameras, clpv,
    /// settings.
    fn changes(&mut self, edit: impl FnOnce(&mut Self)) -> [bool; 6] {
        let before = list(self.scene.revisions);
        edit(self);
        let after = list(self.frame());
        std::array::from_fn(|i| after[i] != before[i])
    }

    fn insert(&mut self, entity: Entity, component: impl Bundle) {
        self.world.ecs.entity_mut(entity).insert(component);
    }

    fn remove<C: Component>(&mut self, entity: Entity) {
        self.world.ecs.entity_mut(entity).remove::<C>();
    }

    fn light(&mut self, light: Light) -> crate::scene::SceneLight {
        self.world.ecs.entity_mut(self.lamp).insert(light);
        self.frame();
        self.scene.lights[0].clone()
    }
}

fn list(r: Revisions) -> [u64; 6] {
    [r.geometry, r.materials, r.lights, r.cameras, r.clpv, r.settings]
}

const NOTHING: [bool; 6] = [false; 6];
const GEOMETRY: [bool; 6] = [true, false, false, false, false, false];
const MATERIALS: [bool; 6] = [false, true, false, false, false, false];
const LIGHTS: [bool; 6] = [false, false, true, false, false, false];
const CAMERAS: [bool; 6] = [false, false, false, true, false, false];
const CLPV: [bool; 6] = [false, false, false, false, true, false];
const SETTINGS: [bool; 6] = [false, false, false, false, false, true];

#[test]
fn the_first_frame_takes_everything() {
    let stage = Stage::new();
    let scene = &stage.scene;
    assert_eq!((scene.primitives.len(), scene.lights.len(), scene.cameras.len()), (1, 1, 1));
    assert_eq!(scene.clpv.as_ref().unwrap().settings, Clpv::default());
    assert!(list(scene.revisions).iter().all(|r| *r > 0), "{:?}", scene.revisions);
    assert_eq!((scene.lights[0].name.as_str(), scene.cameras[0].name.as_str()), ("lamp", "eye"));
    assert_ne!(Extractor::new().identity, scene.identity);
}

#[test]
fn nothing_changed_costs_nothing() {
    let mut stage = Stage::new();
    let array = stage.scene.primitives.as_ptr();
    for _ in 0..5 {
        assert_eq!(stage.changes(|_| {}), NOTHING);
    }
    // Written, but the same.
    let same = stage.changes(|s| {
        let place = *s.world.ecs.get::<Transform>(s.thing).unwrap();
        s.insert(s.thing, place);
        s.world.ecs.get_mut::<MeshRenderer>(s.thing).unwrap().visible = true;
        s.insert(s.lamp, Light::default());
        s.insert(s.eye, Camera::default());
        s.insert(s.volume, Clpv::default());
        s.world.ecs.insert_resource(SceneSettings { exposure: 3.0, ..SceneSettings::default() });
    });
    assert_eq!((same, stage.scene.primitives.as_ptr()), (NOTHING, array));
}

#[test]
fn each_change_takes_its_own_revision_only() {
    let mut s = Stage::new();
    let place = Transform { translation: Vec3::X, ..Transform::default() };
    assert_eq!(s.changes(|s| s.insert(s.thing, place)), GEOMETRY);
    assert_eq!(s.changes(|s| s.world.ecs.get_mut::<MeshRenderer>(s.thing).unwrap().mesh = mesh()), GEOMETRY);
    assert_eq!(s.changes(|s| s.world.ecs.get_mut::<MeshRenderer>(s.thing).unwrap().casts_shadow = false), GEOMETRY);
    let geometry = s.scene.primitives[0].geometry_revision;
    let red = Arc::new(Material::diffuse("red", Vec3::X));
    assert_eq!(s.changes(|s| s.world.ecs.get_mut::<MeshRenderer>(s.thing).unwrap().material = red), MATERIALS);
    assert_eq!(s.scene.primitives[0].geometry_revision, geometry);
    assert_eq!(s.scene.primitives[0].material.name, "red");
    assert_eq!(s.changes(|s| s.insert(s.lamp, place)), LIGHTS);
    assert_eq!(s.changes(|s| s.world.ecs.get_mut::<Light>(s.lamp).unwrap().intensity = 2.0), LIGHTS);
    assert_eq!(s.changes(|s| s.insert(s.lamp, Name("new".into()))), NOTHING);
    assert_eq!(s.scene.lights[0].name, "new");
    assert_eq!(s.changes(|s| s.world.ecs.get_mut::<Camera>(s.eye).unwrap().fov = 30.0), CAMERAS);
    assert_eq!(s.changes(|s| s.insert(s.eye, place)), CAMERAS);
    assert_eq!(s.changes(|s| s.world.ecs.get_mut::<Clpv>(s.volume).unwrap().steps = 3), CLPV);
    assert_eq!(s.changes(|s| s.insert(s.volume, place)), CLPV);
    assert_eq!(s.changes(|s| s.world.ecs.resource_mut::<SceneSettings>().sky = Vec3::ONE), SETTINGS);
    assert_eq!(s.scene.sky, Vec3::ONE);
}

#[test]
fn a_parent_takes_its_children_along() {
    let mut s = Stage::new();
    assert_eq!(s.changes(|s| s.world.ecs.get_mut::<Transform>(s.group).unwrap().translation = Vec3::Y), GEOMETRY);
    assert_eq!(Vec3::from(s.scene.primitives[0].world_from_object.translation), Vec3::Y);
    assert_eq!(s.scene.primitives[0].bounds.min, Vec3::Y);
}

#[test]
fn what_is_removed_hidden_or_despawned_leaves_and_comes_back() {
    let mut s = Stage::new();
    assert_eq!(s.changes(|s| s.world.ecs.get_mut::<MeshRenderer>(s.thing).unwrap().visible = false), GEOMETRY);
    assert!(s.scene.primitives.is_empty());
    s.changes(|s| s.world.ecs.get_mut::<MeshRenderer>(s.thing).unwrap().visible = true);
    assert_eq!(s.scene.primitives.len(), 1);
    assert_eq!(s.changes(|s| s.remove::<MeshRenderer>(s.thing)), GEOMETRY);
    assert!(s.scene.primitives.is_empty());
    assert_eq!(s.changes(|s| s.remove::<Light>(s.lamp)), LIGHTS);
    assert_eq!(s.changes(|s| s.world.despawn_later(s.eye)), CAMERAS);
    assert_eq!(s.changes(|s| assert!(s.world.ecs.despawn(s.volume))), CLPV);
    assert!(s.scene.lights.is_empty() && s.scene.cameras.is_empty() && s.scene.clpv.is_none());
    s.changes(|s| s.insert(s.lamp, Light::default()));
    assert_eq!(s.scene.lights.len(), 1);
}

#[test]
fn removed_and_added_again_in_one_frame_stays() {
    let mut s = Stage::new();
    let same = s.changes(|s| {
        let renderer = s.world.ecs.entity_mut(s.thing).take::<MeshRenderer>().unwrap();
        s.insert(s.thing, renderer);
        let light = s.world.ecs.entity_mut(s.lamp).take::<Light>().unwrap();
        s.insert(s.lamp, light);
        let camera = s.world.ecs.entity_mut(s.eye).take::<Camera>().unwrap();
        s.insert(s.eye, camera);
        let clpv = s.world.ecs.entity_mut(s.volume).take::<Clpv>().unwrap();
        s.insert(s.volume, clpv);
    });
    assert_eq!((same, s.scene.primitives.len(), s.scene.lights.len()), (NOTHING, 1, 1));
    let other = s.changes(|s| {
        s.world.ecs.entity_mut(s.thing).remove::<MeshRenderer>();
        s.insert(s.thing, renderer());
    });
    assert_eq!((other, s.scene.primitives.len()), ([true, true, false, false, false, false], 1));
    // Despawned, and another of the same identity in its place.
    let id = s.world.id(s.lamp).unwrap();
    s.changes(|s| {
        s.world.ecs.despawn(s.lamp);
        s.lamp = s.world.spawn_with_id("lamp", None, id).unwrap();
        s.insert(s.lamp, Light { intensity: 5.0, ..Light::default() });
    });
    assert_eq!((s.scene.lights.len(), s.scene.lights[0].intensity, s.scene.lights[0].id), (1, Vec3::splat(5.0), id));
}

#[test]
fn removals_are_noticed_though_updates_passed_without_extraction() {
    let mut s = Stage::new();
    s.world.ecs.despawn(s.thing);
    s.world.ecs.entity_mut(s.lamp).remove::<Light>();
    s.world.ecs.entity_mut(s.volume).remove::<Clpv>();
    for _ in 0..4 {
        s.world.update();
    }
    s.frame();
    assert!(s.scene.primitives.is_empty() && s.scene.lights.is_empty() && s.scene.clpv.is_none());
    assert_eq!(s.changes(|_| {}), NOTHING);
}

#[test]
fn order_follows_identity_whatever_the_order_of_spawning() {
    let extract = |order: [u64; 4]| {
        let mut world = GameWorld::new();
        let (mut extractor, mut scene) = (Extractor::new(), Scene::default());
        for id in order {
            let entity = world.spawn_with_id(&id.to_string(), None, SceneId(id)).unwrap();
            world.ecs.entity_mut(entity).insert((renderer(), Light { intensity: id as f32, ..Light::default() }));
            world.update();
            extractor.extract(&mut world, &mut scene);
        }
        let ids: Vec<u64> = scene.primitives.iter().map(|p| p.id.0).collect();
        (ids, scene.lights.iter().map(|l| l.intensity.x).collect::<Vec<f32>>())
    };
    let expected = (vec![1, 3, 5, 9], vec![1.0, 3.0, 5.0, 9.0]);
    for order in [[1, 3, 5, 9], [9, 5, 3, 1], [5, 1, 9, 3]] {
        assert_eq!(extract(order), expected, "{order:?}");
    }
}

#[test]
fn another_scene_or_world_starts_anew() {
    let mut s = Stage::new();
    let identity = s.scene.identity;
    s.scene = Scene::default();
    s.frame();
    assert_eq!((s.scene.primitives.len(), s.scene.lights.len()), (1, 1));
    assert_ne!(s.scene.identity, identity);
    s.world = GameWorld::new();
    s.frame();
    assert!(s.scene.primitives.is_empty() && s.scene.lights.is_empty() && s.scene.clpv.is_none());
}

#[test]
fn places_that_are_not_finite_are_left_out() {
    let mut s = Stage::new();
    for entity in [s.group, s.lamp, s.eye, s.volume] {
        let lost = Transform { translation: Vec3::NAN, ..Transform::default() };
        s.insert(entity, lost);
    }
    s.frame();
    assert!(s.scene.primitives.is_empty() && s.scene.lights.is_empty());
    assert!(s.scene.cameras.is_empty() && s.scene.clpv.is_none());
    assert_eq!(s.changes(|_| {}), NOTHING);
    for entity in [s.group, s.lamp, s.eye, s.volume] {
        s.insert(entity, Transform::default());
    }
    s.frame();
    assert_eq!((s.scene.primitives.len(), s.scene.lights.len(), s.scene.cameras.len()), (1, 1, 1));
    // Singular and mirrored places are fine.
    for scale in [Vec3::ZERO, Vec3::new(1.0, 0.0, -1.0)] {
        s.insert(s.thing, Transform { scale, ..Transform::default() });
        s.frame();
        assert_eq!(s.scene.primitives.len(), 1);
    }
}

#[test]
fn warnings_stand_as_long_as_they_hold() {
    let mut s = Stage::new();
    assert!(s.scene.warnings.is_empty(), "{:?}", s.scene.warnings);
    assert_eq!(s.scene.settings_names.clpv, "volume");
    let (lamp, volume) = (s.lamp, s.volume);
    s.world.ecs.entity_mut(lamp).insert(Light { rsm_size: 8192, ..Light::default() });
    s.world.ecs.entity_mut(volume).insert(Clpv { cascades: 9, ..Clpv::default() });
    s.world.ecs.insert_resource(SceneSettings { sky: Vec3::NEG_ONE, ..SceneSettings::default() });
    s.frame();
    let told = s.scene.warnings.join("\n");
    for part in ["`lamp`: is a light with another map size", "1..=4096", "`volume`: has volume settings", "the sky"] {
        assert!(told.contains(part), "{part} in {told}");
    }
    s.frame();
    assert_eq!(s.scene.warnings.join("\n"), told, "they stand while nothing changes");
    s.world.ecs.entity_mut(lamp).insert(Light::default());
    s.frame();
    assert_eq!(s.scene.warnings.len(), 2, "{:?}", s.scene.warnings);
    s.world.ecs.entity_mut(volume).remove::<Clpv>();
    s.world.ecs.insert_resource(SceneSettings::default());
    s.frame();
    assert!(s.scene.warnings.is_empty(), "{:?}", s.scene.warnings);
    assert_eq!(s.scene.settings_names.clpv, "");
}
