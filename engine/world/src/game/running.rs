//! A game that runs.

use super::commands::{Request, Requests};
use super::current_scene::CurrentScene;
use super::draw::Draw;
use super::input::{Actions, Input, InputEvent};
use super::light::{self, LightProbe};
use super::saved::{SavedGame, SavedTypes};
use super::space::{self, NonSolid, SpatialQuery};
use super::time::Time;
use super::{GameError, fault};
use crate::assets::{AssetLibrary, LoadBudget};
use crate::core::GiMethod;
use crate::files::{self, ComponentType, EditContext, FileError, LoadOptions, Roots, SceneData, SceneFile};
use crate::world::{GameWorld, PathIdentities};
use bevy_ecs::error::FallbackErrorHandler;
use bevy_ecs::message::{Message, MessageRegistry};
use bevy_ecs::observer::IntoObserver;
use bevy_ecs::prelude::*;
use bevy_ecs::schedule::ScheduleLabel;
use bevy_ecs::system::ScheduleSystem;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Systems that run when a scene was entered, before its first step.
#[derive(ScheduleLabel, Clone, Debug, PartialEq, Eq, Hash)]
pub struct OnSceneEnter;

/// Systems that run in every step of time. All that decides the game belongs here: steps are equally long, and a
/// recorded script repeats them exactly.
#[derive(ScheduleLabel, Clone, Debug, PartialEq, Eq, Hash)]
pub struct FixedUpdate;

/// Systems that run once before a frame is drawn, after none, one or several steps: for what is only looked at, such as
/// texts and cameras.
#[derive(ScheduleLabel, Clone, Debug, PartialEq, Eq, Hash)]
pub struct Update;

/// A function that sees the world after each step.
#[derive(ScheduleLabel, Clone, Debug, PartialEq, Eq, Hash)]
struct Look;

/// An entity without a parent that stays, with all below it, when the scene changes. A scene that holds one brings
/// another one each time that it is entered: such entities are best spawned by a system.
#[derive(Component, SceneData, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Persistent;

/// A game that runs: its world, its files and its systems.
pub struct Game {
    /// Entities, components and resources.
    pub world: GameWorld,
    library: AssetLibrary,
    options: LoadOptions,
    /// The scene's file as it was read last.
    file: Option<SceneFile>,
    entering: Option<Entering>,
    edited: Option<EditedScene>,
}

/// A scene as an editor has it, which need not be in its file.
#[derive(Clone, Debug, Default)]
pub struct EditedScene {
    /// The scene's file.
    pub path: PathBuf,
    /// What that would say, as [`describe_all`](files::describe_all) gives it.
    pub scene: SceneFile,
    /// The identities of its entities by their paths, so that an editor finds them in both worlds.
    pub identities: PathIdentities,
}

impl EditedScene {
    /// The scene of a world.
    ///
    /// # Errors
    /// When the world holds something that has no form in a file.
    pub fn of(world: &GameWorld, path: &Path) -> Result<Self, FileError> {
        let scene = files::describe_all(world, path)?;
        Ok(Self { path: path.to_owned(), scene, identities: world.identities() })
    }
}

/// Changes a scene that was entered.
type Entering = Box<dyn Fn(&mut GameWorld, &Path) -> Result<(), String>>;

impl Default for Game {
    fn default() -> Self {
        Self::new()
    }
}

impl Game {
    /// A game without a scene, of 60 steps a second.
    pub fn new() -> Self {
        let mut options = LoadOptions::default();
        options.types.is_complete = true;
        let (world, library) = (GameWorld::new(), AssetLibrary::new());
        let mut game = Self { world, library, options, file: None, entering: None, edited: None };
        let ecs = &mut game.world.ecs;
        ecs.insert_resource(FallbackErrorHandler(fault::handle));
        ecs.insert_resource(Time::new(60));
        ecs.init_resource::<Schedules>();
        ecs.init_resource::<MessageRegistry>();
        ecs.init_resource::<Requests>();
        ecs.init_resource::<Input>();
        ecs.init_resource::<SpatialQuery>();
        ecs.init_resource::<CurrentScene>();
        ecs.init_resource::<Draw>();
        ecs.init_resource::<SavedTypes>();
        game.add_systems(Look, (space::update, light::update).chain());
        // No other types can have these names yet.
        let _ = game.add_component::<NonSolid>();
        let _ = game.add_component::<LightProbe>();
        let _ = game.add_component::<Persistent>();
        game
    }

