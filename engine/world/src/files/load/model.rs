//! glTF models in scenes, and glTF files opened as scenes.

use super::loader::{Context, Loader};
use super::opened::{complete, file_name};
use super::options::LoadOptions;
use super::source::{Origin, SceneInfo, Source};
use super::spawn::{Model, Take, despawn, model_source};
use super::trust::Roots;
use crate::assets::{AssetLibrary, Gltf, ImportFault, LightConversion, LightUnits, Material};
use crate::files::error::{FileError, FileErrorKind as Kind};
use crate::files::format::scene_file::*;
use crate::files::ron::document::Document;
use crate::files::ron::steps::{extended, key};
use crate::files::ron::suggest::suggestion;
use crate::files::ron::tree::Step;
use crate::world::animation::{Track, Wrap};
use crate::world::{Animation, GameWorld, SceneSettings};
use bevy_ecs::prelude::Entity;
use std::path::{Path, PathBuf};
use std::sync::Arc;

impl Loader<'_> {
    /// A `what` in the models' folder, or else in the folder of the file that names it.
    ///
    /// # Errors
    /// If it lies where files are not read.
    pub(in crate::files) fn find(
        &self,
        what: &str,
        written: &str,
        document: &Document,
        at: &[Step],
    ) -> Result<Option<PathBuf>, FileError> {
        let models = self.options.models.as_ref().map(|models| models.join(written));
        let models = models.filter(|path| self.roots.allow(written, path));
        if let Some(path) = models.inspect(|path| self.library.ask(path)).filter(|path| path.is_file()) {
            return Ok(Some(path));
        }
        let beside = document.folder().join(written);
        self.roots.check(what, written, &beside, document, at)?;
        self.library.ask(&beside);
        Ok(Some(beside).filter(|path| path.is_file()))
    }

    /// Spawns a model's nodes below the entity.
    pub(in crate::files) fn model(
        &mut self,
        entity: Entity,
        file: &ModelFile,
        material: Option<&Arc<Material>>,
        components: &OverrideFile,
        context: &Context,
        at: &[Step],
    ) -> Result<(), FileError> {
        let details = file.details();
        let Some(path) = self.find("model", &details.path, &context.document, at)? else {
            return Err(self.missing_model(&details, context, at));
        };
        let whole = self.library.gltf(&path).map_err(|e| context.document.asset_error(at, Kind::Asset, &e))?;
        let (gltf, units) = match &details.import {
            Some(settings) => {
                let fault = |fault| import_error(&context.document, &extended(at, &[key("import")]), fault);
                (self.library.imported(&whole, settings).map_err(fault)?, settings.light_units)
            }
            None => imported_beside(self.library, &self.roots, &whole, &path)?,
        };
        let copies = gltf.nodes.iter().map(|node| node.instances.len() as u64).sum::<u64>();
        self.count(gltf.nodes.len() as u64 + copies, &context.document, at)?;
        let lights = details.lights.then(|| conversion(self.library, &gltf, units, self.options));
        let take = Take { lights, cameras: details.cameras, material, components };
        let mut model = Model::new(&mut self.world, &gltf, entity, take);
        let Some(name) = &details.node else {
            model.spawn(&gltf.roots, entity);
            model.finish();
            return Ok(());
        };
        let Some(index) = gltf.nodes.iter().position(|node| node.name == *name) else {
            let names = gltf.nodes.iter().map(|n| n.name.as_str());
            let message = format!("the model {} has no node `{name}`", path.display());
            let error = context.document.error(at, Kind::UnknownName, message);
            return Err(match suggestion(name, names) {
                Some(help) => error.with_help(help),
                None => error,
            });
        };
        // The node's ancestors place it; they come along without what they draw.
        let holder = gltf.nodes[index].parent.map_or(entity, |parent| model.holder(parent));
        model.spawn(&[index], holder);
        model.finish();
        Ok(())
    }

    fn missing_model(&self, details: &ModelDetails, context: &Context, at: &[Step]) -> FileError {
        let looked = match &self.options.models {
            Some(models) => format!("in {} and beside this file", models.display()),
            None => "beside this file".to_owned(),
        };
        let message = format!("the model `{}` is not there (looked {looked})", details.path);
        let mut help = String::new();
        if let Some(source) = &details.source {
            help += &format!("get it from {source}; ");
        }
        help += &format!("put it at DIR/{} and pass `--models DIR` (or set LIGHTWELL_MODELS)", details.path);
        if let Some(stand_in) = &details.stand_in {
            help += &format!("; or play its stand-in {stand_in}");
        }
        let kind = if details.source.is_some() { Kind::MissingModel } else { Kind::MissingFile };
        context.document.error(at, kind, message).with_help(help)
    }
}

