//! Changes to what belongs to a loaded scene as a whole: settings, presets, materials.

use super::context::{EditContext, fault_error, with_loader};
use crate::assets::Material;
use crate::files::error::FileError;
use crate::files::format::scene_file::{MaterialFile, MaterialRef, SceneFile};
use crate::files::format::validate::Validator;
use crate::files::load::loader::environment_image;
use crate::files::load::source::{SceneInfo, Source};
use crate::files::load::trust::Roots;
use crate::files::ron::document::Document;
use crate::files::save::describe::describe_scene;
use crate::world::{EnvironmentImage, GameWorld, MeshRenderer};
use bevy_ecs::prelude::Entity;
use std::sync::Arc;

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