    /// Folder of third-party models.
    pub fn set_models(&mut self, models: Option<PathBuf>) {
        self.options.models = models;
    }

    /// Folders that scenes may name files in, beside their own project and the models.
    pub fn set_trusted(&mut self, trusted: Vec<PathBuf>) {
        self.options.trusted = trusted;
    }

    /// Limits of a load.
    pub fn set_budget(&mut self, budget: LoadBudget) {
        self.options.budget = budget;
    }

    /// How scenes are loaded, with the components that they may hold.
    pub fn options(&self) -> &LoadOptions {
        &self.options
    }

    /// Sets the number of steps a second, at least one.
    pub fn set_rate(&mut self, rate: u32) {
        let step = self.world.ecs.resource::<Time>().step;
        self.world.ecs.insert_resource(Time::new(rate).at(step));
    }

    /// Makes a component known that scenes may hold.
    ///
    /// # Errors
    /// When another type has its name.
    pub fn add_component<C: Component + SceneData + Clone + Default>(&mut self) -> Result<(), GameError> {
        self.options.types.add(ComponentType::of::<C>())?;
        self.options.types.register(&mut self.world.ecs);
        self.world.ecs.insert_resource(self.options.types.clone());
        Ok(())
    }

    /// Adds a method of indirect light that scene files can name.
    pub fn add_method(&mut self, method: GiMethod) {
        self.options.types.add_method(method);
        self.world.ecs.insert_resource(self.options.types.clone());
    }

    /// Adds a component that is the settings of a method of indirect light.
    ///
    /// # Errors
    /// When another type has its name.
    pub fn add_method_settings<S: Component + SceneData + Clone + Default + PartialEq>(
        &mut self,
    ) -> Result<(), GameError> {
        self.options.types.add_settings::<S>()?;
        self.add_component::<S>()
    }

    /// Adds a resource that is saved with the game.
    ///
    /// # Errors
    /// When another type has its name.
    pub fn add_saved_resource<R: Resource + SceneData>(&mut self, resource: R) -> Result<(), GameError> {
        self.world.ecs.resource_mut::<SavedTypes>().add::<R>()?;
        self.world.ecs.insert_resource(resource);
        Ok(())
    }

    /// Makes a message known that systems send to each other; those of a frame are there for the next one.
    pub fn add_message<M: Message>(&mut self) {
        MessageRegistry::register_message::<M>(&mut self.world.ecs);
    }

    /// Adds systems to [`OnSceneEnter`], [`FixedUpdate`], [`Update`] or a schedule of one's own.
    pub fn add_systems<M>(&mut self, label: impl ScheduleLabel, systems: impl IntoScheduleConfigs<ScheduleSystem, M>) {
        self.world.ecs.resource_mut::<Schedules>().add_systems(label, systems);
    }

    /// Adds an observer of an event.
    pub fn add_observer<M>(&mut self, observer: impl IntoObserver<M>) {
        self.world.ecs.add_observer(observer);
    }

    /// Sets what buttons and sticks mean.
    pub fn set_actions(&mut self, actions: Actions) {
        self.world.ecs.resource_mut::<Input>().set_actions(actions);
    }

    /// Goes to a scene, from the one before or from none, and runs [`OnSceneEnter`]. All entities of the scene before go, but
    /// for those that are [`Persistent`]; resources stay.
    ///
    /// # Errors
    /// When the scene cannot be loaded, which leaves the one before as it is; or when a system fails.
    pub fn enter(&mut self, path: &Path) -> Result<(), GameError> {
        self.take_scene(path)?;
        self.begin()
    }

    /// Sets what is done with each scene that was entered, before [`OnSceneEnter`] runs: changes that a command line asks for.
    pub fn on_entering(&mut self, change: impl Fn(&mut GameWorld, &Path) -> Result<(), String> + 'static) {
        self.entering = Some(Box::new(change));
    }

    /// Enters this scene, whenever it is entered, as an editor has it and not as its file says. Assets that are loaded
    /// already are in the library.
    pub fn set_edited(&mut self, edited: EditedScene, library: AssetLibrary) {
        self.world.reserve(edited.identities.ids());
        (self.edited, self.library) = (Some(edited), library);
    }

    /// Takes scenes with components that this game does not know: they are kept as they are, and do nothing.
    pub fn allow_unknown_components(&mut self) {
        self.options.types.is_complete = false;
        self.world.ecs.insert_resource(self.options.types.clone());
    }

