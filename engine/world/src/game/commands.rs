//! Requests of systems to the game as a whole. They are carried out after the schedule.

use crate::world::Transform;
use crate::world::clone_onto;
use bevy_ecs::prelude::*;
use bevy_ecs::system::EntityCommands;
use std::path::PathBuf;

/// A thing that needs the game's files.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Request {
    /// Put an instance of a prefab on an entity.
    Prefab { entity: Entity, path: String, place: Transform },
    /// Go to another scene; none: restart the present one.
    Scene(Option<PathBuf>),
    /// Write a saved game.
    Save(PathBuf),
    /// Go on with a saved game.
    Load(PathBuf),
}

/// The requests since the last step.
#[derive(Resource, Debug, Default)]
pub(super) struct Requests {
    pub list: Vec<Request>,
    pub ends: bool,
}

/// Requests to the game through bevy's [`Commands`].
pub trait GameCommands {
    /// Spawns an instance of a prefab; its path is relative to the scene's file. Components given to it here stay; the
    /// prefab's entities are below it from the next step on.
    fn spawn_prefab(&mut self, path: &str, place: Transform) -> EntityCommands<'_>;

    /// Spawns a copy of an entity with all below it, under the same parent.
    fn clone_subtree(&mut self, entity: Entity) -> EntityCommands<'_>;

    /// Goes to another scene; its path is relative to the present one. What has [`Persistent`](super::Persistent) and the
    /// resources stay, and [`OnSceneEnter`](super::OnSceneEnter) runs. Of several in one step the last one counts.
    fn change_scene(&mut self, path: impl Into<PathBuf>);

    /// Restarts the present scene.
    fn restart_scene(&mut self);

    /// Writes the game's state into a file, see [`SavedGame`](super::SavedGame).
    fn save_game(&mut self, path: impl Into<PathBuf>);

    /// Continues from a saved state.
    fn load_game(&mut self, path: impl Into<PathBuf>);

    /// Ends the game after this step.
    fn quit(&mut self);
}

impl GameCommands for Commands<'_, '_> {
    fn spawn_prefab(&mut self, path: &str, place: Transform) -> EntityCommands<'_> {
        let entity = self.spawn(place).id();
        ask(self, Request::Prefab { entity, path: path.to_owned(), place });
        self.entity(entity)
    }

    fn clone_subtree(&mut self, entity: Entity) -> EntityCommands<'_> {
        let copy = self.spawn_empty().id();
        self.queue(move |world: &mut World| -> Result<()> { Ok(clone_onto(world, entity, copy)?) });
        self.entity(copy)
    }

    fn change_scene(&mut self, path: impl Into<PathBuf>) {
        ask(self, Request::Scene(Some(path.into())));
    }

    fn restart_scene(&mut self) {
        ask(self, Request::Scene(None));
    }

    fn save_game(&mut self, path: impl Into<PathBuf>) {
        ask(self, Request::Save(path.into()));
    }

    fn load_game(&mut self, path: impl Into<PathBuf>) {
        ask(self, Request::Load(path.into()));
    }

    fn quit(&mut self) {
        self.queue(|world: &mut World| world.get_resource_or_init::<Requests>().ends = true);
    }
}

fn ask(commands: &mut Commands, request: Request) {
    commands.queue(move |world: &mut World| world.get_resource_or_init::<Requests>().list.push(request));
}
