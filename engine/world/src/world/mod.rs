//! The entity/component world: components, transform hierarchy, animation, cloning and deferred despawn.
//!
//! [`GameWorld`] owns bevy's ECS. A frame is: set the clock, [`GameWorld::update`] (behaviours, animation, transform
//! propagation, deferred despawn), then [`crate::scene::Extractor::extract`].

mod animate;
pub mod animation;
mod clips;
mod clock;
mod components;
mod deform;
mod descendants;
mod entity_snapshot;
mod environment;
mod error;
pub mod fields;
mod fog;
mod from_gltf;
mod game_world;
mod hierarchy;
mod identity;
mod instant_radiosity;
mod lens;
mod light_culling;
mod method_settings;
mod particles;
mod path_identities;
mod propagate;
mod rest_edits;
mod rest_pose;
mod sample;
#[cfg(test)]
mod tests;
mod update;

pub use self::animation::Animation;
pub use clips::{ClipTarget, Clips, MorphWeights};
pub use clock::{Clock, FLICKS_PER_SECOND};
pub use components::*;
pub use deform::Posed;
pub use descendants::NotBelow;
pub use entity_snapshot::EntitySnapshot;
pub use environment::{Environment, EnvironmentImage};
pub use error::WorldError;
pub use fog::{Fog, FogShape};
pub(crate) use game_world::UpdateCount;
pub use game_world::{DespawnQueue, GameWorld};
pub(crate) use hierarchy::{clone_onto, despawn};
pub use identity::Identity;
pub use instant_radiosity::*;
pub use lens::*;
pub use light_culling::*;
pub(crate) use method_settings::SettingsReader;
pub use method_settings::{MethodSettings, MethodSettingsTypes};
pub(crate) use particles::turn_of_particle;
pub use particles::{Particle, Particles};
pub use path_identities::PathIdentities;
pub(crate) use propagate::{forward, right};
pub use rest_pose::RestPose;
pub use sample::{MaterialSample, Sample};
