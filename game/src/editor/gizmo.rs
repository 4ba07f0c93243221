//! Handles in the view that move, rotate and scale the selection.

use super::Editor;
use super::stage::Stage;
use egui::{Color32, Painter, Pos2, Rect, Response, Stroke, Ui};
use glam::{Affine3A, Mat3, Mat4, Quat, Vec3, Vec4};
use lightwell::scene::{SceneCamera, SceneId, SceneView};
use lightwell::world::{GlobalTransform, Transform};
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
/// Steps: \[m\], \[rad\], factor.
const STEPS: (f32, f32, f32) = (0.1, TAU / 24.0, 0.1);
const COLORS: [Color32; 3] =
    [Color32::from_rgb(240, 80, 80), Color32::from_rgb(110, 210, 90), Color32::from_rgb(90, 150, 255)];

/// From the world to the screen and back.
pub struct Lens {
    clip_from_world: Mat4,
    world_from_clip: Mat4,
    /// Homogeneous: a direction where lines of sight are parallel.
    eye: Vec4,
    /// Least of clip w that is seen; w is 1 everywhere where lines of sight are parallel.
    near: f32,
    focal: f32,
    rect: Rect,
}

impl Lens {
    /// Of a camera whose image fills a rectangle.
    pub fn new(camera: &SceneCamera, rect: Rect) -> Self {
        let size = [rect.width().max(1.0) as u32, rect.height().max(1.0) as u32];
        let view = SceneView { camera: camera.clone(), size, jitter: [0.0; 2] };
        Self {
            clip_from_world: view.clip_from_world(),
            world_from_clip: view.world_from_clip(),
            eye: view.eye_point(),
            near: if camera.is_orthographic() { 0.0 } else { camera.near },
            focal: 0.5 * rect.height() / camera.half_height(),
            rect,
        }
    }

    fn clip(&self, point: Vec3) -> Vec4 {
        self.clip_from_world * point.extend(1.0)
    }

    fn screen(&self, clip: Vec4) -> Pos2 {
        let ndc = clip.truncate() / clip.w;
        let share = [ndc.x * 0.5 + 0.5, 0.5 - ndc.y * 0.5];
        self.rect.min + egui::vec2(share[0] * self.rect.width(), share[1] * self.rect.height())
    }

    /// How far beyond the near plane a point lies, in a measure that is linear along lines.
    fn beyond(&self, clip: Vec4) -> f32 {
        // Depth is reversed: 1 on the near plane.
        if self.near > 0.0 { clip.w - self.near } else { clip.w - clip.z }
    }

    /// Where a point is seen; none behind the camera.
    pub fn point(&self, point: Vec3) -> Option<Pos2> {
        let clip = self.clip(point);
        (self.beyond(clip) > 0.0).then(|| self.screen(clip))
    }

    /// Where a line is seen, cut off at the near plane.
    pub fn segment(&self, a: Vec3, b: Vec3) -> Option<(Pos2, Pos2)> {
        let (mut a, mut b) = (self.clip(a), self.clip(b));
        let (near, other) = (self.beyond(a), self.beyond(b));
        if near <= 0.0 && other <= 0.0 {
            return None;
        }
        // A little beyond the plane, where w is above zero for certain.
        let least = 1e-3 * self.near;
        let cut = |from: Vec4, to: Vec4, low: f32, high: f32| from + (to - from) * ((least - low) / (high - low));
        if near <= 0.0 {
            a = cut(a, b, near, other);
        } else if other <= 0.0 {
            b = cut(b, a, other, near);
        }
        Some((self.screen(a), self.screen(b)))
    }

    /// Length in the world of so many points on the screen at a place \[m\].
    fn length(&self, at: Vec3, points: f32) -> f32 {
        points * self.clip(at).w.max(self.near) / self.focal
    }

    /// The line of sight through a point of the screen: where it starts, and its direction.
    fn ray(&self, at: Pos2) -> (Vec3, Vec3) {
        let share = (at - self.rect.min) / self.rect.size();
        let clip = Vec4::new(share.x * 2.0 - 1.0, 1.0 - share.y * 2.0, 0.5, 1.0);
        let point = self.world_from_clip * clip;
        let point = point.truncate() / point.w;
        let eye = self.eye.truncate();
        if self.eye.w == 0.0 {
            // Anywhere on the line: it has no start.
            return (point, -eye);
        }
        (eye, (point - eye).normalize_or(Vec3::NEG_Z))
    }

