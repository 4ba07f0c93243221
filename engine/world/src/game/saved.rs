//! Saved games: the world as a scene file would say it, with the resources that were marked for it.

use super::GameError;
use super::current_scene::CurrentScene;
use super::time::Time;
use crate::assets::AssetLibrary;
use crate::files::{
    self, CustomValue, Document, DuplicateType, FileError, FileErrorKind, LoadOptions, Roots, SceneData, SceneFile,
    Step, ron_options,
};
use crate::world::GameWorld;
use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};
use std::any::{TypeId, type_name};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The last step that a game may be saved in: up to there times are exact.
const MOST_STEPS: u64 = 1 << 53;

/// How a resource is written and read.
#[derive(Clone)]
struct SavedType {
    id: TypeId,
    type_name: &'static str,
    text: fn(&World) -> Option<Result<String, ron::Error>>,
    check: fn(&str) -> Result<(), String>,
    put: fn(&str, &mut World) -> Result<(), String>,
}

/// The resources that are saved, by their name.
#[derive(Resource, Clone, Default)]
pub(super) struct SavedTypes(BTreeMap<&'static str, SavedType>);

impl SavedTypes {
    pub fn add<R: Resource + SceneData>(&mut self) -> Result<(), DuplicateType> {
        let id = TypeId::of::<R>();
        let new = SavedType {
            id,
            type_name: type_name::<R>(),
            text: |world| world.get_resource::<R>().map(|value| ron_options().to_string(value)),
            check: |text| read::<R>(text).map(drop),
            put: |text, world| {
                world.insert_resource(read::<R>(text)?);
                Ok(())
            },
        };
        match self.0.get(R::NAME).filter(|known| known.id != id) {
            Some(known) => Err(DuplicateType { name: R::NAME, first: known.type_name, second: new.type_name }),
            None => {
                self.0.insert(R::NAME, new);
                Ok(())
            }
        }
    }
}

fn read<R: SceneData>(text: &str) -> Result<R, String> {
    ron_options().from_str(text).map_err(|error| error.code.to_string())
}

/// A saved game: its scene, the step that it was in, the resources that belong to it, and all entities as they stood.
///
/// Everything that a scene file can hold is saved: places, lights, shapes, materials, prefab instances with what has changed of
/// them, and the registered components. Components of other types are not.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename = "SavedGame")]
pub struct SavedGame {
    /// The scene's file.
    pub scene: PathBuf,
    /// The step of the game.
    pub step: u64,
    /// The step in which the scene was entered.
    pub scene_since: u64,
    /// Resources by their name.
    pub resources: BTreeMap<String, CustomValue>,
    /// All entities, with settings and materials.
    pub world: SceneFile,
}

impl SavedGame {
    /// The present state.
    ///
    /// # Errors
    /// When something has no form in a file.
    pub fn of(world: &GameWorld) -> Result<Self, GameError> {
        let scene = world.ecs.get_resource::<CurrentScene>().cloned().unwrap_or_default();
        let mut resources = BTreeMap::new();
        for (name, saved) in world.ecs.get_resource::<SavedTypes>().into_iter().flat_map(|types| &types.0) {
            let Some(text) = (saved.text)(&world.ecs) else { continue };
            let text = text.map_err(|error| {
                FileError::new(&scene.path, FileErrorKind::Unsavable, format!("the resource `{name}`: {error}"))
            })?;
            resources.insert((*name).to_owned(), CustomValue::new(text));
        }
        let step = world.ecs.get_resource::<Time>().map_or(0, |time| time.step);
        let file = files::describe_all(world, &scene.path)?;
        Ok(Self { scene: scene.path, step, scene_since: scene.since, resources, world: file })
    }

    /// Writes it, in one step; the file before is kept as `NAME.bak`.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), GameError> {
        let pretty = ron::ser::PrettyConfig::new().depth_limit(4);
        let text = ron_options()
            .to_string_pretty(self, pretty)
            .map_err(|error| FileError::new(path, FileErrorKind::Unsavable, error.to_string()))?;
        Ok(files::write_atomically(path, &text)?)
    }

    /// Reads one.
    ///
    /// # Errors
    /// When there is none, or it is not of this form.
    pub fn read(path: &Path) -> Result<Self, GameError> {
        let (document, saved) = Document::read::<Self>(path)?;
        saved.check(&document)?;
        Ok(saved)
    }

    /// Checks the numbers that a restored game counts on from.
    fn check(&self, document: &Document) -> Result<(), FileError> {
        let wrong =
            |key: &str, message: String| document.error(&[Step::Key(key.into())], FileErrorKind::BadValue, message);
        if self.step > MOST_STEPS {
            return Err(wrong("step", format!("step {} is beyond the last one, {MOST_STEPS}", self.step)));
        }
        if self.scene_since > self.step {
            return Err(wrong("scene_since", format!("step {} comes after `step: {}`", self.scene_since, self.step)));
        }
        Ok(())
    }

    /// Reads one whose scene lies below some folders.
    ///
    /// # Errors
    /// As [`SavedGame::read`], and when the scene lies elsewhere.
    pub(super) fn read_within(path: &Path, roots: &Roots) -> Result<Self, GameError> {
        let (document, saved) = Document::read::<Self>(path)?;
        saved.check(&document)?;
        let written = saved.scene.display().to_string();
        roots.check("scene", &written, &saved.scene, &document, &[Step::Key("scene".into())])?;
        Ok(saved)
    }

    /// Makes the world what was saved; the entities `old` go.
    pub(super) fn restore(
        self,
        path: &Path,
        world: &mut GameWorld,
        library: &mut AssetLibrary,
        options: &LoadOptions,
        old: &[Entity],
    ) -> Result<(), GameError> {
        let types = world.ecs.get_resource::<SavedTypes>().cloned().unwrap_or_default();
        let wrong = |name: &str, what: String| {
            let message = format!("the resource `{name}`: {what}");
            FileError::new(path, FileErrorKind::BadValue, message)
                .with_help("the file is of another version of the game")
        };
        for (name, value) in &self.resources {
            let Some(known) = types.0.get(name.as_str()) else {
                return Err(wrong(name, "the game has none of that name".into()).into());
            };
            (known.check)(value.text()).map_err(|what| wrong(name, what))?;
        }
        // What the saved game holds is at fault, not the file of its scene.
        let in_saved = |mut error: FileError| {
            if error.file == self.scene {
                error.file = path.to_owned();
            }
            error
        };
        files::enter_described(world, library, options, &self.scene, self.world, old).map_err(in_saved)?;
        for (name, value) in &self.resources {
            let Some(known) = types.0.get(name.as_str()) else { continue };
            (known.put)(value.text(), &mut world.ecs).map_err(|what| wrong(name, what))?;
        }
        let time = *world.ecs.resource::<Time>();
        world.ecs.insert_resource(time.at(self.step));
        world.ecs.insert_resource(CurrentScene { path: self.scene, since: self.scene_since });
        Ok(())
    }
}
