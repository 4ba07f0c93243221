//! Changes to a loaded world in terms of scene files: what an entity is, and making it something else.
//!
//! A component that scene files can hold needs no code here: an edit describes the entity as the file would, and puts
//! back what differs the way that loading does.

use super::LoadOptions;
use super::custom_components::Canonical;
use super::document::Document;
use super::error::{FileError, FileErrorKind as Kind};
use super::format::*;
use super::load::{Context, Loader, Resolved, environment_image};
use super::save::{Writer, scene_without_entities};
use super::source::{Origin, SceneInfo, Source};
use super::spawn::model_source;
use super::surfaces::renderer;
use super::tracks;
use super::tree::Step;
use super::trust::Roots;
use super::validate::{Fault, Validator};
use crate::assets::{AssetLibrary, Material};
use crate::world::{
    Animation, Camera, Clpv, EnvironmentImage, GameWorld, InstantRadiosity, Light, MeshRenderer,
    StochasticLightCulling, Transform,
};
use bevy_ecs::prelude::Entity;
use std::path::Path;
use std::rc::Rc;
use std::sync::Arc;

/// Where edits take their assets from, and the scene file that paths in them are relative to.
pub struct EditContext<'a> {
    /// Loaded assets.
    pub library: &'a mut AssetLibrary,
    /// Folder of models.
    pub options: &'a LoadOptions,
    /// The scene's file.
    pub path: &'a Path,
}

/// What the entity is without its animation, as a scene file would say it.
///
/// # Errors
/// If it has something that has no form in a file, as a mesh of a glTF model.
pub fn describe_entity(world: &GameWorld, entity: Entity, path: &Path) -> Result<OverrideFile, FileError> {
    with_writer(world, path, |writer| writer.components(entity))
}

/// The entity with all below it, as a scene file would say it.
///
/// # Errors
/// As [`describe_entity`].
pub fn describe_subtree(world: &GameWorld, entity: Entity, path: &Path) -> Result<EntityFile, FileError> {
    with_writer(world, path, |writer| writer.entity(entity))
}

/// The scene without its entities: description, method, settings, presets, materials.
pub fn describe_scene(world: &GameWorld) -> SceneFile {
    scene_without_entities(world)
}

/// Whether the entity was made from a node of a glTF model: changes of it are not written.
pub fn is_from_model(world: &GameWorld, entity: Entity) -> bool {
    world.ecs.get::<Source>(entity).is_some_and(|source| matches!(source.origin, Origin::Model))
}

/// The prefab that the entity is an instance of, as the file names it.
pub fn prefab_of(world: &GameWorld, entity: Entity) -> Option<&str> {
    world.ecs.get::<Source>(entity)?.prefab.as_deref()
}

/// Whether the entity is an instance that makes several copies of its prefab.
pub fn is_repeated(world: &GameWorld, entity: Entity) -> bool {
    world.ecs.get::<Source>(entity).is_some_and(|source| source.repeat.is_some())
}

/// Whether the entity belongs to an instance of a prefab further up.
pub fn is_in_prefab(world: &GameWorld, entity: Entity) -> bool {
    world.ecs.get::<Source>(entity).is_some_and(|source| matches!(source.origin, Origin::Prefab { .. }))
}

/// Makes the entity, without its animation, what the description says. What is the same stays untouched.
///
/// # Errors
/// If a value is out of its range, or an asset is missing or faulty; the entity stays as it was.
pub fn edit_entity(
    world: &mut GameWorld,
    context: &mut EditContext,
    entity: Entity,
    now: &OverrideFile,
) -> Result<(), FileError> {
    let before = describe_entity(world, entity, context.path)?;
    if *now == before {
        return Ok(());
    }
    let names = material_names(world);
    Validator::lone_components(now, names).map_err(|fault| fault_error(context.path, *fault))?;
    let mut now = now.clone();
    canonical(context, |canonical| canonical.patch(&mut now, &[]))?;
    let now = &now;
    // A model that changes too is not there yet.
    if let Some(animation) =
        now.animation.as_ref().filter(|_| now.model == before.model && now.animation != before.animation)
        && let Some(fault) = tracks::fault(world, entity, animation)
    {
        return Err(fault_error(context.path, fault));
    }
    let described = world.ecs.get::<Source>(entity).and_then(|source| source.material.clone());
    let shared = shared_material(world, now);
    let surface_differs =
        differs(&before, now, |c| (c.mesh.clone(), c.model.clone(), c.material.clone(), c.casts_shadow, c.visible));
    let material = with_loader(world, context, |loader, file| {
        let kept = if now.material == before.material { described } else { shared };
        match surface_differs {
            true => surface(loader, file, entity, now, &before, kept),
            false => Ok(kept),
        }
    })?;
    let changes = now.changes_from(&before);
    for kind in &changes.without {
        take_away(world, context, entity, kind);
    }
    put(world, context, entity, &changes, now)?;
    remember(world, entity, now, material);
    Ok(())
}

