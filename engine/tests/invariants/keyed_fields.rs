//! Keyed fields and what is drawn: passes that depend on them run again, and no others.

#![allow(clippy::unwrap_used)]

use crate::support::gpu;
use glam::{Quat, Vec3};
use lightwell::assets::{Material, Shape, SkyMap};
use lightwell::gpu::{Gpu, ImageF32, read_texture_f32};
use lightwell::graph::PassState;
use lightwell::render::{GiMethod, RenderSettings, Renderer};
use lightwell::scene::{Extractor, Scene, SceneView};
use lightwell::world::animation::{Interpolation, KeyValue, Target, Track, Wrap};
use lightwell::world::{
    Animation, Camera, Clpv, Environment, EnvironmentImage, GameWorld, Light, MeshRenderer, Quality, SceneSettings,
    Transform,
};
use std::sync::Arc;

fn keys(path: &str, from: KeyValue, to: KeyValue) -> Track {
    Track::Keys {
        node: String::new(),
        target: Target::Field(path.into()),
        keys: vec![(0.0, from), (2.0, to)],
        interpolation: Interpolation::Linear,
        wrap: Wrap::Once,
    }
}

/// A box on a floor under a lamp and a sky, in a light volume that a track changes.
fn world(track: Track) -> GameWorld {
    let mut world = GameWorld::new();
    let mut put = |name: &str, translation: Vec3, rotation: Quat| {
        let entity = world.spawn(name, None);
        world.ecs.entity_mut(entity).insert(Transform { translation, rotation, ..Transform::default() });
        entity
    };
    let eye = put("eye", Vec3::new(0.0, 2.0, 4.0), Quat::from_rotation_x(-0.4));
    let lamp = put("lamp", Vec3::new(1.0, 3.0, 1.0), Quat::IDENTITY);
    let volume = put("volume", Vec3::Y, Quat::IDENTITY);
    let [floor, thing] = [("floor", Vec3::ZERO), ("thing", Vec3::Y)].map(|(name, at)| put(name, at, Quat::IDENTITY));
    for (entity, shape) in
        [(floor, Shape::Plane { size: [6.0; 2], subdivisions: [1; 2] }), (thing, Shape::Box { size: [1.0; 3] })]
    {
        let (mesh, material) =
            (Arc::new(shape.mesh().unwrap()), Arc::new(Material::diffuse(name(entity), Vec3::splat(0.6))));
        world.ecs.entity_mut(entity).insert(MeshRenderer { mesh, material, casts_shadow: true, visible: true });
    }
    world.ecs.entity_mut(eye).insert(Camera::default());
    world.ecs.entity_mut(lamp).insert(Light { intensity: 9.0, shadow_size: 64, rsm_size: 16, ..Light::default() });
    let clpv = Clpv { quality: Quality::Low, ..Clpv::default() };
    world.ecs.entity_mut(volume).insert((clpv, Animation { tracks: vec![track], ..Animation::default() }));
    world.set_rest_settings(SceneSettings { sky: Vec3::splat(0.2), ..SceneSettings::default() });
    world
}

fn name(entity: bevy_ecs::entity::Entity) -> String {
    entity.to_string()
}

struct Show {
    world: GameWorld,
    extractor: Extractor,
    scene: Scene,
    renderer: Renderer,
}

impl Show {
    fn new(gpu: &Gpu, world: GameWorld) -> Self {
        Self { world, extractor: Extractor::new(), scene: Scene::default(), renderer: Renderer::new(gpu) }
    }

    /// The image at a time, and the passes that ran for it.
    fn frame(&mut self, gpu: &Gpu, seconds: f64) -> (ImageF32, Vec<String>) {
        self.world.set_seconds(seconds);
        self.world.update();
        self.extractor.extract(&mut self.world, &mut self.scene);
        let view = SceneView { camera: self.scene.cameras[0].clone(), size: [48, 48], jitter: [0.0; 2] };
        let settings = RenderSettings { gi: GiMethod::CLPV, ..Default::default() };
        let report = self.renderer.render(gpu, &self.scene, &view, &settings).unwrap();
        let ran = report.passes.iter().filter(|p| p.state == PassState::Ran).map(|p| p.name.clone()).collect();
        (read_texture_f32(gpu, self.renderer.radiance().unwrap()).unwrap(), ran)
    }
}

