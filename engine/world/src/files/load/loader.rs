//! From files to a world: prefabs are put in, overrides applied, assets loaded, entities spawned.

use super::options::LoadOptions;
use super::source::{Origin, SceneInfo, Source};
use super::tracks;
use super::trust::Roots;
use crate::assets::{AssetError, AssetLibrary, Material, SkyMap};
use crate::files::error::{FileError, FileErrorKind as Kind};
use crate::files::format::canonical::Canonical;
use crate::files::format::custom_components::ComponentTypes;
use crate::files::format::scene_file::*;
use crate::files::format::validate::Validator;
use crate::files::ron::document::Document;
use crate::files::ron::steps::{extended, fault_error, key};
use crate::files::ron::tree::Step;
use crate::world::{Environment, EnvironmentImage, GameWorld, SceneSettings};
use bevy_ecs::prelude::Entity;
use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::Arc;
use std::time::Instant;

/// Loads a scene file into a world of its own.
pub fn load(path: &Path, library: &mut AssetLibrary, options: &LoadOptions) -> Result<GameWorld, FileError> {
    let (document, mut file) = Document::read::<SceneFile>(path)?;
    Validator::scene(&file).map_err(|fault| fault_error(&document, *fault))?;
    canonical_scene(&document, &mut file, &options.types)?;
    let info = SceneInfo::new(&document, &file);
    let image = environment_image(&document, &file.settings, library, &Roots::of(path, options))?;
    let context = Rc::new(Context { document, materials: file.materials, is_root: true });
    let mut world = GameWorld::new();
    options.types.register(&mut world.ecs);
    world.ecs.insert_resource(options.types.clone());
    // Tracks of the entities may be for settings.
    world.ecs.insert_resource(file.settings);
    let mut loader = Loader::new(library, options, world, info, path);
    for (i, entity) in file.entities.iter().enumerate() {
        loader.entity(entity, &context, None, &[Step::Key("entities".into()), Step::Index(i)])?;
    }
    let Loader { mut world, info, .. } = loader;
    if let Some(image) = image {
        world.ecs.insert_resource(image);
    }
    world.set_tick(0);
    world.ecs.insert_resource(info);
    world.update();
    Ok(world)
}

/// Reads the components of a game in a scene file, and refuses a method of indirect light that is not registered.
pub(in crate::files) fn canonical_scene(
    document: &Document,
    file: &mut SceneFile,
    types: &ComponentTypes,
) -> Result<(), FileError> {
    Canonical { types, document, is_quiet: false }.method(file.gi).map_err(|error| *error)?;
    canonical_entities(document, &mut file.entities, types)
}

/// Reads the components of a game in a file's entities.
pub(in crate::files) fn canonical_entities(
    document: &Document,
    entities: &mut [EntityFile],
    types: &ComponentTypes,
) -> Result<(), FileError> {
    Canonical { types, document, is_quiet: false }.entities(entities, &[key("entities")]).map_err(|error| *error)
}

/// Loads the sky's image, if the settings ask for one.
pub(in crate::files) fn environment_image(
    document: &Document,
    settings: &SceneSettings,
    library: &mut AssetLibrary,
    roots: &Roots,
) -> Result<Option<EnvironmentImage>, FileError> {
    let Some(environment @ Environment::Image { file, rotation, intensity }) = &settings.environment else {
        return Ok(None);
    };
    let path = document.folder().join(file);
    let at = [key("settings"), key("environment")];
    roots.check("image of the sky", file, &path, document, &at)?;
    library.note(&path);
    let map = SkyMap::load(&path, *intensity, rotation.to_radians()).map_err(|fault| {
        let kind = if matches!(fault, AssetError::Io { .. }) { Kind::MissingFile } else { Kind::BadValue };
        let help = "name an equirectangular .hdr or .exr file, its path relative to this scene's file";
        document.error(&at, kind, fault.to_string()).with_help(help)
    })?;
    Ok(Some(EnvironmentImage { environment: environment.clone(), map: Arc::new(map) }))
}

pub(in crate::files) fn canonical(path: &Path) -> PathBuf {
    path.canonicalize().unwrap_or_else(|_| path.to_owned())
}

/// A file that entities are read from.
pub(in crate::files) struct Context {
    pub document: Document,
    pub materials: BTreeMap<String, MaterialFile>,
    /// Whether it is the scene file itself.
    pub is_root: bool,
}

/// A prefab's file and entities.
pub(in crate::files) type Prefab = (Rc<Context>, Vec<EntityFile>);