    fn take_scene(&mut self, path: &Path) -> Result<(), FileError> {
        let old = self.scene_roots();
        let (world, library, options) = (&mut self.world, &mut self.library, &self.options);
        self.file = match self.edited.as_ref().filter(|edited| edited.path == path) {
            Some(edited) => {
                files::enter_described(world, library, options, path, edited.scene.clone(), &old)?;
                world.take_over(&edited.identities);
                Some(edited.scene.clone())
            }
            None => Some(files::enter_scene(world, library, options, path, &old)?),
        };
        let since = self.world.ecs.resource::<Time>().step;
        self.world.ecs.insert_resource(CurrentScene { path: path.to_owned(), since });
        Ok(())
    }

    fn begin(&mut self) -> Result<(), GameError> {
        let path = self.world.ecs.resource::<CurrentScene>().path.clone();
        let changed = self.entering.as_ref().map_or(Ok(()), |change| change(&mut self.world, &path));
        self.settle();
        // Meshes and textures of the scene before, unless this one has them too.
        self.library.drop_unused();
        changed.map_err(|what| GameError::Failed(vec![what])).and(self.run(OnSceneEnter))
    }

    /// Applies changes of the scene's file since it was read, while the game runs: fields that the file changed
    /// get its values, entities that it added come, those that it dropped go. All else stays as the game has made it:
    /// other fields of the same component, resources, the state of systems. [`OnSceneEnter`] does not run.
    ///
    /// # Errors
    /// When the file or an asset that it names is faulty; the scene stays as it is then.
    pub fn reload(&mut self) -> Result<(), GameError> {
        let path = self.world.ecs.resource::<CurrentScene>().path.clone();
        // All that can be wrong is found before anything changes.
        let mut trial = self.library.clone();
        let loaded = files::load_scene(&path, &mut trial, &self.options);
        self.library.watch_also(&trial);
        loaded?;
        let now = files::read_scene(&path, &self.options)?;
        let before = self.file.as_ref().unwrap_or(&now);
        let mut context = EditContext { library: &mut self.library, options: &self.options, path: &path };
        let result = files::follow_scene(&mut self.world, &mut context, before, &now);
        self.settle();
        result?;
        // What could not be taken up is still new to the next reload.
        self.file = Some(now);
        Ok(())
    }

    /// Restarts the scene with prefabs, models and images read again, for when those have changed. Resources and what
    /// is [`Persistent`] stay.
    ///
    /// # Errors
    /// When a file is faulty, which leaves the scene as it is; or when a system fails.
    pub fn reload_all(&mut self) -> Result<(), GameError> {
        let path = self.world.ecs.resource::<CurrentScene>().path.clone();
        let library = std::mem::take(&mut self.library);
        if let Err(error) = self.take_scene(&path) {
            let failed = std::mem::replace(&mut self.library, library);
            self.library.watch_also(&failed);
            return Err(error.into());
        }
        self.begin()
    }

    /// The files that the game was made from so far, besides its scenes.
    pub fn files(&self) -> BTreeSet<PathBuf> {
        self.library.files()
    }

    /// The files on which the game depends, besides its scenes: those that it was made from, and those that were looked
    /// for and are missing.
    pub fn watched_files(&self) -> BTreeSet<PathBuf> {
        self.library.watched()
    }

    /// The world, with what an editor needs to change it while the game runs.
    pub fn parts(&mut self) -> (&mut GameWorld, &mut AssetLibrary, &LoadOptions) {
        (&mut self.world, &mut self.library, &self.options)
    }

    /// Roots that go with the scene.
    fn scene_roots(&self) -> Vec<Entity> {
        let stays = |root: &Entity| self.world.ecs.get::<Persistent>(*root).is_none();
        self.world.roots().into_iter().filter(stays).collect()
    }

    /// One step of time, with the input events that came since the step before.
    ///
    /// # Errors
    /// When systems fail or what they ask for cannot be done. The step is done nevertheless, as far as it can be.
    pub fn step(&mut self, events: &[InputEvent]) -> Result<(), GameError> {
        let time = *self.world.ecs.resource::<Time>();
        self.world.ecs.insert_resource(time.at(time.step + 1));
        self.world.ecs.resource_mut::<Input>().begin_step(events);
        self.world.ecs.resource_mut::<Draw>().begin_step();
        let result = self.run(FixedUpdate);
        self.world.ecs.resource_mut::<Draw>().end_step();
        self.settle();
        result
    }

