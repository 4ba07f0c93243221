//! The rest values of animated fields.

use super::super::rest_pose::RestPose;
use super::super::{GameWorld, SceneSettings};
use super::held::{HeldFields, at_rest, own_text};
use super::path::{SCENE, split};
use bevy_ecs::prelude::*;
use serde::Serialize;
use serde::de::DeserializeOwned;

/// The settings of the scene that tracks have taken over.
#[derive(Resource, Default)]
pub(in crate::world) struct RestSettings(pub HeldFields);

impl GameWorld {
    /// The scene's settings without animation, as files hold them.
    pub fn rest_settings(&self) -> SceneSettings {
        let shown = self.ecs.get_resource::<SceneSettings>().cloned().unwrap_or_default();
        match self.ecs.get_resource::<RestSettings>() {
            Some(held) => at_rest(shown, SCENE, &held.0),
            None => shown,
        }
    }

    /// Sets the scene's settings without animation.
    pub fn set_rest_settings(&mut self, settings: SceneSettings) {
        self.ecs.insert_resource(RestSettings::default());
        self.ecs.insert_resource(settings);
    }

    /// A component without what tracks change of its fields by their paths. `name` is what files call it.
    pub fn rest_component<C>(&self, entity: Entity, name: &str) -> Option<C>
    where
        C: Component + Clone + Serialize + DeserializeOwned,
    {
        let shown = self.ecs.get::<C>(entity)?.clone();
        Some(self.without_fields(entity, name, shown))
    }

    pub(in crate::world) fn without_fields<C>(&self, entity: Entity, name: &str, shown: C) -> C
    where
        C: Serialize + DeserializeOwned,
    {
        match self.ecs.get::<RestPose>(entity) {
            Some(rest) => at_rest(shown, name, &rest.fields),
            None => shown,
        }
    }

    /// Forgets the own values of a component's fields that tracks change by their paths: what it holds now is its own.
    /// For whoever gives the component a new value.
    pub fn release_fields(&mut self, entity: Entity, name: &str) {
        let Some(mut rest) = self.ecs.get_mut::<RestPose>(entity) else { return };
        if rest.fields.keys().any(|path| split(path).0 == name) {
            rest.fields.retain(|path, _| split(path).0 != name);
        }
    }
}

/// The text of an entity's component without its tracks.
pub fn rest_text(world: &World, entity: Entity, name: &str, shown: String) -> String {
    match world.get::<RestPose>(entity) {
        Some(rest) if !rest.fields.is_empty() => own_text(&shown, name, &rest.fields),
        _ => shown,
    }
}
