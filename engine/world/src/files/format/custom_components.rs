//! Components of a game in scene files: `components: {"Coin": (value: 5)}`.
//!
//! A game registers its types in [`ComponentTypes`], which travels with [`LoadOptions`](crate::files::load::options::LoadOptions) and then
//! with the world. `serde` defines the form of such a type in files, and its documentation comments are the help of the
//! inspector: both come with `#[derive(SceneData)]`.

use super::scene_data::{SceneData, TypeNote};
use crate::core::GiMethod;
use crate::files::ron::document::ron_options;
use crate::files::ron::tree::Node;
use crate::world::MethodSettingsTypes;
use crate::world::fields::{FieldType, FieldTypes, rest_text};
use bevy_ecs::component::Component;
use bevy_ecs::prelude::{Entity, Resource, World};
use ron::error::SpannedError;
use ron::value::RawValue;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::any::TypeId;
use std::collections::BTreeMap;

/// A value of a game's component as it is written, which only the game can read.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct CustomValue(pub(in crate::files) String);

impl CustomValue {
    /// Of a text in RON.
    pub fn new(text: impl Into<String>) -> Self {
        Self(text.into())
    }

    /// The text.
    pub fn text(&self) -> &str {
        &self.0
    }
}

impl Serialize for CustomValue {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        RawValue::from_ron(&self.0).map_err(serde::ser::Error::custom)?.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for CustomValue {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Ok(Self(Box::<RawValue>::deserialize(deserializer)?.trim().get_ron().to_owned()))
    }
}

/// Components of a game by their name in files.
pub type CustomComponents = BTreeMap<String, CustomValue>;

/// A component of a game that scene files can hold.
#[derive(Clone)]
pub struct ComponentType {
    /// Name in files.
    pub name: &'static str,
    /// Its documentation.
    pub notes: Vec<TypeNote>,
    type_id: TypeId,
    type_name: &'static str,
    /// The text of a value as the game writes it.
    pub(in crate::files) canonical: fn(&str) -> Result<String, SpannedError>,
    starter: fn() -> Result<String, ron::Error>,
    put: fn(&str, &mut World, Entity) -> Result<(), SpannedError>,
    text: fn(&World, Entity) -> Option<Result<String, ron::Error>>,
    take: fn(&mut World, Entity),
    register: fn(&mut World),
}

impl std::fmt::Debug for ComponentType {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.type_name)
    }
}

impl ComponentType {
    /// The component of a type.
    pub fn of<C: Component + SceneData + Clone + Default>() -> Self {
        let mut notes = Vec::new();
        C::describe(&mut notes);
        Self {
            name: C::NAME,
            notes,
            type_id: TypeId::of::<C>(),
            type_name: std::any::type_name::<C>(),
            canonical: |text| {
                let value: C = ron_options().from_str(text)?;
                ron_options().to_string(&value).map_err(unspanned)
            },
            starter: || ron_options().to_string(&C::default()),
            put: |text, world, entity| {
                let value: C = ron_options().from_str(text)?;
                if let Ok(mut entity) = world.get_entity_mut(entity) {
                    entity.insert(value);
                }
                Ok(())
            },
            text: |world, entity| world.get::<C>(entity).map(|value| ron_options().to_string(value)),
            take: |world, entity| {
                if let Ok(mut entity) = world.get_entity_mut(entity) {
                    entity.remove::<C>();
                }
            },
            register: |world| {
                world.register_component::<C>();
            },
        }
    }

    /// A value to begin with, as a file would say it: the type's default.
    ///
    /// # Errors
    /// When the default has no form in RON.
    pub fn starter(&self) -> Result<String, ron::Error> {
        (self.starter)()
    }

    /// The entity's value as a file would say it; none if it has no such component.
    ///
    /// # Errors
    /// When the value has no form in RON.
    pub fn text_of(&self, world: &World, entity: Entity) -> Option<Result<String, ron::Error>> {
        (self.text)(world, entity)
    }

    /// Whether a text is such a value.
    ///
    /// # Errors
    /// When it is not: why.
    pub fn check(&self, text: &str) -> Result<(), SpannedError> {
        (self.canonical)(text).map(drop)
    }

    /// Puts a value on the entity that is written as in a file.
    ///
    /// # Errors
    /// When the text is no such value.
    pub fn insert(&self, text: &str, world: &mut World, entity: Entity) -> Result<(), SpannedError> {
        (self.put)(text, world, entity)
    }
}

fn unspanned(code: ron::Error) -> SpannedError {
    let start = ron::error::Position { line: 1, col: 1 };
    SpannedError { code, span: ron::error::Span { start, end: start } }
}

