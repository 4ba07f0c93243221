//! The entity/component world: components, transform hierarchy, animation, cloning and deferred despawn.

pub mod animation;
mod components;

pub use components::*;
