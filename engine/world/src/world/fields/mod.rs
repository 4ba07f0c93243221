//! Fields of components and of the scene's settings by path, such as `light.intensity`, `scene.sky` or `Coin.value` of a
//! game's own component: what key-framed tracks can change besides what they have a name for.
//!
//! A field is read and written in the text that scene files have. That is all that is known of a game's components, and
//! it keeps what a path means the same in files, in `--set` and in tracks.

mod drive;
mod held;
mod path;
mod rest_values;
#[cfg(test)]
mod tests;
pub mod text;
mod types;
mod value;

pub(super) use drive::{Wanted, drive};
pub use held::Held;
pub(super) use held::HeldFields;
pub use path::{CLOCK_FIELDS, SCENE, ron_options, split};
pub use rest_values::rest_text;
pub use types::{FieldType, FieldTypes};
pub use value::{FieldSample, expected, written};
