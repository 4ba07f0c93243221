//! From files to a world: prefabs are put in, overrides applied, assets loaded, entities spawned.

use super::LoadOptions;
use super::document::{Document, folder_of, io_error};
use super::error::{FileError, FileErrorKind as Kind};
use super::format::*;
use super::own::{Canonical, ComponentTypes};
use super::source::{Origin, SceneInfo, Source};
use super::suggest::suggestion;
use super::tree::Step;
use super::validate::{Fault, Validator};
use crate::assets::{AssetError, AssetLibrary, Material, SkyMap};
use crate::world::{Environment, EnvironmentImage, GameWorld, SceneSettings};
use bevy_ecs::prelude::Entity;
use std::collections::{BTreeMap, HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::Arc;

/// Loads a scene file into a world of its own.
pub fn load(path: &Path, library: &mut AssetLibrary, options: &LoadOptions) -> Result<GameWorld, FileError> {
    let (document, mut file) = Document::read::<SceneFile>(path)?;
    Validator::scene(&file).map_err(|fault| fault_error(&document, *fault))?;
    canonical_entities(&document, &mut file.entities, &options.types)?;
    let info = SceneInfo::new(&document, &file);
    let image = environment_image(&document, &file.settings, library)?;
    let context = Rc::new(Context { document, materials: file.materials, is_root: true });
    let mut world = GameWorld::new();
    options.types.register(&mut world.ecs);
    world.ecs.insert_resource(options.types.clone());
    let mut loader = Loader::new(library, options, world, info, path);
    for (i, entity) in file.entities.iter().enumerate() {
        loader.entity(entity, &context, None, &[Step::Key("entities".into()), Step::Index(i)])?;
    }
    let Loader { mut world, info, .. } = loader;
    world.ecs.insert_resource(file.settings);
    if let Some(image) = image {
        world.ecs.insert_resource(image);
    }
    world.set_tick(0);
    world.ecs.insert_resource(info);
    world.update();
    Ok(world)
}

/// Reads the components of a game in a file's entities.
pub(super) fn canonical_entities(
    document: &Document,
    entities: &mut [EntityFile],
    types: &ComponentTypes,
) -> Result<(), FileError> {
    Canonical { types, document }.entities(entities, &[key("entities")]).map_err(|error| *error)
}

/// Loads the sky's image, if the settings ask for one.
pub(super) fn environment_image(
    document: &Document,
    settings: &SceneSettings,
    library: &mut AssetLibrary,
) -> Result<Option<EnvironmentImage>, FileError> {
    let Some(environment @ Environment::Image { file, rotation, intensity }) = &settings.environment else {
        return Ok(None);
    };
    let path = document.folder().join(file);
    library.note(&path);
    let map = SkyMap::load(&path, *intensity, rotation.to_radians()).map_err(|fault| {
        let at = [key("settings"), key("environment")];
        let kind = if matches!(fault, AssetError::Io { .. }) { Kind::MissingFile } else { Kind::BadValue };
        let help = "name an equirectangular .hdr or .exr file, its path relative to this scene's file";
        document.error(&at, kind, fault.to_string()).with_help(help)
    })?;
    Ok(Some(EnvironmentImage { environment: environment.clone(), map: Arc::new(map) }))
}

pub(super) fn fault_error(document: &Document, fault: Fault) -> FileError {
    let error = document.error(&fault.path, fault.kind, fault.message);
    match fault.help {
        Some(help) => error.with_help(help),
        None => error,
    }
}

fn canonical(path: &Path) -> PathBuf {
    path.canonicalize().unwrap_or_else(|_| path.to_owned())
}

/// A file that entities are read from.
pub(super) struct Context {
    pub document: Document,
    pub materials: BTreeMap<String, MaterialFile>,
    /// Whether it is the scene file itself.
    pub is_root: bool,
}

/// A prefab's file and entities.
type Prefab = (Rc<Context>, Vec<EntityFile>);

/// A prefab instance that is being spawned.
struct Level {
    overrides: BTreeMap<String, OverrideFile>,
    context: Rc<Context>,
    /// Path of the overrides in their file.
    at: Vec<Step>,
    /// Names from the instance down to the present entity.
    trail: Vec<String>,
    /// Every path met so far.
    members: Vec<String>,
}

/// The components of an entity with the files that they come from.
pub(super) struct Resolved {
    pub components: OverrideFile,
    /// File and path that give the material, and those that give the mesh or model, for errors.
    pub material: (Rc<Context>, Vec<Step>),
    pub surface: (Rc<Context>, Vec<Step>),
    origin: Origin,
    /// Children that overrides add.
    added: Vec<(Vec<EntityFile>, Rc<Context>, Vec<Step>)>,
    removed: bool,
}

pub(super) struct Loader<'a> {
    pub library: &'a mut AssetLibrary,
    pub options: &'a LoadOptions,
    pub world: GameWorld,
    pub info: SceneInfo,
    prefabs: HashMap<PathBuf, Rc<Prefab>>,
    /// Files that are being read, the scene first.
    chain: Vec<PathBuf>,
    /// Instances that the present entity is inside of, the outermost first.
    levels: Vec<Level>,
    /// Named materials by file and name.
    pub named: HashMap<(PathBuf, String), Arc<Material>>,
    /// The entity that the next one spawned is put on, if it is there already.
    pub target: Option<Entity>,
    /// Entities spawned so far.
    count: usize,
}

