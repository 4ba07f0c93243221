//! Scenes and prefabs into a world that is running.

use super::LoadOptions;
use super::document::Document;
use super::edit_context::{EditContext, canonical, with_loader};
use super::error::{FileError, FileErrorKind as Kind};
use super::format::{EntityFile, SceneFile, TransformFile};
use super::load::{Context, Loader, canonical_entities, environment_image};
use super::opened::Opened;
use super::save::{Writer, scene_without_entities};
use super::source::{SceneInfo, Source};
use super::spawn::despawn;
use super::steps::{fault_error, key};
use super::tree::Step;
use super::trust::Roots;
use super::validate::Validator;
use crate::assets::AssetLibrary;
use crate::world::{EnvironmentImage, GameWorld, Transform};
use bevy_ecs::prelude::Entity;
use std::path::Path;
use std::rc::Rc;

/// Loads a scene file into a world, in place of the entities `old`. Everything else in the world stays. Gives what the
/// file says.
///
/// # Errors
/// As [`load_scene`](super::load_scene); the world keeps what it was then. glTF files and prefabs are no such scenes:
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
        Opened::Gltf => super::model::enter_gltf(world, library, options, path, &old)?,
        Opened::Prefab => super::opened::enter_prefab(world, library, options, path, &old)?,
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
    canonical_entities(&document, &mut file.entities, &options.types)?;
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

/// Makes an entity that is there an instance of a prefab. Its name becomes that of the file, with a number if need be.
///
/// # Errors
/// As [`spawn_entity`](super::spawn_entity). The entity may then have some of the prefab's entities below it.
pub fn spawn_prefab_onto(
    world: &mut GameWorld,
    context: &mut EditContext,
    entity: Entity,
    prefab: &str,
    place: Transform,
) -> Result<(), FileError> {
    let stem = Path::new(prefab).file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    let parent = world.parent(entity);
    let name = world.unique_name(parent, stem.split('.').next().filter(|n| !n.is_empty()).unwrap_or("prefab"));
    let transform = Some(TransformFile::from(place));
    let mut file = EntityFile { name, transform, prefab: Some(prefab.to_owned()), ..Default::default() };
    Validator::lone_entity(&file, Vec::new())
        .map_err(|fault| super::edit_context::fault_error(context.path, *fault))?;
    canonical(context, |canonical| canonical.entity(&mut file, &[]))?;
    with_loader(world, context, |loader, context| {
        loader.target = Some(entity);
        loader.entity(&file, context, parent, &[])
    })
}

/// The whole scene, entities included, as its file would say it.
///
/// # Errors
/// When the world holds something that has no form in a file.
pub fn describe_all(world: &GameWorld, path: &Path) -> Result<SceneFile, FileError> {
    let default_info = SceneInfo::default();
    let info = world.ecs.get_resource::<SceneInfo>().unwrap_or(&default_info);
    let entities = Writer { world, info, path, overridden: None }.entities(&world.roots())?;
    let file = SceneFile { entities, ..scene_without_entities(world) };
    super::save::check(&file, path)?;
    Ok(file)
}
