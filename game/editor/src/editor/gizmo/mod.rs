//! Handles in the view that move, rotate and scale the selection.

mod animated;
mod lens;
mod motion;

pub use lens::Lens;

use super::Editor;
use super::stage::Stage;
use animated::Pose;
use egui::{Color32, Painter, Pos2, Rect, Response, Stroke, Ui};
use glam::{Affine3A, Mat3, Vec3};
use lightwell::scene::SceneId;
use lightwell::world::GlobalTransform;
use motion::{Motion, motion, moved};
use std::f32::consts::TAU;

/// Which handles are shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mode {
    /// None.
    None,
    /// Arrows.
    #[default]
    Move,
    /// Rings.
    Rotate,
    /// Bars with knobs.
    Scale,
}

/// Length of a handle \[points\].
const LENGTH: f32 = 80.0;
/// Distance at which a handle is hit \[points\].
const NEAR: f32 = 8.0;
const COLORS: [Color32; 3] =
    [Color32::from_rgb(240, 80, 80), Color32::from_rgb(110, 210, 90), Color32::from_rgb(90, 150, 255)];

/// Which part of the handles is held.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Grip {
    Axis(usize),
    /// In the plane of the screen; for scale: all axes alike.
    Center,
}

/// A drag that goes on.
#[derive(Clone, Debug)]
pub struct Drag {
    mode: Mode,
    grip: Grip,
    origin: Vec3,
    axes: Mat3,
    start: Pos2,
    /// What is dragged: its own pose before, and where its parent stands.
    parts: Vec<(SceneId, Pose, Affine3A)>,
}

/// Shows the handles and follows a drag; true if the mouse is theirs.
pub fn show(
    ui: &Ui,
    painter: &Painter,
    editor: &mut Editor,
    stage: &mut Stage,
    lens: &Lens,
    response: &Response,
) -> bool {
    let mode = editor.view.mode;
    let Some((origin, axes)) = seat(editor, stage, mode).filter(|_| mode != Mode::None) else {
        editor.view.drag = None;
        return false;
    };
    let pointer = ui.input(|i| i.pointer.interact_pos().or(i.pointer.hover_pos()));
    let over = pointer.filter(|_| response.contains_pointer()).and_then(|at| grip_at(lens, mode, origin, &axes, at));
    if response.drag_started_by(egui::PointerButton::Primary) {
        let start = ui.input(|i| i.pointer.press_origin());
        let grip = start.and_then(|at| Some((at, grip_at(lens, mode, origin, &axes, at)?)));
        if let Some((start, grip)) = grip {
            let parts = parts(editor, stage);
            editor.view.drag = Some(Drag { mode, grip, origin, axes, start, parts });
        }
    }
    let held = editor.view.drag.as_ref().map(|drag| drag.grip).or(over);
    draw(painter, lens, mode, origin, &axes, held);
    let Some(drag) = editor.view.drag.clone() else { return false };
    // The last part of the way may come in the same frame as the end.
    let primary = egui::PointerButton::Primary;
    let goes_on = response.dragged_by(primary) || response.drag_stopped_by(primary);
    if let Some(at) = pointer.filter(|_| goes_on) {
        let snap = editor.view.snap != ui.input(|i| i.modifiers.command);
        if let Some(motion) = motion(&drag, lens, at, snap) {
            let result = apply(editor, stage, &drag, motion);
            editor.told(result);
        }
    }
    if response.drag_stopped() || !ui.input(|i| i.pointer.any_down()) {
        editor.view.drag = None;
    }
    true
}

/// Where the handles stand, and their axes. Scale is along the entity's own axes always.
fn seat(editor: &Editor, stage: &Stage, mode: Mode) -> Option<(Vec3, Mat3)> {
    let (_, entity) = *editor.selected(stage.world).last()?;
    if lightwell::files::is_from_model(stage.world, entity) {
        return None;
    }
    let place = stage.world.ecs.get::<GlobalTransform>(entity)?.relative_to(stage.facts.scene.origin);
    let own = [place.x_axis(), place.y_axis(), place.z_axis()].map(|axis| axis.normalize_or_zero());
    let is_sound = own.iter().all(|axis| *axis != Vec3::ZERO);
    let axes = match is_sound && (editor.view.local || mode == Mode::Scale) {
        true => Mat3::from_cols(own[0], own[1], own[2]),
        false => Mat3::IDENTITY,
    };
    place.is_finite().then(|| (place.translation.into(), axes))
}

/// Axes of a transform as plain vectors.
trait Axes {
    fn x_axis(&self) -> Vec3;
    fn y_axis(&self) -> Vec3;
    fn z_axis(&self) -> Vec3;
}

impl Axes for Affine3A {
    fn x_axis(&self) -> Vec3 {
        self.matrix3.x_axis.into()
    }
    fn y_axis(&self) -> Vec3 {
        self.matrix3.y_axis.into()
    }
    fn z_axis(&self) -> Vec3 {
        self.matrix3.z_axis.into()
    }
}

