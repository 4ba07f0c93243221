//! Files that are opened as scenes of their own: prefabs, and what they and glTF files lack to be looked at.

use super::LoadOptions;
use super::error::FileError;
use super::format::*;
use super::instantiate::enter_described;
use super::source::{Origin, Source};
use super::spawn::model_source;
use crate::assets::AssetLibrary;
use crate::scene::Aabb;
use crate::world::{
    Camera, Clpv, GameWorld, GlobalTransform, Light, LightKind, MeshRenderer, SceneSettings, Transform,
};
use bevy_ecs::prelude::Entity;
use glam::Vec3;
use std::path::Path;

/// What a file holds that is opened as a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Opened {
    Scene,
    Prefab,
    Gltf,
}

impl Opened {
    /// By the ending of the file's name, whatever its case; a scene if there is no other.
    pub fn of(path: &Path) -> Self {
        let name = file_name(path).to_lowercase();
        match name {
            name if name.ends_with(".gltf") || name.ends_with(".glb") => Self::Gltf,
            name if name.ends_with(".prefab.ron") => Self::Prefab,
            _ => Self::Scene,
        }
    }
}

/// Opens a prefab file as a scene: an instance of it at the origin, with a camera that frames it and a light, whether it has
/// lights of its own or not: it is a part, to be looked at.
pub(super) fn load_prefab_scene(
    path: &Path,
    library: &mut AssetLibrary,
    options: &LoadOptions,
) -> Result<GameWorld, FileError> {
    let mut world = GameWorld::new();
    options.types.register(&mut world.ecs);
    world.ecs.insert_resource(options.types.clone());
    enter_prefab(&mut world, library, options, path, &[])?;
    Ok(world)
}

/// The same into a world, in place of the entities `old`.
///
/// # Errors
/// If the file cannot be read; the world keeps what it was then.
pub(super) fn enter_prefab(
    world: &mut GameWorld,
    library: &mut AssetLibrary,
    options: &LoadOptions,
    path: &Path,
    old: &[Entity],
) -> Result<(), FileError> {
    if !path.is_file() {
        return Err(super::document::io_error(path, "", &std::io::ErrorKind::NotFound.into()));
    }
    let file = file_name(path);
    let name = file.split('.').next().filter(|name| !name.is_empty()).unwrap_or("prefab").to_owned();
    // The scene is no file. It stands beside the prefab, whose path is relative to it.
    let beside = path.with_file_name(format!("{name}.scene.ron"));
    let instance = EntityFile { name, prefab: Some(file.clone()), ..Default::default() };
    // The file says nothing of how bright it is to be shown.
    let settings = SceneSettings { auto_exposure: true, ..SceneSettings::default() };
    let scene = SceneFile { description: file, settings, entities: vec![instance], ..Default::default() };
    enter_described(world, library, options, &beside, scene, old)?;
    world.set_tick(0);
    world.update();
    complete(world, path, false);
    world.update();
    Ok(())
}

/// The file's name without its folder.
pub(super) fn file_name(path: &Path) -> String {
    path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned())
}

/// Adds what a scene needs and the file lacks. A `whole` scene may be lit by its own lights alone, and what it lacks is
/// told; of a part neither is expected.
pub(super) fn complete(world: &mut GameWorld, path: &Path, whole: bool) {
    let level = if whole { log::Level::Warn } else { log::Level::Debug };
    let bounds = bounds_over_time(world);
    if world.ecs.query::<&Camera>().iter(&world.ecs).next().is_none() {
        log::log!(level, "{}: the file has no camera; one that frames all of it is added", path.display());
        let (transform, camera) = framing_camera(&bounds);
        let entity = world.spawn("framing camera", None);
        let components =
            OverrideFile { transform: Some(transform), camera: Some(camera.clone()), ..Default::default() };
        let source = Source { components, origin: Origin::File, ..model_source() };
        world.ecs.entity_mut(entity).insert((Transform::from(transform), camera, source));
    }
    if !(whole && is_lit(world)) {
        log::log!(level, "{}: the file has no light; a directional light and an even sky are added", path.display());
        let transform = TransformFile {
            translation: bounds.center() + Vec3::Y * bounds.size().length(),
            rotation: Some(Rotation::Euler(Vec3::new(-55.0, 30.0, 0.0))),
            ..Default::default()
        };
        let light = Light { kind: LightKind::Directional, intensity: 3.0, ..Default::default() };
        // Metals show nothing but what surrounds them: alone with a lamp they are black.
        world.ecs.resource_mut::<SceneSettings>().sky = Vec3::splat(0.4);
        let entity = world.spawn("default light", None);
        let components = OverrideFile { transform: Some(transform), light: Some(light.clone()), ..Default::default() };
        let source = Source { components, origin: Origin::File, ..model_source() };
        world.ecs.entity_mut(entity).insert((Transform::from(transform), light, source));
    }
    let entity = world.spawn("light volumes", None);
    let transform = TransformFile { translation: bounds.center(), ..Default::default() };
    let components = OverrideFile { transform: Some(transform), clpv: Some(Clpv::default()), ..Default::default() };
    let source = Source { components, origin: Origin::File, ..model_source() };
    world.ecs.entity_mut(entity).insert((Transform::from(transform), Clpv::default(), source));
}

/// Whether anything gives light: a light, or a surface that shines. What is unlit shows its colour and lights nothing.
fn is_lit(world: &mut GameWorld) -> bool {
    let shines = |surface: &MeshRenderer| surface.material.emissive.max_element() > 0.0 && !surface.material.unlit;
    world.ecs.query::<&Light>().iter(&world.ecs).next().is_some()
        || world.ecs.query::<&MeshRenderer>().iter(&world.ecs).any(shines)
}

/// Bounds of all that is drawn, at a few times if it moves.
fn bounds_over_time(world: &mut GameWorld) -> Aabb {
    const TIMES: u64 = 8;
    let ticks = world.loop_ticks().unwrap_or(0);
    let mut bounds = Aabb::EMPTY;
    for tick in (0..TIMES).map(|i| ticks * i / TIMES).rev() {
        if ticks > 0 {
            world.set_tick(tick);
            world.update();
        }
        for (place, renderer) in world.ecs.query::<(&GlobalTransform, &MeshRenderer)>().iter(&world.ecs) {
            bounds = bounds.union(&renderer.mesh.bounds.transformed(&place.0));
        }
        if ticks == 0 {
            break;
        }
    }
    bounds
}

/// Radius of the smallest thing that is framed \[m\].
const LEAST_RADIUS: f32 = 1e-7;

/// A camera before the box, a little above and aside, that sees all of it.
fn framing_camera(bounds: &Aabb) -> (TransformFile, Camera) {
    let camera = Camera { fov: 45.0, primary: true, ..Default::default() };
    let radius = match 0.5 * bounds.size().length() {
        radius if radius > 0.0 && radius.is_finite() => radius.max(LEAST_RADIUS),
        _ => 1.0,
    };
    let distance = 1.05 * radius / (0.5 * camera.fov).to_radians().sin();
    let center = bounds.center();
    let translation = center + Vec3::new(0.45, 0.35, 1.0).normalize() * distance;
    let camera = Camera { near: 1e-3 * distance, ..camera };
    (TransformFile { translation, look_at: Some(center), ..Default::default() }, camera)
}