/// Puts the changed components on the entity, except those of its surface.
fn put(
    world: &mut GameWorld,
    context: &mut EditContext,
    entity: Entity,
    changes: &OverrideFile,
    now: &OverrideFile,
) -> Result<(), FileError> {
    let place = world.ecs.get::<Transform>(entity).copied();
    let rest = world.rest_transform(entity);
    let (light, camera) = (world.ecs.get::<Light>(entity).cloned(), world.ecs.get::<Camera>(entity).cloned());
    let plain = OverrideFile {
        transform: None,
        mesh: None,
        model: None,
        material: None,
        light: changes.light.clone().filter(|_| light.is_none()),
        camera: changes.camera.clone().filter(|_| camera.is_none()),
        animation: None,
        ..changes.clone()
    };
    let own = changes.components.keys().map(String::as_str);
    let given = [("clpv", changes.clpv.is_some()), ("vpl", changes.vpl.is_some()), ("slc", changes.slc.is_some())];
    for name in own.chain(given.into_iter().filter(|(_, is_given)| *is_given).map(|(name, _)| name)) {
        world.release_fields(entity, name);
    }
    with_loader(world, context, |loader, file| loader.insert_components(entity, &Resolved::of(plain, file)))?;
    if let Some(animation) = &changes.animation {
        world.ecs.entity_mut(entity).insert(animation.clone());
    }
    // Loading sets the transform to the default where none is given.
    world.ecs.entity_mut(entity).insert(place.unwrap_or_default());
    if changes.transform.is_some() {
        let wanted = Transform::from(now.transform.unwrap_or_default());
        if wanted != rest {
            world.set_rest_transform(entity, wanted);
        }
    }
    if let (Some(wanted), Some(_)) = (&changes.light, light) {
        world.set_rest_light(entity, wanted.clone());
    }
    if let (Some(wanted), Some(_)) = (&changes.camera, camera) {
        world.set_rest_camera(entity, wanted.clone());
    }
    Ok(())
}

/// Spawns an entity that a file describes, with all below it, prefabs and models included.
///
/// # Errors
/// If a value is out of its range, the name is taken, or an asset or prefab is missing or faulty; nothing is spawned
/// then.
pub fn spawn_entity(
    world: &mut GameWorld,
    context: &mut EditContext,
    parent: Option<Entity>,
    file: &EntityFile,
) -> Result<Entity, FileError> {
    Validator::lone_entity(file, material_names(world)).map_err(|fault| fault_error(context.path, *fault))?;
    let mut file = file.clone();
    canonical(context, |canonical| canonical.entity(&mut file, &[]))?;
    let file = &file;
    let before: Vec<Entity> = siblings(world, parent);
    if before.iter().any(|sibling| world.name(*sibling) == file.name) {
        let message = format!("there is a sibling named `{}` already", file.name);
        return Err(FileError::new(context.path, Kind::DuplicateName, message).with_help("use another name"));
    }
    let result = with_loader(world, context, |loader, context| loader.entity(file, context, parent, &[]));
    let new = siblings(world, parent).into_iter().find(|sibling| !before.contains(sibling));
    if let (Err(_), Some(half)) = (&result, new) {
        let _ = world.ecs.try_despawn(half);
    }
    result?;
    new.ok_or_else(|| FileError::new(context.path, Kind::BadValue, "the entity leaves nothing"))
}

