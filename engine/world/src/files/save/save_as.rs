//! A scene under another name, in any folder.

use super::disk::write_atomically;
use super::paths::{NoWay, Rebase, way_to};
use super::scene::{saved_file, text_of};
use crate::assets::AssetLibrary;
use crate::files::error::FileError;
use crate::files::format::scene_file::{MaterialRef, ModelDetails, ModelFile, OverrideFile, SceneFile};
use crate::files::load::instantiate::load_scene;
use crate::files::load::options::LoadOptions;
use crate::files::load::source::{Origin, SceneInfo, Source};
use crate::files::ron::document::{check_replaced, folder_of};
use crate::world::{Camera, EnvironmentImage, GameWorld, GradingTable};
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::prelude::Allow;
use std::path::Path;

/// Writes the world, whose paths start at the folder of `from`, as a scene file in any folder. Relative paths are
/// rewritten for it, in the world too: from then on it is the new file's scene. Paths of models and images that lie in
/// the folder of models stay.
///
/// # Errors
/// As [`save_scene`](crate::files::save_scene), and when a file that the scene names cannot be reached from there: which one,
/// and why. File and world are untouched then.
pub fn save_scene_as(
    world: &mut GameWorld,
    library: &AssetLibrary,
    options: &LoadOptions,
    from: &Path,
    to: &Path,
) -> Result<(), FileError> {
    check_replaced(to)?;
    let rebase = rebase(from, to, options);
    let mut file = saved_file(world, from)?;
    rebase.scene(&mut file).map_err(|no_way| no_way.at_file(to))?;
    let text = text_of(world, to, &file)?;
    if rebase.moves() {
        try_out(&text, to, library, options)?;
    }
    write_atomically(to, &text)?;
    follow(world, &rebase, from).map_err(|no_way| no_way.at_file(to))?;
    world.ecs.get_resource_or_init::<SceneInfo>().file = Some((to.to_owned(), text.into()));
    Ok(())
}

/// Rewrites the paths of a description for a scene that was saved in another folder.
///
/// # Errors
/// When there is no relative path.
pub fn rewrite_paths(scene: &mut SceneFile, from: &Path, to: &Path, options: &LoadOptions) -> Result<(), FileError> {
    rebase(from, to, options).scene(scene).map_err(|no_way| no_way.at_file(to))
}

fn rebase(from: &Path, to: &Path, options: &LoadOptions) -> Rebase {
    Rebase::new(folder_of(from), folder_of(to)).with_models(options.models.as_deref())
}

/// Whether the text can be loaded from there.
fn try_out(text: &str, to: &Path, library: &AssetLibrary, options: &LoadOptions) -> Result<(), FileError> {
    let trial = folder_of(to).join(format!(".{}.trial.scene.ron", std::process::id()));
    let loaded =
        write_atomically(&trial, text).and_then(|()| load_scene(&trial, &mut library.clone(), options).map(drop));
    // It is of no use to anyone.
    let _ = std::fs::remove_file(&trial);
    loaded.map_err(|mut error| {
        error.message = format!("cannot be saved there: {}", error.message);
        if error.file == trial {
            error.file = to.to_owned();
        }
        error
    })
}

/// Rewrites the paths that the world remembers, those of what an undo brings back too.
fn follow(world: &mut GameWorld, rebase: &Rebase, from: &Path) -> Result<(), NoWay> {
    let is_of_model = world.ecs.get_resource::<SceneInfo>().is_none_or(|info| info.file.is_none());
    let mut sources = world.ecs.query_filtered::<&mut Source, Allow<Disabled>>();
    for mut source in sources.iter_mut(&mut world.ecs) {
        if let Some(ModelFile::Detailed(model)) = source.components.model.as_mut().filter(|_| is_of_model) {
            below(model, from);
        }
        self::source(&mut source, rebase)?;
    }
    cameras(world, rebase)?;
    let mut settings = world.rest_settings();
    let before = settings.environment.clone();
    rebase.settings(&mut settings)?;
    if let Some(mut image) = world.ecs.get_resource_mut::<EnvironmentImage>()
        && before.as_ref() == Some(&image.environment)
        && let Some(environment) = &settings.environment
    {
        image.environment = environment.clone();
    }
    world.set_rest_settings(settings);
    let mut info = world.ecs.get_resource_or_init::<SceneInfo>();
    info.materials.values_mut().try_for_each(|material| rebase.material(material))?;
    info.textures_by_id.values_mut().try_for_each(|image| rebase.texture(image))?;
    info.materials_by_id.values_mut().try_for_each(|material| match material {
        MaterialRef::Inline(material) => rebase.material(material),
        MaterialRef::Named(_) => Ok(()),
    })
}

/// Rewrites the paths of colour tables, those that are loaded too.
fn cameras(world: &mut GameWorld, rebase: &Rebase) -> Result<(), NoWay> {
    let mut cameras = world.ecs.query_filtered::<(&mut Camera, &mut GradingTable), Allow<Disabled>>();
    for (mut camera, mut table) in cameras.iter_mut(&mut world.ecs) {
        let mut moved = Some(camera.clone());
        rebase.camera(&mut moved)?;
        let Some(moved) = moved.filter(|moved| *moved != *camera) else { continue };
        if camera.lens.grading.as_ref() == Some(&table.file) {
            table.file = moved.lens.grading.clone().unwrap_or_default();
        }
        *camera = moved;
    }
    Ok(())
}

/// A model that was opened as a scene is named by its whole path; from its own scene on by the way to it.
fn below(model: &mut ModelDetails, from: &Path) {
    if Path::new(&model.path).has_root()
        && let Some(way) = way_to(Path::new(&model.path), folder_of(from))
    {
        model.path = way;
    }
}

/// The scene file's text of the entity; paths of its prefab start at the prefab's folder.
fn source(source: &mut Source, rebase: &Rebase) -> Result<(), NoWay> {
    source.overrides.values_mut().try_for_each(|patch| rebase.patch(patch))?;
    let OverrideFile { model, material, camera, .. } = &mut source.components;
    match &source.origin {
        Origin::Prefab { base, material_overridden, .. } => {
            if *model != base.model {
                rebase.model(model)?;
            }
            if *material_overridden || *material != base.material {
                rebase.material_ref(material)?;
            }
            return Ok(());
        }
        Origin::File => {}
        Origin::Model => return Ok(()),
    }
    rebase.model(model)?;
    rebase.material_ref(material)?;
    rebase.camera(camera)?;
    source.prefab.iter_mut().try_for_each(|prefab| rebase.path(prefab))
}
