//! The rest values of animated fields.

use super::super::rest_pose::RestPose;
use super::super::{GameWorld, SceneSettings};
use super::{SCENE, ron_options, split, text};
use bevy_ecs::prelude::*;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::collections::BTreeMap;

/// A field that a track has taken over: the texts of its own value, and of the one that is shown in its place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Held {
    /// The field's own value.
    pub own: String,
    /// The value that the track wrote. A field that holds another one was set by someone else.
    pub shown: String,
}

/// Fields that tracks have taken over, by path.
pub(in crate::world) type HeldFields = BTreeMap<String, Held>;

/// The settings of the scene that tracks have taken over.
#[derive(Resource, Default)]
pub(in crate::world) struct RestSettings(pub HeldFields);

/// The text of a component with the own values of the fields that are held.
pub(super) fn own_text(shown: &str, component: &str, held: &HeldFields) -> String {
    let mut own = shown.to_owned();
    for (path, held) in held {
        let (name, steps) = split(path);
        if name == component && text::get(shown, &steps).is_ok_and(|now| now == held.shown) {
            // A field that is not there any more has no own value either.
            own = text::replace(&own, &steps, &held.own).unwrap_or(own);
        }
    }
    own
}

/// The value without its tracks.
fn at_rest<T: Serialize + DeserializeOwned>(shown: T, component: &str, held: &HeldFields) -> T {
    if !held.keys().any(|path| split(path).0 == component) {
        return shown;
    }
    let Ok(text) = ron_options().to_string(&shown) else { return shown };
    ron_options().from_str(&own_text(&text, component, held)).unwrap_or(shown)
}

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
