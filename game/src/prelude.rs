//! What most games need: `use lightwell_game::prelude::*;`.
//!
//! `bevy_ecs` and `lightwell` themselves are in it, so that derives find them without a line in `Cargo.toml`.

pub use crate::{App, Hud, Outcome, Pictures, Sounds, run};
pub use bevy_ecs;
pub use bevy_ecs::prelude::*;
pub use egui::Align2;
pub use glam::{Quat, Vec2, Vec3};
pub use lightwell;
pub use lightwell::files::SceneData;
pub use lightwell::game::{
    Actions, Button, Contact, CurrentScene, Draw, FixedUpdate, Game, GameCommands, Hit, Input, InputEvent, InputScript,
    Key, LightProbe, MouseButton, NonSolid, OnSceneEnter, PadButton, Persistent, SpatialQuery, Stick, Time, Timer,
    Update,
};
pub use lightwell::world::{
    Camera, Fog, FogShape, GlobalTransform, Light, LightKind, MeshRenderer, Name, Particles, Projection, Transform,
};
