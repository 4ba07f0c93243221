//! The parts of a game besides its scenes: steps of time, input, prefabs at run time, change of scenes, questions to
//! the space around, and saved games. All of it is bevy's ECS: systems in three schedules, resources, messages, events
//! and observers.
//!
//! ```text
//! events ─▶ Input ─▶ FixedUpdate ─▶ requests ─▶ animation, transforms ─▶ SpatialQuery ─▶ (Update ─▶ image)
//! ```
//! [`Game`] runs without window and device; what it does depends on the steps and their events alone, so that a script
//! of recorded input plays the same game again.
//!
//! ```
//! # extern crate lightwell_world as lightwell;
//! use bevy_ecs::prelude::*;
//! use lightwell::files::SceneData;
//! use lightwell::game::{FixedUpdate, Game, Time};
//! use lightwell::world::Transform;
//!
//! /// Rises by itself.
//! #[derive(Component, SceneData, Clone, Default)]
//! struct Balloon {
//!     /// Speed \[m/s\].
//!     speed: f32,
//! }
//!
//! fn rise(time: Res<Time>, mut balloons: Query<(&Balloon, &mut Transform)>) {
//!     for (balloon, mut transform) in &mut balloons {
//!         transform.translation.y += balloon.speed * time.delta;
//!     }
//! }
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let mut game = Game::new();
//! game.add_component::<Balloon>()?;
//! game.add_systems(FixedUpdate, rise);
//! # let folder = tempfile::tempdir()?;
//! # let scene = folder.path().join("sky.scene.ron");
//! # std::fs::write(&scene, r#"Scene(entities: [(name: "Red", components: {"Balloon": (speed: 3)})])"#)?;
//! game.enter(&scene)?;
//! for _ in 0..60 {
//!     game.step(&[])?;
//! }
//! let red = game.world.find("Red").ok_or("no balloon")?;
//! let height = game.world.ecs.get::<Transform>(red).ok_or("no place")?.translation.y;
//! assert!((height - 3.0).abs() < 1e-4);
//! # Ok(()) }
//! ```

mod commands;
mod current_scene;
mod draw;
mod error;
mod fault;
mod input;
mod light;
mod probe_points;
mod running;
mod saved;
mod space;
mod time;

pub use crate::scene::ProbePoint;
pub use commands::GameCommands;
pub use current_scene::CurrentScene;
pub use draw::{Draw, DrawnLine, DrawnText};
pub use error::GameError;
pub use input::*;
pub use light::LightProbe;
pub use running::{EditedScene, FixedUpdate, Game, OnSceneEnter, Persistent, Update};
pub use saved::SavedGame;
pub use space::{Contact, Hit, NonSolid, SpatialQuery};
pub use time::{Time, Timer};