/// The model as the file `NAME.import.ron` beside it wants it, if there is one, and the units of its lights.
fn imported_beside(
    library: &mut AssetLibrary,
    roots: &Roots,
    whole: &Arc<Gltf>,
    path: &Path,
) -> Result<(Arc<Gltf>, LightUnits), FileError> {
    let beside = path.with_extension("import.ron");
    library.ask(&beside);
    if !beside.is_file() {
        return Ok((whole.clone(), LightUnits::Auto));
    }
    // A link may lead elsewhere.
    let name = beside.file_name().unwrap_or_default().to_string_lossy();
    roots.check("import settings", &name, &beside, &Document::in_memory(path), &[])?;
    let (document, settings) = Document::read::<ImportSettings>(&beside)?;
    library.note(&beside);
    let model = library.imported(whole, &settings).map_err(|fault| import_error(&document, &[], fault))?;
    Ok((model, settings.light_units))
}

/// How the model's lights are read, with a remark if it has any. Import settings go before the options of the load.
fn conversion(library: &mut AssetLibrary, gltf: &Gltf, units: LightUnits, options: &LoadOptions) -> LightConversion {
    let units = if units == LightUnits::Auto { options.light_units } else { units };
    let conversion = LightConversion::of(units, &gltf.generator);
    if gltf.nodes.iter().any(|node| node.light.is_some()) {
        library.remark(format!("{}: {conversion}", gltf.path.display()));
    }
    conversion
}

fn import_error(document: &Document, at: &[Step], fault: ImportFault) -> FileError {
    let mut at = extended(at, &[key(fault.field)]);
    at.extend(fault.index.map(Step::Index));
    document.error(&at, Kind::BadValue, fault.message)
}

/// Opens a glTF file as a scene: all of it, a camera that frames it if it has none, and a light if it has none.
pub fn load_gltf_scene(path: &Path, library: &mut AssetLibrary, options: &LoadOptions) -> Result<GameWorld, FileError> {
    let mut world = GameWorld::new();
    enter_gltf(&mut world, library, options, path, &[])?;
    Ok(world)
}

/// The same into a world, in place of the entities `old`.
///
/// # Errors
/// If the file cannot be read; the world keeps what it was then.
pub(in crate::files) fn enter_gltf(
    world: &mut GameWorld,
    library: &mut AssetLibrary,
    options: &LoadOptions,
    path: &Path,
    old: &[Entity],
) -> Result<(), FileError> {
    if !path.is_file() {
        return Err(crate::files::ron::document::io_error(path, "", &std::io::ErrorKind::NotFound.into()));
    }
    library.begin_load(&options.budget, options.strict);
    let whole = library.gltf(path).map_err(|e| Document::in_memory(path).asset_error(&[], Kind::Asset, &e))?;
    let (gltf, units) = imported_beside(library, &Roots::of(path, options), &whole, path)?;
    let lights = Some(conversion(library, &gltf, units, options));
    despawn(world, old);
    let name = path.file_stem().map_or("model".into(), |s| s.to_string_lossy().into_owned());
    let model = world.spawn(&name.replace('/', "_"), None);
    let file = std::path::absolute(path).unwrap_or_else(|_| path.to_owned()).display().to_string();
    let details = ModelDetails { path: file, lights: true, cameras: true, ..Default::default() };
    let components = OverrideFile { model: Some(ModelFile::Detailed(details)), ..Default::default() };
    let source = Source { components: components.clone(), origin: Origin::File, ..model_source() };
    world.ecs.entity_mut(model).insert(source);
    let take = Take { lights, cameras: true, material: None, components: &components };
    let mut nodes = Model::new(world, &gltf, model, take);
    nodes.spawn(&gltf.roots, model);
    nodes.finish();
    // The file says nothing of how bright it is to be shown.
    let mut settings = SceneSettings { auto_exposure: true, ..SceneSettings::default() };
    if let Some(clip) = gltf.clips.first() {
        settings.duration = Some(clip.duration as f32).filter(|duration| *duration > 0.0);
        let track = Track::Clip { name: clip.name.clone(), speed: 1.0, offset: 0.0, wrap: Wrap::Loop };
        world.ecs.entity_mut(model).insert(Animation { tracks: vec![track], ..Animation::default() });
    }
    world.ecs.insert_resource(settings);
    world.ecs.insert_resource(SceneInfo { description: file_name(path), ..SceneInfo::default() });
    world.set_tick(0);
    world.update();
    complete(world, path, true);
    world.update();
    Ok(())
}
