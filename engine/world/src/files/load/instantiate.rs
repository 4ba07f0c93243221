//! Scenes and prefabs into a world that is running.

use super::loader::{self, Context, Loader, canonical_scene, environment_image};
use super::model;
use super::opened::{Opened, complete, file_name};
use super::options::LoadOptions;
use super::source::{SceneInfo, Source};
use super::spawn::despawn;
use super::trust::Roots;
use crate::assets::AssetLibrary;
use crate::files::error::{FileError, FileErrorKind as Kind};
use crate::files::format::scene_file::{EntityFile, SceneFile};
use crate::files::format::validate::Validator;
use crate::files::ron::document::Document;
use crate::files::ron::steps::{fault_error, key};
use crate::files::ron::tree::Step;
use crate::world::{EnvironmentImage, GameWorld, SceneSettings};
use bevy_ecs::prelude::Entity;
use std::path::Path;
use std::rc::Rc;

/// Loads a scene file into a world, in place of the entities `old`. Everything else in the world stays. Gives what the
/// file says.
///
/// # Errors
/// As [`load_scene`](crate::files::load_scene); the world keeps what it was then. glTF files and prefabs are no such scenes:
/// name them in one as `model` or `prefab`.
pub fn enter_scene(
    world: &mut GameWorld,
    library: &mut AssetLibrary,
    options: &LoadOptions,
    path: &Path,
    old: &[Entity],
) -> Result<SceneFile, FileError> {
    let other = match Opened::of(path) {
        Opened::Gltf => Some("model"),
        Opened::Prefab => Some("prefab"),
        Opened::Scene => None,
    };
    if let Some(what) = other {
        let message = format!("a game's scene is a .scene.ron file, and this is a {what}");
        let help = format!("write a scene with an entity that says `{what}: \"…\"`");
        return Err(FileError::new(path, Kind::BadValue, message).with_help(help));
    }
    let (document, file) = Document::read::<SceneFile>(path)?;
    enter(world, library, options, document, file, old)
}

/// Makes what a scene file would say the contents of a world, in place of the entities `old`. Paths are relative to
/// `path`.
///
/// # Errors
/// As [`enter_scene`].
pub fn enter_described(
    world: &mut GameWorld,
    library: &mut AssetLibrary,
    options: &LoadOptions,
    path: &Path,
    file: SceneFile,
    old: &[Entity],
) -> Result<(), FileError> {
    enter(world, library, options, Document::in_memory(path), file, old).map(drop)
}

/// Reloads a world's scene file with all that it names, or the glTF or prefab file that was opened as one.
/// Entities keep the identities of those that stood at the same paths before.
///
/// # Errors
/// As [`enter_scene`].
pub fn reenter_scene(
    world: &mut GameWorld,
    library: &mut AssetLibrary,
    options: &LoadOptions,
    path: &Path,
) -> Result<(), FileError> {
    let (old, identities) = (world.roots(), world.identities());
    let known = world.ecs.get_resource::<SceneInfo>().cloned().unwrap_or_default();
    match Opened::of(path) {
        Opened::Gltf => model::enter_gltf(world, library, options, path, &old)?,
        Opened::Prefab => enter_prefab(world, library, options, path, &old)?,
        Opened::Scene => drop(enter_scene(world, library, options, path, &old)?),
    }
    world.take_over(&identities);
    // What an undo brings back still comes from these files.
    let mut info = world.ecs.get_resource_or_init::<SceneInfo>();
    for (id, material) in known.materials_by_id {
        info.materials_by_id.entry(id).or_insert(material);
    }
    for (id, texture) in known.textures_by_id {
        info.textures_by_id.entry(id).or_insert(texture);
    }
    for (mesh, shape) in known.shapes {
        info.shapes.entry(mesh).or_insert(shape);
    }
    Ok(())
}

fn enter(
    world: &mut GameWorld,
    library: &mut AssetLibrary,
    options: &LoadOptions,
    document: Document,
    mut file: SceneFile,
    old: &[Entity],
) -> Result<SceneFile, FileError> {
    Validator::scene(&file).map_err(|fault| fault_error(&document, *fault))?;
    canonical_scene(&document, &mut file, &options.types)?;
    let image = environment_image(&document, &file.settings, library, &Roots::of(&document.path, options))?;
    let (info, path) = (SceneInfo::new(&document, &file), document.path.clone());
    let context = Rc::new(Context { document, materials: file.materials.clone(), is_root: true });
    let before = world.roots();
    let shapes = world.ecs.get_resource::<SceneInfo>().map(|info| info.shapes.clone()).unwrap_or_default();
    // Tracks of the entities may be for settings.
    let kept = world.rest_settings();
    world.set_rest_settings(file.settings.clone());
    let mut loader = Loader::new(library, options, std::mem::take(world), info, &path);
    let mut entities = file.entities.iter().enumerate();
    let result = entities
        .try_for_each(|(index, entity)| loader.entity(entity, &context, None, &[key("entities"), Step::Index(index)]));
    let Loader { world: lent, mut info, .. } = loader;
    *world = lent;
    if let Err(error) = result {
        let new = world.roots().into_iter().filter(|root| !before.contains(root)).collect::<Vec<_>>();
        despawn(world, &new);
        world.set_rest_settings(kept);
        return Err(error);
    }
    despawn(world, old);
    for root in before.into_iter().filter(|root| !old.contains(root)) {
        keep(world, root);
    }
    for (mesh, shape) in shapes {
        info.shapes.entry(mesh).or_insert(shape);
    }
    match image {
        Some(image) => world.ecs.insert_resource(image),
        None => drop(world.ecs.remove_resource::<EnvironmentImage>()),
    }
    world.ecs.insert_resource(info);
    world.set_tick(0);
    Ok(file)
}

/// What stays from another scene names its materials no longer: they are the other file's.
fn keep(world: &mut GameWorld, root: Entity) {
    for entity in world.subtree(root) {
        if let Some(mut source) = world.ecs.get_mut::<Source>(entity) {
            source.material = None;
        }
    }
}

/// Loads a scene: a `.scene.ron` file, or a glTF or `.prefab.ron` file as a scene of its own.
///
/// # Errors
/// Whatever is wrong with the file, a prefab or an asset that it names. No world is changed.
pub fn load_scene(path: &Path, library: &mut AssetLibrary, options: &LoadOptions) -> Result<GameWorld, FileError> {
    match Opened::of(path) {
        Opened::Gltf => model::load_gltf_scene(path, library, options),
        Opened::Prefab => load_prefab_scene(path, library, options),
        Opened::Scene => loader::load(path, library, options),
    }
}

/// Opens a prefab file as a scene: an instance of it at the origin, with a camera that frames it and a light, whether it has
/// lights of its own or not: it is a part, to be looked at.
pub(in crate::files) fn load_prefab_scene(
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
pub(in crate::files) fn enter_prefab(
    world: &mut GameWorld,
    library: &mut AssetLibrary,
    options: &LoadOptions,
    path: &Path,
    old: &[Entity],
) -> Result<(), FileError> {
    if !path.is_file() {
        return Err(crate::files::ron::document::io_error(path, "", &std::io::ErrorKind::NotFound.into()));
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