    /// How far along an axis the point lies that is nearest to the line of sight \[m\].
    fn along(&self, origin: Vec3, axis: Vec3, at: Pos2) -> Option<f32> {
        let (start, ray) = self.ray(at);
        let across = axis.dot(ray);
        let from = origin - start;
        let denominator = 1.0 - across * across;
        (denominator > 1e-4).then(|| (across * ray.dot(from) - axis.dot(from)) / denominator)
    }

    /// Where the line of sight meets a plane.
    fn on_plane(&self, origin: Vec3, normal: Vec3, at: Pos2) -> Option<Vec3> {
        let (start, ray) = self.ray(at);
        let across = ray.dot(normal);
        let distance = (origin - start).dot(normal) / across;
        (across.abs() > 1e-3 && (distance > 0.0 || self.eye.w == 0.0)).then(|| start + ray * distance)
    }
}

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
    /// What is dragged: its own transform before, and where its parent stands.
    parts: Vec<(SceneId, Transform, Affine3A)>,
}

/// What a drag amounts to.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Motion {
    Move(Vec3),
    Rotate(Quat),
    Scale(Vec3),
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
    if let Some(at) = pointer.filter(|_| response.dragged_by(egui::PointerButton::Primary)) {
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

fn parts(editor: &Editor, stage: &Stage) -> Vec<(SceneId, Transform, Affine3A)> {
    let world = &*stage.world;
    let selected = editor.selected(world);
    let stands_below = |entity| {
        std::iter::successors(world.parent(entity), |e| world.parent(*e)).any(|e| selected.iter().any(|(_, s)| *s == e))
    };
    let tops = selected.iter().filter(|(_, e)| !stands_below(*e) && !lightwell::files::is_from_model(world, *e));
    tops.map(|(id, entity)| {
        let parent = world.parent(*entity).and_then(|p| world.ecs.get::<GlobalTransform>(p)).copied();
        (*id, world.rest_transform(*entity), parent.unwrap_or_default().relative_to(stage.facts.scene.origin))
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

/// What the drag from its start to a point amounts to.
fn motion(drag: &Drag, lens: &Lens, at: Pos2, snap: bool) -> Option<Motion> {
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
fn moved(before: &Transform, parent: &Affine3A, origin: Vec3, motion: Motion) -> Transform {
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

fn apply(editor: &mut Editor, stage: &mut Stage, drag: &Drag, motion: Motion) -> anyhow::Result<()> {
    let label = match motion {
        Motion::Move(_) => "move",
        Motion::Rotate(_) => "rotate",
        Motion::Scale(_) => "scale",
    };
    let ids: Vec<SceneId> = drag.parts.iter().map(|(id, ..)| *id).collect();
    editor.history.open(stage, label, &ids)?;
    for (id, before, parent) in &drag.parts {
        let now = moved(before, parent, drag.origin, motion);
        let sound = now.translation.is_finite() && now.rotation.is_finite() && now.scale.is_finite();
        if let Some(entity) = stage.world.entity(*id).filter(|_| sound) {
            stage.world.set_rest_transform(entity, now);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use egui::pos2;
    use lightwell::scene::ViewProjection;

    const PERSPECTIVE: ViewProjection = ViewProjection::Perspective { vertical_fov: 1.0 };
    const BOTH: [ViewProjection; 2] = [PERSPECTIVE, ViewProjection::Orthographic { height: 6.0 }];

    fn lens(projection: ViewProjection) -> Lens {
        let camera = SceneCamera {
            id: SceneId(1),
            name: "c".into(),
            world_from_view: Affine3A::from_translation(Vec3::new(0.0, 0.0, 5.0)),
            projection,
            near: 0.1,
            far: None,
            primary: true,
        };
        Lens::new(&camera, Rect::from_min_size(pos2(10.0, 20.0), egui::vec2(400.0, 300.0)))
    }

    fn drag(mode: Mode, grip: Grip, start: Pos2) -> Drag {
        Drag { mode, grip, origin: Vec3::ZERO, axes: Mat3::IDENTITY, start, parts: Vec::new() }
    }

    #[test]
    fn a_drag_along_an_axis_follows_the_pointer() {
        BOTH.iter().for_each(|projection| drag_along_an_axis(&lens(*projection)));
    }

    fn drag_along_an_axis(lens: &Lens) {
        let (from, to) = (Vec3::X * 0.3, Vec3::X * 1.1);
        let drag = drag(Mode::Move, Grip::Axis(0), lens.point(from).unwrap());
        let Some(Motion::Move(by)) = motion(&drag, lens, lens.point(to).unwrap(), false) else { panic!() };
        assert!(by.abs_diff_eq(Vec3::X * 0.8, 1e-3), "{by}");
        let near = lens.point(to + Vec3::new(0.0, 0.4, 0.0)).unwrap();
        let Some(Motion::Move(by)) = motion(&drag, lens, near, true) else { panic!() };
        assert!((by.x / 0.1 - (by.x / 0.1).round()).abs() < 1e-3 && by.y == 0.0, "{by} is in steps");
    }

    #[test]
    fn handles_are_hit_where_they_are_drawn() {
        BOTH.iter().for_each(|projection| handles_are_hit(&lens(*projection)));
    }

    fn handles_are_hit(lens: &Lens) {
        let length = lens.length(Vec3::ZERO, LENGTH);
        let axes = Mat3::IDENTITY;
        let at = |p: Vec3| lens.point(p).unwrap();
        assert_eq!(grip_at(lens, Mode::Move, Vec3::ZERO, &axes, at(Vec3::X * length * 0.7)), Some(Grip::Axis(0)));
        assert_eq!(grip_at(lens, Mode::Move, Vec3::ZERO, &axes, at(Vec3::ZERO)), Some(Grip::Center));
        assert_eq!(grip_at(lens, Mode::Rotate, Vec3::ZERO, &axes, at(Vec3::Y * length)), Some(Grip::Axis(0)));
        assert_eq!(grip_at(lens, Mode::Scale, Vec3::ZERO, &axes, at(Vec3::splat(length))), None);
    }

    #[test]
    fn what_lies_before_an_orthographic_camera_is_cut_off() {
        let lens = lens(BOTH[1]);
        assert_eq!((lens.point(Vec3::Z * 4.0).is_some(), lens.point(Vec3::Z * 5.5)), (true, None));
        let (a, b) = lens.segment(Vec3::new(1.0, 0.0, 9.9), Vec3::new(-1.0, 0.0, -0.1)).unwrap();
        assert!((a.x - 210.0).abs() < 1e-2 && (b.x - 160.0).abs() < 1e-2, "{a:?} {b:?}: 50 points a metre");
        // Handles are as large wherever they stand.
        assert_eq!(lens.length(Vec3::ZERO, 50.0), lens.length(Vec3::Z * -30.0, 50.0));
    }

    #[test]
    fn a_quarter_turn_is_a_quarter_turn() {
        let lens = lens(PERSPECTIVE);
        let center = lens.point(Vec3::ZERO).unwrap();
        let drag = drag(Mode::Rotate, Grip::Axis(2), center + egui::vec2(50.0, 0.0));
        let Some(Motion::Rotate(q)) = motion(&drag, &lens, center + egui::vec2(0.0, -50.0), false) else { panic!() };
        assert!((q * Vec3::X).abs_diff_eq(Vec3::Y, 1e-4), "counter-clockwise, seen from +Z");
    }

    #[test]
    fn parents_are_taken_into_account() {
        let parent = Affine3A::from_scale_rotation_translation(
            Vec3::splat(2.0),
            Quat::from_rotation_y(TAU / 4.0),
            Vec3::new(1.0, 2.0, 3.0),
        );
        let before = Transform { translation: Vec3::new(0.5, 0.0, 0.0), ..Transform::default() };
        let place = |t: &Transform| (parent * t.matrix()).translation;
        let now = moved(&before, &parent, Vec3::ZERO, Motion::Move(Vec3::X));
        assert!((place(&now) - place(&before)).abs_diff_eq(Vec3::X.into(), 1e-5));
        let turn = Quat::from_rotation_y(0.3);
        let around: Vec3 = place(&before).into();
        let now = moved(&before, &parent, around, Motion::Rotate(turn));
        assert_eq!(now.translation, before.translation, "a turn around itself moves nothing");
        let world = |t: &Transform| (parent * t.matrix()).to_scale_rotation_translation().1;
        assert!(world(&now).abs_diff_eq(turn * world(&before), 1e-5));
    }

    #[test]
    fn lines_are_cut_at_the_camera() {
        let lens = lens(PERSPECTIVE);
        assert!(lens.segment(Vec3::new(0.0, 0.0, 20.0), Vec3::new(0.0, 0.0, 30.0)).is_none());
        let (a, b) = lens.segment(Vec3::new(0.5, 0.0, 20.0), Vec3::new(0.5, 0.0, 0.0)).unwrap();
        assert!(a.x.is_finite() && b.x.is_finite());
    }
}
