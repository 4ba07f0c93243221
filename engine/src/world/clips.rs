//! Clips of models: which entities they move, and what they say at a time.

use super::Clock;
use super::animation::{Animation, Track};
use super::rest::RestPose;
use super::sample::{Sample, Time};
use crate::assets::{Clip, Curve};
use bevy_ecs::prelude::*;
use glam::{Quat, Vec3};
use std::collections::HashMap;
use std::sync::Arc;

/// The clips of a model, on the entity that holds the model. An [`Animation`] there plays them by name.
#[derive(Component, Clone, Debug)]
pub struct Clips(pub Arc<Vec<Clip>>);

impl Clips {
    /// The clip of a name; the first for an empty name.
    pub fn find(&self, name: &str) -> Option<&Clip> {
        if name.is_empty() { self.0.first() } else { self.0.iter().find(|clip| clip.name == name) }
    }
}

/// Weights of the morph targets of the meshes on the entity or its children.
#[derive(Component, Clone, Debug, PartialEq)]
pub struct MorphWeights(pub Vec<f32>);

/// A node of a model, which the clips of the model may move.
#[derive(Component, Clone, Debug)]
#[require(RestPose)]
pub struct ClipTarget {
    /// The entity that holds the model.
    #[entities]
    pub player: Entity,
    /// Index of the node in the model.
    pub node: usize,
}

/// A clip and the time to show it at.
pub(super) struct Playing<'a> {
    clip: &'a Clip,
    time: f64,
}

/// What all entities that hold models play, in the order of their tracks.
pub(super) fn playing<'a>(
    clock: &Clock,
    players: impl Iterator<Item = (Entity, &'a Animation, &'a Clips)>,
) -> HashMap<Entity, Vec<Playing<'a>>> {
    let of = |animation: &Animation, clips: &'a Clips| {
        let tracks = animation.tracks.iter().filter(|_| animation.playing);
        tracks.filter_map(|track| play(clock, animation, track, clips)).collect()
    };
    players.map(|(entity, animation, clips)| (entity, of(animation, clips))).collect()
}

fn play<'a>(clock: &Clock, animation: &Animation, track: &Track, clips: &'a Clips) -> Option<Playing<'a>> {
    let Track::Clip { name, speed, offset, wrap } = track else { return None };
    let clip = clips.find(name)?;
    let time =
        Time { flicks: clock.flicks(), speed: animation.speed * speed, offset: animation.offset * speed + offset };
    let time = if clip.duration > 0.0 { time.within(clip.duration, *wrap) } else { 0.0 };
    Some(Playing { clip, time })
}

/// What the clips say of a node: later ones instead of earlier ones.
pub(super) fn sample(clips: &[Playing], node: usize) -> (Sample, Option<Vec<f32>>) {
    let (mut sample, mut weights) = (Sample::default(), None);
    for Playing { clip, time } in clips {
        let Some(curves) = clip.nodes.get(&node) else { continue };
        let vector = |curve: &Curve| Vec3::from_slice(&curve.at(*time));
        if let Some(translation) = curves.translation.as_ref().map(vector).filter(|v| v.is_finite()) {
            sample.translation = Some(translation);
        }
        if let Some(scale) = curves.scale.as_ref().map(vector).filter(|v| v.is_finite()) {
            sample.scale = Some(scale);
        }
        if let Some(curve) = &curves.rotation {
            sample.rotation = Some(Quat::from_slice(&curve.at(*time)));
        }
        if let Some(found) = curves.weights.as_ref().map(|c| c.at(*time)).filter(|w| w.iter().all(|x| x.is_finite())) {
            weights = Some(found);
        }
    }
    (sample, weights)
}