fn parts(editor: &Editor, stage: &Stage) -> Vec<(SceneId, Pose, Affine3A)> {
    let world = &*stage.world;
    let selected = editor.selected(world);
    let stands_below = |entity| {
        std::iter::successors(world.parent(entity), |e| world.parent(*e)).any(|e| selected.iter().any(|(_, s)| *s == e))
    };
    let tops = selected.iter().filter(|(_, e)| !stands_below(*e) && !lightwell::files::is_from_model(world, *e));
    tops.map(|(id, entity)| {
        let parent = world.parent(*entity).and_then(|p| world.ecs.get::<GlobalTransform>(p)).copied();
        (*id, Pose::of(world, *entity), parent.unwrap_or_default().relative_to(stage.facts.scene.origin))
    })
    .collect()
}

fn ring(origin: Vec3, axes: &Mat3, axis: usize, radius: f32) -> impl Iterator<Item = Vec3> {
    let (u, v) = (axes.col((axis + 1) % 3), axes.col((axis + 2) % 3));
    (0..=48).map(move |i| {
        let angle = TAU * i as f32 / 48.0;
        origin + (u * angle.cos() + v * angle.sin()) * radius
    })
}

fn grip_at(lens: &Lens, mode: Mode, origin: Vec3, axes: &Mat3, at: Pos2) -> Option<Grip> {
    let length = lens.length(origin, LENGTH);
    let center = lens.point(origin)?;
    if mode != Mode::Rotate && center.distance(at) < NEAR {
        return Some(Grip::Center);
    }
    let distance = |axis: usize| match mode {
        Mode::Rotate => {
            let points: Vec<Pos2> = ring(origin, axes, axis, length).filter_map(|p| lens.point(p)).collect();
            points.windows(2).map(|w| to_segment(at, w[0], w[1])).fold(f32::INFINITY, f32::min)
        }
        _ => {
            lens.segment(origin, origin + axes.col(axis) * length).map_or(f32::INFINITY, |(a, b)| to_segment(at, a, b))
        }
    };
    let nearest = (0..3).map(|axis| (axis, distance(axis))).min_by(|a, b| a.1.total_cmp(&b.1))?;
    (nearest.1 < NEAR).then_some(Grip::Axis(nearest.0))
}

fn to_segment(at: Pos2, a: Pos2, b: Pos2) -> f32 {
    let along = b - a;
    let share = ((at - a).dot(along) / along.length_sq().max(1e-6)).clamp(0.0, 1.0);
    at.distance(a + along * share)
}

fn draw(painter: &Painter, lens: &Lens, mode: Mode, origin: Vec3, axes: &Mat3, held: Option<Grip>) {
    let length = lens.length(origin, LENGTH);
    for (axis, plain) in COLORS.into_iter().enumerate() {
        let is_held = held == Some(Grip::Axis(axis));
        let color = if is_held { Color32::from_rgb(255, 230, 90) } else { plain };
        let stroke = Stroke::new(if is_held { 4.0 } else { 2.5 }, color);
        if mode == Mode::Rotate {
            let points: Vec<Pos2> = ring(origin, axes, axis, length).filter_map(|p| lens.point(p)).collect();
            painter.line(points, stroke);
        } else if let Some((a, b)) = lens.segment(origin, origin + axes.col(axis) * length) {
            painter.line_segment([a, b], stroke);
            match mode {
                Mode::Scale => drop(painter.rect_filled(Rect::from_center_size(b, [9.0; 2].into()), 1.0, color)),
                _ => tip(painter, a, b, color),
            }
        }
    }
    if let Some(center) = lens.point(origin).filter(|_| mode != Mode::Rotate) {
        let color = if held == Some(Grip::Center) { Color32::from_rgb(255, 230, 90) } else { Color32::WHITE };
        painter.circle_filled(center, 4.5, color);
    }
}

fn tip(painter: &Painter, a: Pos2, b: Pos2, color: Color32) {
    let along = (b - a).normalized() * 12.0;
    let aside = egui::vec2(-along.y, along.x) * 0.4;
    let points = vec![b + along * 0.6, b - along * 0.4 + aside, b - along * 0.4 - aside];
    painter.add(egui::Shape::convex_polygon(points, color, Stroke::NONE));
}

fn apply(editor: &mut Editor, stage: &mut Stage, drag: &Drag, motion: Motion) -> anyhow::Result<()> {
    let label = match motion {
        Motion::Move(_) => "move",
        Motion::Rotate(_) => "rotate",
        Motion::Scale(_) => "scale",
    };
    let ids: Vec<SceneId> = drag.parts.iter().map(|(id, ..)| *id).collect();
    editor.history.open(stage, label, &ids)?;
    for (id, before, parent) in &drag.parts {
        let now = moved(&before.shown, parent, drag.origin, motion);
        let sound = now.translation.is_finite() && now.rotation.is_finite() && now.scale.is_finite();
        let Some(entity) = stage.world.entity(*id).filter(|_| sound) else { continue };
        let (now, refused) = before.shown_at(&now);
        stage.world.set_rest_transform(entity, now.rest);
        if let Some(animation) = now.animation.filter(|now| before.animation.as_ref() != Some(now)) {
            stage.world.ecs.entity_mut(entity).insert(animation);
        }
        if let Some(why) = refused {
            editor.tell(format!("`{}`: {why}", stage.world.name(entity)), true);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests;