    /// The update before a frame is drawn, so many seconds after the one before.
    ///
    /// # Errors
    /// As [`Game::step`].
    pub fn frame(&mut self, delta: f32) -> Result<(), GameError> {
        self.world.ecs.resource_mut::<Time>().delta = delta;
        self.world.ecs.resource_mut::<Draw>().begin_frame();
        let result = self.run(Update);
        self.settle();
        self.world.ecs.resource_scope(|ecs, mut registry: Mut<MessageRegistry>| {
            let tick = ecs.change_tick();
            registry.run_updates(ecs, tick);
        });
        result
    }

    /// Runs a schedule, and does what its systems ask for. One without systems is none.
    ///
    /// # Errors
    /// As [`Game::step`].
    pub fn run(&mut self, label: impl ScheduleLabel) -> Result<(), GameError> {
        // There may be no such schedule, which is fine.
        let _ = self.world.ecs.try_run_schedule(label);
        self.world.ecs.flush();
        let result = self.answer();
        let faults = fault::take();
        if faults.is_empty() { result } else { Err(GameError::Failed(faults)) }
    }

    /// Moves everything to where it is now.
    fn settle(&mut self) {
        let (time, since) = (*self.world.ecs.resource::<Time>(), self.world.ecs.resource::<CurrentScene>().since);
        let seconds = (time.step - since.min(time.step)) as f64 / f64::from(time.rate);
        let length = self.world.ecs.resource::<crate::world::SceneSettings>().duration.map(f64::from);
        let length = length.filter(|length| *length > 0.0);
        self.world.set_seconds(length.map_or(seconds, |length| seconds % length));
        self.world.update();
        let _ = self.world.ecs.try_run_schedule(Look);
    }

    fn answer(&mut self) -> Result<(), GameError> {
        let requests = std::mem::take(&mut self.world.ecs.resource_mut::<Requests>().list);
        let last_scene = requests.iter().rposition(|r| matches!(r, Request::Scene(_) | Request::Load(_)));
        let mut result = Ok(());
        for (index, request) in requests.into_iter().enumerate() {
            let answered = match request {
                Request::Prefab { entity, path, place } => self.spawn_prefab(entity, &path, place).map_err(Into::into),
                Request::Save(path) => self.save(&path),
                Request::Scene(_) | Request::Load(_) if last_scene != Some(index) => Ok(()),
                Request::Scene(path) => {
                    let scene = self.world.ecs.resource::<CurrentScene>();
                    let path = path.map_or_else(|| scene.path.clone(), |path| scene.beside(path));
                    self.enter(&path)
                }
                Request::Load(path) => self.load(&path),
            };
            result = result.and(answered);
        }
        result
    }

    fn spawn_prefab(&mut self, entity: Entity, path: &str, place: crate::world::Transform) -> Result<(), FileError> {
        let scene = self.world.ecs.resource::<CurrentScene>().path.clone();
        if self.world.ecs.get_entity(entity).is_err() {
            return Ok(());
        }
        let mut context = EditContext { library: &mut self.library, options: &self.options, path: &scene };
        let result = files::spawn_prefab_onto(&mut self.world, &mut context, entity, path, place);
        if result.is_err() {
            crate::world::despawn(&mut self.world.ecs, entity);
        }
        result
    }

    /// Writes the game's state into a file.
    ///
    /// # Errors
    /// When something has no form in a file, or the file cannot be written.
    pub fn save(&mut self, path: &Path) -> Result<(), GameError> {
        SavedGame::of(&self.world)?.write(path)
    }

    /// Continues from a saved state. [`OnSceneEnter`] does not run: the state is from later.
    ///
    /// # Errors
    /// When the file cannot be read or does not fit this game; the present state stays then.
    pub fn load(&mut self, path: &Path) -> Result<(), GameError> {
        let present = &self.world.ecs.resource::<CurrentScene>().path;
        let project = if present.as_os_str().is_empty() { path } else { present };
        let saved = SavedGame::read_within(path, &Roots::of(project, &self.options))?;
        let old = self.world.roots();
        saved.restore(path, &mut self.world, &mut self.library, &self.options, &old)?;
        // Later changes of the scene's file count from here.
        let scene = self.world.ecs.resource::<CurrentScene>().path.clone();
        self.file = files::read_scene(&scene, &self.options).ok();
        self.settle();
        Ok(())
    }

    /// Whether a system has asked for the end.
    pub fn has_ended(&self) -> bool {
        self.world.ecs.resource::<Requests>().ends
    }
}
