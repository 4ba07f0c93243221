//! Settings of a game's method of indirect light: a component, which the scene holds for the renderer by its type.

use super::Identity;
use bevy_ecs::prelude::{Component, QueryState, Resource, World};
use std::any::{Any, TypeId, type_name};
use std::collections::BTreeMap;
use std::fmt;
use std::sync::Arc;

/// The types of components that the renderer's scene holds for methods of a game.
#[derive(Resource, Clone, Debug, Default)]
pub struct MethodSettingsTypes(BTreeMap<TypeId, SettingsType>);

/// A type of settings, and how it is read out of a world.
#[derive(Clone, Copy)]
struct SettingsType {
    name: &'static str,
    reader: fn(&mut World) -> Box<dyn SettingsReader>,
}

impl fmt::Debug for SettingsType {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name)
    }
}

impl MethodSettingsTypes {
    /// Adds a type. Adding it twice has no further effect.
    pub fn add<S: Component + Clone + PartialEq>(&mut self) {
        let reader = |world: &mut World| Box::new(Reader::<S>(world.query())) as Box<dyn SettingsReader>;
        self.0.insert(TypeId::of::<S>(), SettingsType { name: type_name::<S>(), reader });
    }

    /// Whether it holds no type.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Number of types. Types are never removed.
    pub(crate) fn count(&self) -> usize {
        self.0.len()
    }

    /// Readers of all types.
    pub(crate) fn readers(&self, world: &mut World) -> Vec<Box<dyn SettingsReader>> {
        self.0.values().map(|settings| (settings.reader)(world)).collect()
    }
}

/// Reads settings of one type out of a world.
pub(crate) trait SettingsReader: Send + Sync {
    /// Updates the settings from the world's first component by identity; returns whether they changed.
    fn update(&mut self, world: &World, settings: &mut MethodSettings) -> bool;
}

struct Reader<S: Component>(QueryState<(&'static Identity, &'static S)>);

impl<S: Component + Clone + PartialEq> SettingsReader for Reader<S> {
    fn update(&mut self, world: &World, settings: &mut MethodSettings) -> bool {
        let first = self.0.iter(world).min_by_key(|(identity, _)| **identity).map(|(_, value)| value);
        if first == settings.get::<S>() {
            return false;
        }
        match first {
            Some(value) => drop(settings.0.insert(TypeId::of::<S>(), Arc::new(value.clone()))),
            None => drop(settings.0.remove(&TypeId::of::<S>())),
        }
        true
    }
}

/// Settings of a game's methods, one of each type.
#[derive(Clone, Default)]
pub struct MethodSettings(BTreeMap<TypeId, Arc<dyn Any + Send + Sync>>);

impl MethodSettings {
    /// The settings of a type, if the world has any.
    pub fn get<S: Any>(&self) -> Option<&S> {
        self.0.get(&TypeId::of::<S>())?.downcast_ref()
    }
}

impl fmt::Debug for MethodSettings {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "settings of {} methods", self.0.len())
    }
}
