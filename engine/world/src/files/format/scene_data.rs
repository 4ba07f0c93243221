//! Types whose values scene files can hold, with their documentation for the inspector.

use serde::Serialize;
use serde::de::DeserializeOwned;

pub use lightwell_derive::SceneData;

/// Data that scene files can hold and an inspector can show: implemented by `#[derive(SceneData)]`, for components of a
/// game, for resources that are saved with it, and for types of their fields.
///
/// Documentation comments become the help of the inspector. A unit in brackets, `\[m\]` or `\[degrees\]`, and a range,
/// `0 to 10` or `0..1`, are understood as such.
///
/// ```
/// # extern crate lightwell_world as lightwell;
/// use bevy_ecs::prelude::Component;
/// use lightwell::files::SceneData;
///
/// /// Gives points to who collects it.
/// #[derive(Component, SceneData, Clone, Default)]
/// struct Coin {
///     /// Points, 0 to 100.
///     value: u32,
/// }
/// ```
///
/// Without the derive a type is refused by the compiler, with what to add:
///
/// ```compile_fail,E0277
/// # extern crate lightwell_world as lightwell;
/// #[derive(bevy_ecs::prelude::Component, Clone, Default)]
/// struct Bare;
///
/// lightwell::game::Game::new().add_component::<Bare>();
/// ```
///
/// So is a generic type, which would be many under one name:
///
/// ```compile_fail
/// # extern crate lightwell_world as lightwell;
/// use lightwell::files::SceneData;
///
/// #[derive(SceneData, Clone, Default)]
/// struct Pair<T>(T, T);
/// ```
#[diagnostic::on_unimplemented(
    message = "`{Self}` cannot stand in scene files",
    note = "add `#[derive(SceneData)]` to it, next to `Component` (or `Resource`), `Clone` and `Default`"
)]
pub trait SceneData: Serialize + DeserializeOwned + 'static {
    /// The name in files.
    const NAME: &'static str;

    /// Adds what the comments say of the type, its fields, and theirs.
    fn describe(notes: &mut Vec<TypeNote>);
}

/// The documentation of a type, a field or a variant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TypeNote {
    /// `Type`, `Type.field`, `Enum.Variant` or `Enum.Variant.field`.
    pub key: &'static str,
    /// The comment.
    pub help: &'static str,
}

macro_rules! as_its_content {
    ($($container:ty),*) => {
        $(impl<T: SceneData> SceneData for $container {
            const NAME: &'static str = T::NAME;
            fn describe(notes: &mut Vec<TypeNote>) {
                T::describe(notes);
            }
        })*
    };
}
as_its_content!(Option<T>, Vec<T>, Box<T>);