/// Changes what belongs to the scene as a whole. Entities of the description are passed over.
///
/// # Errors
/// If a value is out of its range, or a material's image is missing; the scene stays as it was.
pub fn edit_scene(world: &mut GameWorld, context: &mut EditContext, now: &SceneFile) -> Result<(), FileError> {
    let before = describe_scene(world);
    let now = SceneFile { entities: Vec::new(), ..now.clone() };
    Validator::scene(&now).map_err(|fault| fault_error(context.path, *fault))?;
    // All that can be missing is loaded before anything changes.
    let environment = match now.settings.environment != before.settings.environment {
        true => {
            let roots = Roots::of(context.path, context.options);
            let document = Document::in_memory(context.path);
            Some(environment_image(&document, &now.settings, context.library, &roots)?)
        }
        false => None,
    };
    let changed = now.materials.iter().filter(|(name, file)| before.materials.get(*name) != Some(*file));
    let load = |(name, file): (&String, &MaterialFile)| {
        let material = with_loader(world, context, |loader, context| loader.material(name, file, context, &[]))?;
        Ok((name.clone(), material))
    };
    let materials = changed.map(load).collect::<Result<Vec<_>, FileError>>()?;
    match environment {
        Some(Some(image)) => world.ecs.insert_resource(image),
        Some(None) => drop(world.ecs.remove_resource::<EnvironmentImage>()),
        None => {}
    }
    for (name, material) in &materials {
        replace_material(world, name, material);
    }
    if now.settings != before.settings {
        let clock = world.clock();
        let rate = now.settings.frame_rate;
        world.set_rest_settings(now.settings);
        world.ecs.insert_resource(clock.with_rate(rate));
    }
    let mut info = world.ecs.get_resource_or_init::<SceneInfo>();
    info.description = now.description;
    info.gi = now.gi;
    info.presets = now.presets;
    info.materials = now.materials;
    Ok(())
}

/// Shape, model and material of the entity; gives the material.
fn surface(
    loader: &mut Loader,
    file: &Rc<Context>,
    entity: Entity,
    now: &OverrideFile,
    before: &OverrideFile,
    kept: Option<Arc<Material>>,
) -> Result<Option<Arc<Material>>, FileError> {
    let resolved = Resolved::of(now.clone(), file);
    let mut material = match kept {
        Some(material) => Some(material),
        None => loader.material_of(&resolved)?,
    };
    let mesh = match &now.mesh {
        Some(shape) => {
            let mesh = loader
                .library
                .shape(shape)
                .map_err(|e| FileError::new(&file.document.path, Kind::BadValue, format!("mesh: {e}")))?;
            loader.info.shapes.insert(mesh.id, shape.clone());
            Some(mesh)
        }
        None => None,
    };
    let children = match before.model.is_some() {
        true => loader.world.children(entity),
        false => Vec::new(),
    };
    if let Some(model) = &now.model {
        let old: Vec<Entity> = children.iter().copied().filter(|c| is_from_model(&loader.world, *c)).collect();
        loader.model(entity, model, material.as_ref(), now, file, &[Step::Key("model".into())])?;
        old.into_iter().for_each(|child| despawn(&mut loader.world, child));
    } else {
        let old = children.into_iter().filter(|c| is_from_model(&loader.world, *c)).collect::<Vec<_>>();
        old.into_iter().for_each(|child| despawn(&mut loader.world, child));
    }
    match mesh {
        Some(mesh) => {
            let material = material.get_or_insert_with(|| loader.info.default_material.clone()).clone();
            loader.world.ecs.entity_mut(entity).insert(renderer(now, mesh, material));
        }
        None => drop(loader.world.ecs.entity_mut(entity).remove::<MeshRenderer>()),
    }
    Ok(material)
}

fn despawn(world: &mut GameWorld, entity: Entity) {
    // Gone already if it stood below another one.
    let _ = world.ecs.try_despawn(entity);
}

/// Reads components of a game.
pub(super) fn canonical(
    context: &EditContext,
    read: impl FnOnce(&Canonical) -> Result<(), Box<FileError>>,
) -> Result<(), FileError> {
    let document = Document::in_memory(context.path);
    read(&Canonical { types: &context.options.types, document: &document, is_quiet: false }).map_err(|error| *error)
}

fn take_away(world: &mut GameWorld, context: &EditContext, entity: Entity, kind: &ComponentKind) {
    if let ComponentKind::Own(name) = kind {
        return context.options.types.take(name, &mut world.ecs, entity);
    }
    let mut entity = world.ecs.entity_mut(entity);
    match kind {
        ComponentKind::Mesh => entity.remove::<MeshRenderer>(),
        ComponentKind::Light => entity.remove::<Light>(),
        ComponentKind::Camera => entity.remove::<Camera>(),
        ComponentKind::Clpv => entity.remove::<Clpv>(),
        ComponentKind::Vpl => entity.remove::<InstantRadiosity>(),
        ComponentKind::Slc => entity.remove::<StochasticLightCulling>(),
        ComponentKind::Animation => entity.remove::<Animation>(),
        ComponentKind::Own(_) => &mut entity,
    };
}

