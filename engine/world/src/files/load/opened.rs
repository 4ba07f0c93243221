//! Files that are opened as scenes of their own: prefabs, and what they and glTF files lack to be looked at.

use super::source::{Origin, Source};
use super::spawn::model_source;
use crate::core::Aabb;
use crate::files::format::scene_file::*;
use crate::world::{
    Camera, Clpv, GameWorld, GlobalTransform, Light, LightKind, MeshRenderer, SceneSettings, Transform,
};
use glam::Vec3;
use std::path::Path;

/// What a file holds that is opened as a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::files) enum Opened {
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

/// The file's name without its folder.
pub(in crate::files) fn file_name(path: &Path) -> String {
    path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned())
}

/// Adds what a scene needs and the file lacks. A `whole` scene may be lit by its own lights alone, and what it lacks is
/// told; of a part neither is expected.
pub(in crate::files) fn complete(world: &mut GameWorld, path: &Path, whole: bool) {
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
