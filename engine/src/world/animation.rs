//! Animation (to be filled).
use bevy_ecs::prelude::*;
/// Animation tracks.
#[derive(Component, Clone, Debug, Default, PartialEq)]
pub struct Animation;
