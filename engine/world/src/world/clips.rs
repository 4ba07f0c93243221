//! Clips of models: which entities they move, and what they say at a time.

use super::animation::{Animation, Track};
use super::rest_pose::RestPose;
use super::sample::{Sample, Time};
use super::{Clock, Transform};
use crate::assets::{Clip, Curve, NodeCurves};
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

/// Effects of an animation on descendants of its entity.
pub(super) enum Playing<'a> {
    /// A clip at a time: it says where nodes are, by their index in the model.
    Clip { clip: &'a Clip, time: f64 },
    /// A track of keys for one entity.
    Keys { track: &'a Track, time: Time },
}

/// All animations that affect descendants of their entity, in the order of their tracks.
pub(super) fn playing<'a>(
    clock: &Clock,
    players: impl Iterator<Item = (Entity, &'a Animation, Option<&'a Clips>)>,
) -> HashMap<Entity, Vec<Playing<'a>>> {
    let of = |animation: &'a Animation, clips: Option<&'a Clips>| {
        let tracks = animation.tracks.iter().filter(|_| animation.playing);
        tracks.filter_map(|track| play(clock, animation, track, clips)).collect::<Vec<_>>()
    };
    let all = players.map(|(entity, animation, clips)| (entity, of(animation, clips)));
    all.filter(|(_, playing)| !playing.is_empty()).collect()
}

fn play<'a>(clock: &Clock, animation: &Animation, track: &'a Track, clips: Option<&'a Clips>) -> Option<Playing<'a>> {
    match track {
        Track::Clip { name, speed, offset, wrap } => {
            let clip = clips?.find(name)?;
            let (speed, offset) = (animation.speed * speed, animation.offset * speed + offset);
            let time = Time { flicks: clock.flicks(), speed, offset };
            let time = if clip.duration > 0.0 { time.within(clip.duration, *wrap) } else { 0.0 };
            Some(Playing::Clip { clip, time })
        }
        track if !track.node().is_empty() => Some(Playing::Keys { track, time: animation.time(clock) }),
        _ => None,
    }
}

/// Whom a player may mean: a node of its model, and the names by which its tracks call the entity.
#[derive(Clone, Debug, Default)]
pub(super) struct Called<'a> {
    pub node: Option<usize>,
    pub names: Vec<&'a str>,
}

/// The pose that a player gives an entity: later tracks override earlier ones.
pub(super) fn sample(playing: &[Playing], called: &Called, rest: &Transform, sample: &mut Sample) {
    for part in playing {
        match part {
            Playing::Clip { clip, time } => {
                if let Some(curves) = called.node.and_then(|node| clip.nodes.get(&node)) {
                    sample_curves(curves, *time, sample);
                }
            }
            Playing::Keys { track, time } if called.names.contains(&track.node()) => track.apply(time, rest, sample),
            Playing::Keys { .. } => {}
        }
    }
}

fn sample_curves(curves: &NodeCurves, time: f64, sample: &mut Sample) {
    let vector = |curve: &Curve| Vec3::from_slice(&curve.at(time));
    if let Some(translation) = curves.translation.as_ref().map(vector).filter(|v| v.is_finite()) {
        sample.translation = Some(translation);
    }
    if let Some(scale) = curves.scale.as_ref().map(vector).filter(|v| v.is_finite()) {
        sample.scale = Some(scale);
    }
    if let Some(curve) = &curves.rotation {
        sample.rotation = Some(Quat::from_slice(&curve.at(time)));
    }
    if let Some(found) = curves.weights.as_ref().map(|c| c.at(time)).filter(|w| w.iter().all(|x| x.is_finite())) {
        sample.weights.extend(found.into_iter().enumerate());
    }
}
