//! Handles on what is animated: the tracks that place an entity move along, so that it follows the pointer.

use glam::Vec3;
use lightwell::world::Transform;
use lightwell::world::animation::{KeyValue, Target, Track};
use lightwell::world::{Animation, GameWorld};

/// What is dragged: where it is shown, its pose without animation, and its animation.
#[derive(Clone, Debug)]
pub struct Pose {
    /// As it is shown, from its parent.
    pub shown: Transform,
    /// As files hold it.
    pub rest: Transform,
    /// Its tracks.
    pub animation: Option<Animation>,
}

impl Pose {
    /// Of an entity as it stands.
    pub fn of(world: &GameWorld, entity: bevy_ecs::prelude::Entity) -> Self {
        let shown = world.ecs.get::<Transform>(entity).copied().unwrap_or_default();
        let animation = world.ecs.get::<Animation>(entity).filter(|animation| animation.playing).cloned();
        Self { shown, rest: world.rest_transform(entity), animation }
    }

    /// The same once it is shown at another place. The text says what of it the tracks do not let through.
    pub fn shown_at(&self, now: &Transform) -> (Self, Option<&'static str>) {
        let mut moved = self.clone();
        moved.shown = *now;
        if self.shown == self.rest && self.animation.is_none() {
            moved.rest = *now;
            return (moved, None);
        }
        let by = now.translation - self.shown.translation;
        let turn = now.rotation * self.shown.rotation.inverse();
        let factor = now.scale / self.shown.scale;
        moved.rest.translation += by;
        if now.rotation != self.shown.rotation {
            moved.rest.rotation = (turn * self.rest.rotation).normalize();
        }
        if now.scale != self.shown.scale && factor.is_finite() {
            moved.rest.scale *= factor;
        }
        let mut refused = None;
        for track in moved.animation.iter_mut().flat_map(|animation| &mut animation.tracks) {
            match track {
                Track::Orbit { center, .. } => *center += by,
                Track::Keys { node, target, keys, .. } if node.is_empty() => {
                    let values = keys.iter_mut().map(|(_, value)| value);
                    match target {
                        Target::Translation => values.for_each(|value| shift(value, by)),
                        Target::Scale if factor.is_finite() => values.for_each(|value| stretch(value, factor)),
                        Target::Rotation if now.rotation != self.shown.rotation => {
                            for value in values {
                                match value {
                                    KeyValue::Quaternion(q) => *q = (turn * *q).normalize(),
                                    // Angles may go round several times, which a rotation cannot tell.
                                    _ => {
                                        refused =
                                            Some("its rotation is animated by angles: change them under Animation")
                                    }
                                }
                            }
                        }
                        _ => {}
                    }
                }
                _ => {}
            }
        }
        (moved, refused)
    }
}

fn shift(value: &mut KeyValue, by: Vec3) {
    if let KeyValue::Vector(v) = value {
        *v += by;
    }
}

fn stretch(value: &mut KeyValue, factor: Vec3) {
    match value {
        KeyValue::Vector(v) => *v *= factor,
        // One number for all three.
        KeyValue::Scalar(n) if factor.min_element() == factor.max_element() => *n *= factor.x,
        KeyValue::Scalar(n) => *value = KeyValue::Vector(Vec3::splat(*n) * factor),
        _ => {}
    }
}