/// Prefabs that instance prefabs multiply; beyond this a file is taken for a mistake.
const MAX_ENTITIES: usize = 200_000;
const MAX_PREFAB_DEPTH: usize = 32;

/// The path with more steps.
pub(super) fn extended(path: &[Step], steps: &[Step]) -> Vec<Step> {
    path.iter().chain(steps).cloned().collect()
}

pub(super) fn key(name: &str) -> Step {
    Step::Key(name.to_owned())
}

impl<'a> Loader<'a> {
    /// A loader that adds to a world what the scene file at the path says.
    pub fn new(
        library: &'a mut AssetLibrary,
        options: &'a LoadOptions,
        world: GameWorld,
        info: SceneInfo,
        path: &Path,
    ) -> Self {
        Self {
            library,
            options,
            world,
            info,
            prefabs: HashMap::new(),
            chain: vec![canonical(path)],
            levels: Vec::new(),
            named: HashMap::new(),
            target: None,
            count: 0,
        }
    }
}

impl Resolved {
    /// Components that one file gives.
    pub fn of(components: OverrideFile, context: &Rc<Context>) -> Self {
        let here = (context.clone(), Vec::new());
        let (material, surface) = (here.clone(), here);
        Self { components, material, surface, origin: Origin::File, added: Vec::new(), removed: false }
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

    /// Spawns an entity, and below it those of a prefab of which it holds a copy.
    fn holder(
        &mut self,
        file: &EntityFile,
        context: &Rc<Context>,
        parent: Option<Entity>,
        at: &[Step],
        held: Option<&Prefab>,
    ) -> Result<(), FileError> {
        self.count += 1;
        if self.count > MAX_ENTITIES || self.chain.len() > MAX_PREFAB_DEPTH {
            let message =
                format!("more than {MAX_ENTITIES} entities, or prefabs nested more than {MAX_PREFAB_DEPTH} deep");
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
        Ok(())
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
            components: file.components(),
            material: here.clone(),
            surface: here,
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

    /// Spawns the entities of a prefab below the instance; gives their paths.
    fn instance(
        &mut self,
        file: &EntityFile,
        context: &Rc<Context>,
        entity: Entity,
        at: &[Step],
    ) -> Result<Vec<String>, FileError> {
        let written = file.prefab.as_deref().unwrap_or_default();
        let place = extended(at, &[key("prefab")]);
        let (path, prefab) = self.prefab(written, context, &place)?;
        self.chain.push(path);
        self.levels.push(Level {
            overrides: file.overrides.clone(),
            context: context.clone(),
            at: extended(at, &[key("overrides")]),
            trail: Vec::new(),
            members: Vec::new(),
        });
        match &file.repeat {
            None => self.prefab_entities(&prefab.0, &prefab.1, entity)?,
            Some(repeat) => {
                for index in 0..repeat.count() {
                    let name = (index + 1).to_string();
                    let holder = EntityFile { name, transform: Some(repeat.place(index)), ..Default::default() };
                    self.holder(&holder, &prefab.0, Some(entity), &[key("entities")], Some(&*prefab))?;
                }
            }
        }
        self.chain.pop();
        let level = self.levels.pop();
        let members = level.map(|l| l.members).unwrap_or_default();
        check_overrides(file, context, at, written, &members)?;
        let own: Vec<&str> = match &file.repeat {
            None => prefab.1.iter().map(|entity| entity.name.as_str()).collect(),
            Some(_) => members.iter().filter(|path| !path.contains('/')).map(String::as_str).collect(),
        };
        check_children(file, context, at, &own)?;
        Ok(members)
    }

    /// Spawns the entities of a prefab's file.
    fn prefab_entities(
        &mut self,
        context: &Rc<Context>,
        entities: &[EntityFile],
        parent: Entity,
    ) -> Result<(), FileError> {
        for (i, child) in entities.iter().enumerate() {
            self.entity(child, context, Some(parent), &[key("entities"), Step::Index(i)])?;
        }
        Ok(())
    }

    fn prefab(&mut self, written: &str, context: &Context, at: &[Step]) -> Result<(PathBuf, Rc<Prefab>), FileError> {
        let path = context.document.folder().join(written);
        let identity = canonical(&path);
        if let Some(start) = self.chain.iter().position(|p| *p == identity) {
            return Err(cycle_error(&self.chain[start..], &identity, context, at));
        }
        if let Some(known) = self.prefabs.get(&identity) {
            return Ok((identity, known.clone()));
        }
        if !path.is_file() {
            let looked = io_error(&path, "", &std::io::ErrorKind::NotFound.into());
            let message = format!("there is no prefab `{written}` (looked for {})", path.display());
            let error = context.document.error(at, Kind::MissingFile, message);
            let help = looked.help.unwrap_or_else(|| "paths of prefabs start at the folder of this file".into());
            return Err(error.with_help(help));
        }
        let (document, mut file) = Document::read::<PrefabFile>(&path)?;
        Validator::prefab(&file).map_err(|fault| fault_error(&document, *fault))?;
        canonical_entities(&document, &mut file.entities, &self.options.types)?;
        let context = Rc::new(Context { document, materials: file.materials, is_root: false });
        let prefab = Rc::new((context, file.entities));
        self.library.note(&identity);
        self.prefabs.insert(identity.clone(), prefab.clone());
        Ok((identity, prefab))
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
        c.replace_with(patch);
        if !patch.children.is_empty() {
            self.added.push((patch.children.clone(), place.0, place.1));
        }
    }
}

fn check_overrides(
    file: &EntityFile,
    context: &Context,
    at: &[Step],
    prefab: &str,
    members: &[String],
) -> Result<(), FileError> {
    let known: HashSet<&str> = members.iter().map(String::as_str).collect();
    for path in file.overrides.keys() {
        if known.contains(path.as_str()) {
            continue;
        }
        let at = extended(at, &[key("overrides"), key(path)]);
        let error = context.document.error(&at, Kind::UnknownName, format!("`{prefab}` has no entity `{path}`"));
        return Err(match suggestion(path, members.iter().map(String::as_str)) {
            Some(help) => error.with_help(help),
            None => error,
        });
    }
    Ok(())
}

/// An instance's own children must not bear the names of the prefab's.
fn check_children(file: &EntityFile, context: &Context, at: &[Step], prefab: &[&str]) -> Result<(), FileError> {
    for (i, child) in file.children.iter().enumerate() {
        if prefab.contains(&child.name.as_str()) {
            let at = extended(at, &[key("children"), Step::Index(i), key("name")]);
            let message = format!("the prefab has a child named `{}` already", child.name);
            let error = context.document.error(&at, Kind::DuplicateName, message);
            return Err(error.with_help("give it another name, or change the prefab's child under `overrides`"));
        }
    }
    Ok(())
}

fn cycle_error(chain: &[PathBuf], again: &Path, context: &Context, at: &[Step]) -> FileError {
    let names: Vec<String> =
        chain.iter().map(PathBuf::as_path).chain([again]).map(|p| short_name(p, folder_of(again))).collect();
    let message = format!("the prefab contains itself: {}", names.join(" → "));
    let error = context.document.error(at, Kind::PrefabCycle, message);
    error.with_help("take one of these instances out")
}

fn short_name(path: &Path, folder: &Path) -> String {
    path.strip_prefix(folder).unwrap_or(path).display().to_string()
}