/// A prefab instance that is being spawned.
pub(in crate::files) struct Level {
    pub overrides: BTreeMap<String, OverrideFile>,
    pub context: Rc<Context>,
    /// Path of the overrides in their file.
    pub at: Vec<Step>,
    /// Names from the instance down to the present entity.
    pub trail: Vec<String>,
    /// Every path met so far.
    pub members: Vec<String>,
}

/// The components of an entity with the files that they come from.
pub(in crate::files) struct Resolved {
    pub components: OverrideFile,
    /// File and path that give the material, those that give the mesh or model, and the animation, for errors.
    pub material: (Rc<Context>, Vec<Step>),
    pub surface: (Rc<Context>, Vec<Step>),
    animation: (Rc<Context>, Vec<Step>),
    /// File and path that give the camera.
    pub camera: (Rc<Context>, Vec<Step>),
    origin: Origin,
    /// Children that overrides add.
    added: Vec<(Vec<EntityFile>, Rc<Context>, Vec<Step>)>,
    removed: bool,
}

pub(in crate::files) struct Loader<'a> {
    pub library: &'a mut AssetLibrary,
    pub options: &'a LoadOptions,
    pub roots: Roots,
    pub world: GameWorld,
    pub info: SceneInfo,
    pub prefabs: HashMap<PathBuf, Rc<Prefab>>,
    /// Files that are being read, the scene first.
    pub chain: Vec<PathBuf>,
    /// Instances that the present entity is inside of, the outermost first.
    pub levels: Vec<Level>,
    /// Named materials by file and name.
    pub named: HashMap<(PathBuf, String), Arc<Material>>,
    /// The entity that the next one spawned is put on, if it is there already.
    pub target: Option<Entity>,
    /// Entities spawned so far: prefabs that instance prefabs multiply.
    entities: u64,
    begun: Instant,
}

const MAX_PREFAB_DEPTH: usize = 32;

impl<'a> Loader<'a> {
    /// A loader that adds to a world what the scene file at the path says.
    pub fn new(
        library: &'a mut AssetLibrary,
        options: &'a LoadOptions,
        world: GameWorld,
        info: SceneInfo,
        path: &Path,
    ) -> Self {
        library.begin_load(&options.budget, options.strict);
        Self {
            library,
            options,
            roots: Roots::of(path, options),
            world,
            info,
            prefabs: HashMap::new(),
            chain: vec![canonical(path)],
            levels: Vec::new(),
            named: HashMap::new(),
            target: None,
            entities: 0,
            begun: Instant::now(),
        }
    }
}

impl Resolved {
    /// Components that one file gives.
    pub fn of(components: OverrideFile, context: &Rc<Context>) -> Self {
        let here = (context.clone(), Vec::new());
        let (material, surface, animation, camera) = (here.clone(), here.clone(), here.clone(), here);
        Self {
            components,
            material,
            surface,
            animation,
            camera,
            origin: Origin::File,
            added: Vec::new(),
            removed: false,
        }
    }
}

