//! Components whose fields are known by path.

use super::path::ron_options;
use crate::world::{Camera, Clpv, Fog, InstantRadiosity, Light, Particles, StochasticLightCulling};
use bevy_ecs::prelude::*;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::collections::BTreeMap;
use std::sync::Arc;

type Read = Arc<dyn Fn(&World, Entity) -> Option<Result<String, ron::Error>> + Send + Sync>;
type Write = Arc<dyn Fn(&str, &mut World, Entity) -> Result<(), ron::error::SpannedError> + Send + Sync>;

/// A kind of component as text.
#[derive(Clone)]
pub struct FieldType {
    read: Read,
    write: Write,
}

impl FieldType {
    /// A kind of component, by what reads and writes its text.
    pub fn new(
        read: impl Fn(&World, Entity) -> Option<Result<String, ron::Error>> + Send + Sync + 'static,
        write: impl Fn(&str, &mut World, Entity) -> Result<(), ron::error::SpannedError> + Send + Sync + 'static,
    ) -> Self {
        Self { read: Arc::new(read), write: Arc::new(write) }
    }

    pub(in crate::world) fn of<C: Component + Serialize + DeserializeOwned>() -> Self {
        Self::new(
            |world, entity| world.get::<C>(entity).map(|value| ron_options().to_string(value)),
            |text, world, entity| {
                let value: C = ron_options().from_str(text)?;
                if let Ok(mut entity) = world.get_entity_mut(entity) {
                    entity.insert(value);
                }
                Ok(())
            },
        )
    }

    /// The text of the entity's component; none if it has none of the kind.
    pub fn text(&self, world: &World, entity: Entity) -> Option<String> {
        (self.read)(world, entity)?.ok()
    }

    pub(super) fn put(&self, text: &str, world: &mut World, entity: Entity) -> Result<(), ron::error::SpannedError> {
        (self.write)(text, world, entity)
    }
}

/// The kinds of components whose fields tracks can change by path, by their names in files.
#[derive(Resource, Clone)]
pub struct FieldTypes(BTreeMap<&'static str, FieldType>);

impl Default for FieldTypes {
    fn default() -> Self {
        Self(BTreeMap::from([
            ("light", FieldType::of::<Light>()),
            ("camera", FieldType::of::<Camera>()),
            ("clpv", FieldType::of::<Clpv>()),
            ("vpl", FieldType::of::<InstantRadiosity>()),
            ("slc", FieldType::of::<StochasticLightCulling>()),
            ("fog", FieldType::of::<Fog>()),
            ("particles", FieldType::of::<Particles>()),
        ]))
    }
}

impl FieldTypes {
    /// Adds a kind of component; one of the same name is replaced.
    pub fn add(&mut self, name: &'static str, kind: FieldType) {
        self.0.insert(name, kind);
    }

    /// The kind of a name.
    pub fn get(&self, name: &str) -> Option<&FieldType> {
        self.0.get(name)
    }

    /// Names of the kinds that an entity has.
    pub fn of(&self, world: &World, entity: Entity) -> Vec<&'static str> {
        self.0.iter().filter(|(_, kind)| (kind.read)(world, entity).is_some()).map(|(name, _)| *name).collect()
    }
}
