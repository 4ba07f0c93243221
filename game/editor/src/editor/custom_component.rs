//! Components of a game in the inspector.

use super::schema::Shape;
use super::value::Value;
use lightwell::files::{SceneData, TypeNote};

/// What the inspector knows of a component of a game.
#[derive(Clone, Debug)]
pub struct CustomComponent {
    /// Its name in files.
    pub(crate) name: &'static str,
    /// What its values are made of.
    pub(crate) shape: Shape,
    /// What its comments say.
    pub(crate) notes: Vec<TypeNote>,
}

impl CustomComponent {
    /// What the type itself says.
    pub fn of<C: SceneData>() -> Self {
        let mut notes = Vec::new();
        C::describe(&mut notes);
        Self { name: C::NAME, shape: Shape::of::<C>(), notes }
    }
}

/// The field of an entity's description that holds them.
pub const FIELD: &str = "components";

/// The value of one of them, from an entity's description.
pub fn get(description: &Value, name: &str) -> Option<Value> {
    description.field(FIELD)?.field(&quoted(name)).cloned()
}

/// Sets the value of one of them; none takes it away.
pub fn set(description: &mut Value, name: &str, value: Option<Value>) {
    let mut all = description.field(FIELD).cloned().or_else(|| Value::parse("{}")).unwrap_or_default();
    match value {
        Some(value) => all.set(&quoted(name), value),
        None => all.remove(&quoted(name)),
    }
    match all.items().is_empty() {
        true => description.remove(FIELD),
        false => description.set(FIELD, all),
    }
}

/// Keys of maps stand in quotes.
pub fn quoted(name: &str) -> String {
    format!("\"{name}\"")
}