/// Plays to a time over others, checks that the image is that of a fresh start, and gives what ran at the end.
fn played(gpu: &Gpu, make: impl Fn() -> GameWorld) -> Vec<String> {
    let mut show = Show::new(gpu, make());
    let (first, _) = show.frame(gpu, 0.0);
    assert!(show.frame(gpu, 0.0).1.is_empty(), "nothing has changed");
    let (_, ran) = show.frame(gpu, 1.0);
    show.frame(gpu, 2.0);
    let (again, _) = show.frame(gpu, 1.0);
    let (fresh, _) = Show::new(gpu, make()).frame(gpu, 1.0);
    assert_eq!(again.rgba, fresh.rgba, "the frame depends on those before it");
    assert_ne!(again.rgba, first.rgba, "the track does nothing");
    ran
}

fn assert_ran(ran: &[String], some: &[&str], none: &[&str]) {
    let began = |start: &str| ran.iter().any(|name| name.starts_with(start));
    some.iter().for_each(|start| assert!(began(start), "{start} did not run: {ran:?}"));
    none.iter().for_each(|start| assert!(!began(start), "{start} ran: {ran:?}"));
}

#[test]
fn a_keyed_sky_runs_what_depends_on_it() {
    let gpu = gpu();
    let sky = || keys("scene.sky", KeyValue::Vector(Vec3::ZERO), KeyValue::Vector(Vec3::new(1.0, 2.0, 3.0)));
    let ran = played(&gpu, || world(sky()));
    println!("sky: {ran:?}");
    assert_ran(&ran, &["sweep", "compose"], &["shadow", "rsm", "gbuffer", "direct"]);
}

#[test]
fn keyed_environments_are_made_anew_from_what_was_loaded() {
    let gpu = gpu();
    let gradient = |zenith| Environment::Gradient { zenith, horizon: Vec3::splat(0.5), ground: Vec3::ZERO };
    let track = || keys("scene.environment.zenith", KeyValue::Vector(Vec3::ZERO), KeyValue::Vector(Vec3::splat(2.0)));
    let with_gradient = || {
        let mut world = world(track());
        world.set_rest_settings(SceneSettings { environment: Some(gradient(Vec3::Z)), ..SceneSettings::default() });
        world
    };
    let ran = played(&gpu, with_gradient);
    assert_ran(&ran, &["sweep", "compose"], &["shadow", "rsm", "gbuffer", "direct"]);
    // An image is turned and brightened, and not read again.
    for (field, from, to) in [("rotation", 0.0, 180.0), ("intensity", 1.0, 5.0)] {
        let path = format!("scene.environment.{field}");
        let with_image = || {
            let mut world = world(keys(&path, KeyValue::Scalar(from), KeyValue::Scalar(to)));
            let environment = Environment::Image { file: "no such file".into(), rotation: 0.0, intensity: 2.0 };
            let map = Arc::new(SkyMap::gradient(Vec3::Z, Vec3::splat(0.5), Vec3::ZERO));
            world.ecs.insert_resource(EnvironmentImage { environment: environment.clone(), map });
            world.set_rest_settings(SceneSettings { environment: Some(environment), ..SceneSettings::default() });
            world
        };
        let mut show = Show::new(&gpu, with_image());
        show.frame(&gpu, 1.0);
        let map = show.scene.sky_map.clone().unwrap();
        let (turn, factor) = if field == "rotation" { (90_f32.to_radians(), 1.0) } else { (0.0, 1.5) };
        let base = SkyMap::gradient(Vec3::Z, Vec3::splat(0.5), Vec3::ZERO).texels[0];
        assert_eq!((map.turn, map.texels[0]), (turn, base * factor), "{field}");
        show.frame(&gpu, 1.0);
        assert!(Arc::ptr_eq(&map, show.scene.sky_map.as_ref().unwrap()), "made once");
    }
}

#[test]
fn keyed_lights_and_volumes_run_their_own_passes() {
    let gpu = gpu();
    let bounces = || {
        let mut world = world(keys("clpv.bounces.0", KeyValue::Scalar(1.0), KeyValue::Scalar(3.0)));
        let volume = world.find("volume").unwrap();
        let bounces = lightwell::world::Bounces::Count(1);
        world.ecs.entity_mut(volume).insert(Clpv { quality: Quality::Low, bounces, ..Clpv::default() });
        world
    };
    let ran = played(&gpu, bounces);
    println!("bounces: {ran:?}");
    assert_ran(&ran, &["sweep"], &["shadow", "rsm", "gbuffer", "direct"]);
}
