//! What a drag of a handle means for what is dragged.

use super::{Drag, Grip, LENGTH, Lens, Mode};
use egui::Pos2;
use glam::{Affine3A, Quat, Vec3};
use lightwell::world::Transform;
use std::f32::consts::TAU;

/// Steps: \[m\], \[rad\], factor.
const STEPS: (f32, f32, f32) = (0.1, TAU / 24.0, 0.1);

/// What a drag amounts to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Motion {
    Move(Vec3),
    Rotate(Quat),
    Scale(Vec3),
}

/// What the drag from its start to a point amounts to.
pub fn motion(drag: &Drag, lens: &Lens, at: Pos2, snap: bool) -> Option<Motion> {
    let step = |value: f32, step: f32| if snap { (value / step).round() * step } else { value };
    match (drag.mode, drag.grip) {
        (Mode::None, _) => None,
        (Mode::Move, Grip::Axis(axis)) => {
            let axis = drag.axes.col(axis);
            let by = lens.along(drag.origin, axis, at)? - lens.along(drag.origin, axis, drag.start)?;
            Some(Motion::Move(axis * step(by, STEPS.0)))
        }
        (Mode::Move, Grip::Center) => {
            let (_, normal) = lens.ray(lens.rect.center());
            let by = lens.on_plane(drag.origin, normal, at)? - lens.on_plane(drag.origin, normal, drag.start)?;
            Some(Motion::Move(by.map(|c| step(c, STEPS.0))))
        }
        (Mode::Rotate, grip) => {
            let Grip::Axis(axis) = grip else { return None };
            let axis = drag.axes.col(axis).normalize_or(Vec3::Y);
            let center = lens.point(drag.origin)?;
            let angle = |p: Pos2| (-(p - center).y).atan2((p - center).x);
            // Seen from behind, the axis turns the other way.
            let sign = if axis.dot(lens.eye.truncate() - lens.eye.w * drag.origin) >= 0.0 { 1.0 } else { -1.0 };
            let turn = (angle(at) - angle(drag.start) + TAU * 1.5).rem_euclid(TAU) - TAU * 0.5;
            Some(Motion::Rotate(Quat::from_axis_angle(axis, step(sign * turn, STEPS.1))))
        }
        (Mode::Scale, Grip::Axis(axis)) => {
            let (a, b) =
                lens.segment(drag.origin, drag.origin + drag.axes.col(axis) * lens.length(drag.origin, LENGTH))?;
            let along = (b - a).normalized();
            let factor = step(1.0 + (at - drag.start).dot(along) / LENGTH, STEPS.2).max(0.01);
            let mut scale = Vec3::ONE;
            scale[axis] = factor;
            Some(Motion::Scale(scale))
        }
        (Mode::Scale, Grip::Center) => {
            let by = at - drag.start;
            Some(Motion::Scale(Vec3::splat(step(1.0 + (by.x - by.y) / LENGTH, STEPS.2).max(0.01))))
        }
    }
}

/// The transform before, changed by a motion of the world around a point.
pub fn moved(before: &Transform, parent: &Affine3A, origin: Vec3, motion: Motion) -> Transform {
    let local_from_world = parent.inverse();
    let mut now = *before;
    match motion {
        Motion::Move(by) => now.translation += local_from_world.transform_vector3(by),
        Motion::Rotate(turn) => {
            let (_, rotation, _) = parent.to_scale_rotation_translation();
            now.rotation = (rotation.inverse() * turn * rotation * before.unit_rotation()).normalize();
            let place = parent.transform_point3(before.translation);
            now.translation = local_from_world.transform_point3(origin + turn * (place - origin));
            if (place - origin).length() < 1e-6 * (1.0 + origin.length()) {
                now.translation = before.translation;
            }
        }
        Motion::Scale(factors) => now.scale *= factors,
    }
    now
}
