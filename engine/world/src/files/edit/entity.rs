//! Changes to entities of a loaded world in terms of scene files.
//!
//! A component that scene files can hold needs no code here: an edit describes the entity as the file would, and puts
//! back what differs the way that loading does.

use super::context::{EditContext, canonical, fault_error, with_loader};
use crate::assets::Material;
use crate::files::error::{FileError, FileErrorKind as Kind};
use crate::files::format::scene_file::*;
use crate::files::format::validate::Validator;
use crate::files::load::components::renderer;
use crate::files::load::loader::{Context, Loader, Resolved};
use crate::files::load::source::{Origin, SceneInfo, Source};
use crate::files::load::spawn::model_source;
use crate::files::load::tracks;
use crate::files::ron::tree::Step;
use crate::files::save::describe::{describe_entity, is_from_model};
use crate::world::{
    Animation, Camera, Clpv, Fog, GameWorld, InstantRadiosity, Light, MeshRenderer, Particles, StochasticLightCulling,
    Transform,
};
use bevy_ecs::prelude::Entity;
use std::rc::Rc;
use std::sync::Arc;

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
    if let (Some(wanted), Some(_)) = (&changes.camera, &camera) {
        with_loader(world, context, |loader, file| {
            let at = ["camera", "lens", "grading"].map(|name| Step::Key(name.into()));
            loader.grading(entity, wanted, file, &at)
        })?;
    }
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
    let given = [
        ("clpv", changes.clpv.is_some()),
        ("vpl", changes.vpl.is_some()),
        ("slc", changes.slc.is_some()),
        ("fog", changes.fog.is_some()),
        ("particles", changes.particles.is_some()),
    ];
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
        despawn(world, half);
    }
    result?;
    new.ok_or_else(|| FileError::new(context.path, Kind::BadValue, "the entity leaves nothing"))
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
    crate::world::despawn(&mut world.ecs, entity);
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
        ComponentKind::Fog => entity.remove::<Fog>(),
        ComponentKind::Particles => entity.remove::<Particles>(),
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

fn differs<T: PartialEq>(a: &OverrideFile, b: &OverrideFile, part: impl Fn(&OverrideFile) -> T) -> bool {
    part(a) != part(b)
}

fn siblings(world: &GameWorld, parent: Option<Entity>) -> Vec<Entity> {
    parent.map_or_else(|| world.roots(), |parent| world.children(parent))
}

fn material_names(world: &GameWorld) -> Vec<String> {
    world.ecs.get_resource::<SceneInfo>().map(|info| info.materials.keys().cloned().collect()).unwrap_or_default()
}