impl Loader<'_> {
    /// Spawns an entity of a file with all that belongs to it.
    pub fn entity(
        &mut self,
        file: &EntityFile,
        context: &Rc<Context>,
        parent: Option<Entity>,
        at: &[Step],
    ) -> Result<(), FileError> {
        self.holder(file, context, parent, at, None)
    }

    /// Counts entities before they are spawned.
    ///
    /// # Errors
    /// When there are more than the budget allows, or the load takes too long.
    pub(in crate::files) fn count(&mut self, more: u64, document: &Document, at: &[Step]) -> Result<(), FileError> {
        self.entities = self.entities.saturating_add(more);
        let (budget, seconds) = (&self.options.budget, self.begun.elapsed().as_secs());
        let entities = ("entities", self.entities, budget.entities);
        for (limit, total, most) in [entities, ("seconds", seconds, budget.seconds)] {
            if total > most {
                let message = format!("the load would take {total} {limit}, and at most {most} are allowed");
                let help = format!(
                    "instance fewer prefabs and models inside each other; or, if you trust this file, pass \
                     `--budget {limit}=N` with more than {total}"
                );
                return Err(document.error(at, Kind::Budget, message).with_help(help));
            }
        }
        Ok(())
    }

    /// Spawns an entity, and below it those of a prefab of which it holds a copy.
    pub(in crate::files) fn holder(
        &mut self,
        file: &EntityFile,
        context: &Rc<Context>,
        parent: Option<Entity>,
        at: &[Step],
        held: Option<&Prefab>,
    ) -> Result<(), FileError> {
        self.count(1, &context.document, at)?;
        if self.chain.len() > MAX_PREFAB_DEPTH {
            let message = format!("prefabs are nested more than {MAX_PREFAB_DEPTH} deep");
            let error = context.document.error(at, Kind::BadValue, message);
            return Err(error.with_help("instance fewer prefabs inside each other"));
        }
        for level in &mut self.levels {
            level.trail.push(file.name.clone());
            level.members.push(level.trail.join("/"));
        }
        let result = self.entity_inside(file, context, parent, at, held);
        for level in &mut self.levels {
            level.trail.pop();
        }
        result
    }

    fn entity_inside(
        &mut self,
        file: &EntityFile,
        context: &Rc<Context>,
        parent: Option<Entity>,
        at: &[Step],
        held: Option<&Prefab>,
    ) -> Result<(), FileError> {
        let resolved = self.resolve(file, context, at);
        if resolved.removed {
            return Ok(());
        }
        let entity = match self.target.take() {
            Some(entity) => self.world.spawn_onto(entity, &file.name),
            None => self.world.spawn(&file.name, parent),
        };
        let material = self.insert_components(entity, &resolved)?;
        let mut source = Source {
            components: resolved.components,
            material,
            prefab: file.prefab.clone(),
            repeat: file.repeat.clone(),
            overrides: if self.levels.is_empty() { file.overrides.clone() } else { BTreeMap::new() },
            members: Vec::new(),
            origin: resolved.origin,
        };
        if file.prefab.is_some() {
            source.members = self.instance(file, context, entity, at)?;
        }
        self.world.ecs.entity_mut(entity).insert(source);
        if let Some((context, entities)) = held {
            self.prefab_entities(context, entities, entity)?;
        }
        for (i, child) in file.children.iter().enumerate() {
            self.entity(child, context, Some(entity), &extended(at, &[key("children"), Step::Index(i)]))?;
        }
        for (children, context, at) in &resolved.added {
            self.added(entity, children, context, at)?;
        }
        let (context, at) = &resolved.animation;
        tracks::check(&self.world, entity, &context.document, at)
    }

    /// Children that an override adds belong to the file of the override: no instance's overrides reach them.
    fn added(
        &mut self,
        parent: Entity,
        children: &[EntityFile],
        context: &Rc<Context>,
        at: &[Step],
    ) -> Result<(), FileError> {
        let outer = if context.is_root { std::mem::take(&mut self.levels) } else { Vec::new() };
        let taken = context.is_root;
        let mut result = Ok(());
        for (i, child) in children.iter().enumerate() {
            let at = extended(at, &[key("children"), Step::Index(i)]);
            if self.world.child(parent, &child.name).is_some() {
                let error = context.document.error(
                    &extended(&at, &[key("name")]),
                    Kind::DuplicateName,
                    format!("the prefab has a child named `{}` there already", child.name),
                );
                result = Err(error.with_help("give the added child another name"));
            } else {
                result = self.entity(child, context, Some(parent), &at);
            }
            if result.is_err() {
                break;
            }
        }
        if taken {
            self.levels = outer;
        }
        result
    }

    /// Applies the overrides of all instances around the entity, the innermost first.
    fn resolve(&mut self, file: &EntityFile, context: &Rc<Context>, at: &[Step]) -> Resolved {
        let here = (context.clone(), at.to_vec());
        let mut resolved = Resolved {
            components: file.components().located(context),
            material: here.clone(),
            surface: here.clone(),
            animation: here.clone(),
            camera: here,
            origin: Origin::File,
            added: Vec::new(),
            removed: false,
        };
        for (depth, level) in self.levels.iter().enumerate().rev() {
            let path = level.trail.join("/");
            if depth == 0 {
                resolved.origin = Origin::Prefab {
                    path: path.clone(),
                    base: Box::new(resolved.components.clone()),
                    material_overridden: level.overrides.get(&path).is_some_and(|o| o.material.is_some()),
                };
            }
            if let Some(patch) = level.overrides.get(&path) {
                resolved.apply(patch, (level.context.clone(), extended(&level.at, &[key(&path)])));
            }
        }
        resolved
    }
}

impl Resolved {
    fn apply(&mut self, patch: &OverrideFile, place: (Rc<Context>, Vec<Step>)) {
        let c = &mut self.components;
        self.removed |= patch.remove;
        for kind in &patch.without {
            c.take_away(kind);
        }
        if patch.material.is_some() {
            self.material = place.clone();
        }
        if patch.mesh.is_some() || patch.model.is_some() {
            (c.mesh, c.model) = (None, None);
            self.surface = place.clone();
        }
        if patch.animation.is_some() {
            self.animation = place.clone();
        }
        if patch.camera.is_some() {
            self.camera = place.clone();
        }
        c.replace_with(&patch.clone().located(&place.0));
        if !patch.children.is_empty() {
            self.added.push((patch.children.clone(), place.0, place.1));
        }
    }
}