/// Keeps how the entity was described, so that a save says the same.
fn remember(world: &mut GameWorld, entity: Entity, now: &OverrideFile, material: Option<Arc<Material>>) {
    let components = OverrideFile { without: Vec::new(), children: Vec::new(), remove: false, ..now.clone() };
    if let Some(mut source) = world.ecs.get_mut::<Source>(entity) {
        source.material = material;
        source.components = components;
        if let Origin::Prefab { material_overridden, base, .. } = &mut source.origin {
            *material_overridden |= base.material != now.material;
        }
        return;
    }
    let source = Source { components, material, origin: Origin::File, ..model_source() };
    world.ecs.entity_mut(entity).insert(source);
}

/// A named material of the scene that some entity bears already.
fn shared_material(world: &mut GameWorld, now: &OverrideFile) -> Option<Arc<Material>> {
    let wanted = now.material.clone().filter(|m| matches!(m, MaterialRef::Named(_)))?;
    let known = world.ecs.get_resource::<SceneInfo>()?.materials_by_id.clone();
    let mut query = world.ecs.query::<&MeshRenderer>();
    query.iter(&world.ecs).map(|r| &r.material).find(|m| known.get(&m.id) == Some(&wanted)).cloned()
}

/// Gives all that bear a named material of the scene a new one.
fn replace_material(world: &mut GameWorld, name: &str, new: &Arc<Material>) {
    let named = MaterialRef::Named(name.to_owned());
    let Some(info) = world.ecs.get_resource::<SceneInfo>() else { return };
    let old: Vec<_> = info.materials_by_id.iter().filter(|(_, m)| **m == named).map(|(id, _)| *id).collect();
    let is_old = |material: &Material| material.id != new.id && old.contains(&material.id);
    let entities: Vec<Entity> = world.ecs.query::<(Entity, &Source)>().iter(&world.ecs).map(|(e, _)| e).collect();
    for entity in entities {
        let rest = world.rest_material(entity);
        if rest.is_some_and(|m| is_old(&m))
            && let Some(mut renderer) = world.ecs.get_mut::<MeshRenderer>(entity)
        {
            renderer.material = new.clone();
        }
        if world.ecs.get::<Source>(entity).is_some_and(|s| s.material.as_deref().is_some_and(is_old))
            && let Some(mut source) = world.ecs.get_mut::<Source>(entity)
        {
            source.material = Some(new.clone());
        }
    }
}

fn differs<T: PartialEq>(a: &OverrideFile, b: &OverrideFile, part: impl Fn(&OverrideFile) -> T) -> bool {
    part(a) != part(b)
}

fn siblings(world: &GameWorld, parent: Option<Entity>) -> Vec<Entity> {
    parent.map_or_else(|| world.roots(), |parent| world.children(parent))
}

fn material_names(world: &GameWorld) -> Vec<String> {
    world.ecs.get_resource::<SceneInfo>().map(|info| info.materials.keys().cloned().collect()).unwrap_or_default()
}

pub(super) fn with_writer<T>(world: &GameWorld, path: &Path, read: impl FnOnce(&Writer) -> T) -> T {
    let default_info = SceneInfo::default();
    let info = world.ecs.get_resource::<SceneInfo>().unwrap_or(&default_info);
    read(&Writer { world, info, path, overridden: None })
}

/// Lends the world to a loader.
pub(super) fn with_loader<T>(
    world: &mut GameWorld,
    context: &mut EditContext,
    work: impl FnOnce(&mut Loader, &Rc<Context>) -> T,
) -> T {
    let info = world.ecs.remove_resource::<SceneInfo>().unwrap_or_default();
    let document = Document::in_memory(context.path);
    let file = Rc::new(Context { document, materials: info.materials.clone(), is_root: true });
    let lent = std::mem::take(world);
    let mut loader = Loader::new(context.library, context.options, lent, info, context.path);
    let result = work(&mut loader, &file);
    let Loader { world: lent, info, .. } = loader;
    *world = lent;
    world.ecs.insert_resource(info);
    result
}

pub(super) fn fault_error(path: &Path, fault: Fault) -> FileError {
    let words: Vec<String> = fault.path.iter().map(step_word).filter(|word| !word.is_empty()).collect();
    let place = if words.is_empty() { String::new() } else { format!("{}: ", words.join(".")) };
    let error = FileError::new(path, fault.kind, format!("{place}{}", fault.message));
    match fault.help.filter(|help| !help.is_empty()) {
        Some(help) => error.with_help(help),
        None => error,
    }
}

fn step_word(step: &Step) -> String {
    match step {
        Step::Key(key) => key.clone(),
        Step::Index(index) => index.to_string(),
    }
}