/// Why a type was not registered.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("two types are named `{name}` in scene files, `{first}` and `{second}`: rename one of them")]
pub struct DuplicateType {
    /// The name.
    pub name: &'static str,
    /// The type that has it.
    pub first: &'static str,
    /// The type that was to get it.
    pub second: &'static str,
}

/// The components and methods of indirect light of a game that scene files can name.
#[derive(Resource, Clone, Debug, Default)]
pub struct ComponentTypes {
    types: BTreeMap<&'static str, ComponentType>,
    methods: Vec<GiMethod>,
    settings: MethodSettingsTypes,
    /// Whether a component that is not among them is an error; else it is kept as it is written.
    pub is_complete: bool,
}

impl ComponentTypes {
    /// Adds a component. Twice is once.
    ///
    /// # Errors
    /// When another type has its name.
    pub fn add(&mut self, new: ComponentType) -> Result<(), DuplicateType> {
        match self.types.get(new.name).filter(|known| known.type_id != new.type_id) {
            Some(known) => Err(DuplicateType { name: new.name, first: known.type_name, second: new.type_name }),
            None => {
                self.types.insert(new.name, new);
                Ok(())
            }
        }
    }

    /// Adds a method of indirect light that scene files can name beside those of the engine.
    pub fn add_method(&mut self, method: GiMethod) {
        if !self.methods.contains(&method) {
            self.methods.push(method);
        }
    }

    /// Adds a component that is the settings of a method: the renderer's scene holds it for
    /// [`MethodSettings::get`](crate::world::MethodSettings::get).
    ///
    /// # Errors
    /// When another type has its name.
    pub fn add_settings<S: Component + SceneData + Clone + Default + PartialEq>(
        &mut self,
    ) -> Result<(), DuplicateType> {
        self.settings.add::<S>();
        self.add(ComponentType::of::<S>())
    }

    /// The methods of indirect light that scene files can name. The path tracer is none of them: it is a choice of the command
    /// line.
    pub fn methods(&self) -> impl Iterator<Item = GiMethod> + '_ {
        [GiMethod::NONE, GiMethod::CLPV, GiMethod::VPL, GiMethod::SLC].into_iter().chain(self.methods.iter().copied())
    }

    /// The component of a name.
    pub fn get(&self, name: &str) -> Option<&ComponentType> {
        self.types.get(name)
    }

    /// All components, by name.
    pub fn iter(&self) -> impl Iterator<Item = &ComponentType> {
        self.types.values()
    }

    /// Puts the components on an entity; those that are not known are passed over.
    pub(in crate::files) fn put(
        &self,
        components: &CustomComponents,
        world: &mut World,
        entity: Entity,
    ) -> Result<(), String> {
        for (name, value) in components {
            let Some(known) = self.get(name) else { continue };
            (known.put)(value.text(), world, entity).map_err(|error| format!("`{name}`: {}", error.code))?;
        }
        Ok(())
    }

    /// Takes a component away.
    pub(in crate::files) fn take(&self, name: &str, world: &mut World, entity: Entity) {
        if let Some(known) = self.get(name) {
            (known.take)(world, entity);
        }
    }

    /// The entity's components as a file says them: those that are not known as they were described.
    pub(in crate::files) fn describe(
        &self,
        world: &World,
        entity: Entity,
        described: &CustomComponents,
    ) -> Result<CustomComponents, String> {
        let unknown = described.iter().filter(|(name, _)| self.get(name).is_none());
        let mut now: CustomComponents = unknown.map(|(name, value)| (name.clone(), value.clone())).collect();
        for known in self.iter() {
            let Some(text) = (known.text)(world, entity) else { continue };
            let text = text.map_err(|error| format!("`{}` has a value that cannot be written: {error}", known.name))?;
            let text = rest_text(world, entity, known.name, text);
            now.insert(known.name.to_owned(), CustomValue(text));
        }
        Ok(now)
    }

    /// Registers all in a world, so that it can be queried by shared reference and keyed by tracks.
    pub fn register(&self, world: &mut World) {
        self.iter().for_each(|known| (known.register)(world));
        world.insert_resource(self.settings.clone());
        let mut fields = world.get_resource_or_init::<FieldTypes>();
        for known in self.iter() {
            fields.add(known.name, FieldType::new(known.text, known.put));
        }
    }

    /// How the defaults look in a file.
    pub(in crate::files) fn defaults(&self) -> BTreeMap<&'static str, Node> {
        let parse = |known: &ComponentType| Some((known.name, Node::parse(&known.starter().ok()?)));
        self.iter().filter_map(parse).collect()
    }
}
