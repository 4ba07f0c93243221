//! Lines, boxes, spheres and texts that systems draw into the view of a frame, to see what they do.

use crate::scene::Aabb;
use bevy_ecs::prelude::Resource;
use glam::{Affine3A, Vec2, Vec3};
use std::f32::consts::TAU;

/// Segments of a circle.
const SEGMENTS: usize = 48;
/// Most lines of a frame: what a system draws beyond them in a loop that does not end is left out.
pub const MOST_LINES: usize = 1 << 20;

/// A line in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DrawnLine {
    /// One end \[m\].
    pub from: Vec3,
    /// The other end \[m\].
    pub to: Vec3,
    /// sRGB, 0 to 1.
    pub color: Vec3,
    /// Whether surfaces do not dim it.
    pub is_on_top: bool,
}

/// A text at a place in world space; surfaces do not hide it.
#[derive(Clone, Debug, PartialEq)]
pub struct DrawnText {
    /// Its middle \[m\].
    pub at: Vec3,
    /// The text.
    pub text: String,
    /// sRGB, 0 to 1.
    pub color: Vec3,
}

/// What systems draw into the view beside the scene: lines, boxes, spheres and texts, which light does not see. It lasts for
/// one frame. What a step of time draws ([`FixedUpdate`](super::FixedUpdate)) lasts until the next step, so that it does not
/// flicker where frames are drawn more often than steps are done.
///
/// Points that are not finite draw nothing. The thesis of the engine's paper has such calls (section 6.8).
#[derive(Resource, Clone, Debug, Default)]
pub struct Draw {
    of_steps: Drawings,
    of_frame: Drawings,
    is_step: bool,
    is_on_top: bool,
}

#[derive(Clone, Debug, Default)]
struct Drawings {
    lines: Vec<DrawnLine>,
    texts: Vec<DrawnText>,
}

impl Draw {
    /// Whether what is drawn from here on lies before all surfaces. Else they dim what is behind them. A frame and a step
    /// begin with `false`.
    pub fn on_top(&mut self, is_on_top: bool) -> &mut Self {
        self.is_on_top = is_on_top;
        self
    }

    /// A line between two points \[m\] of an sRGB colour, 0 to 1.
    pub fn line(&mut self, from: Vec3, to: Vec3, color: Vec3) {
        let line = DrawnLine { from, to, color, is_on_top: self.is_on_top };
        let lines = &mut self.here().lines;
        if from.is_finite() && to.is_finite() && color.is_finite() && lines.len() < MOST_LINES {
            lines.push(line);
        }
    }

    /// Lines from each point to the next one.
    pub fn path(&mut self, points: &[Vec3], color: Vec3) {
        points.windows(2).for_each(|ends| self.line(ends[0], ends[1], color));
    }

    /// A line with a head.
    pub fn arrow(&mut self, from: Vec3, to: Vec3, color: Vec3) {
        self.line(from, to, color);
        let along = to - from;
        let side = 0.1 * along.length() * along.normalize_or(Vec3::Y).any_orthonormal_vector();
        for barb in [side, -side] {
            self.line(to, to - 0.2 * along + barb, color);
        }
    }

    /// The edges of a box along the axes.
    pub fn aabb(&mut self, bounds: &Aabb, color: Vec3) {
        let place = Affine3A::from_scale_rotation_translation(bounds.size(), glam::Quat::IDENTITY, bounds.center());
        self.cuboid(place, color);
    }

    /// The edges of the cube from −½ to ½, as a transform places it.
    pub fn cuboid(&mut self, world_from_cube: Affine3A, color: Vec3) {
        let corner = |i: usize| {
            let half = |bit: usize| if i >> bit & 1 == 0 { -0.5 } else { 0.5 };
            world_from_cube.transform_point3(Vec3::new(half(0), half(1), half(2)))
        };
        for bit in 0..3 {
            for i in (0..8).filter(|i| i >> bit & 1 == 0) {
                self.line(corner(i), corner(i | 1 << bit), color);
            }
        }
    }

    /// A circle around a point, across a direction.
    pub fn circle(&mut self, center: Vec3, axis: Vec3, radius: f32, color: Vec3) {
        let (x, y) = axis.normalize_or(Vec3::Y).any_orthonormal_pair();
        let at = |i: usize| {
            let turn = radius * Vec2::from_angle(TAU * (i % SEGMENTS) as f32 / SEGMENTS as f32);
            center + x * turn.x + y * turn.y
        };
        (0..SEGMENTS).for_each(|i| self.line(at(i), at(i + 1), color));
    }

    /// A sphere as three circles.
    pub fn sphere(&mut self, center: Vec3, radius: f32, color: Vec3) {
        [Vec3::X, Vec3::Y, Vec3::Z].into_iter().for_each(|axis| self.circle(center, axis, radius, color));
    }

    /// A text whose middle lies at a point \[m\].
    pub fn text(&mut self, at: Vec3, text: impl Into<String>, color: Vec3) {
        let texts = &mut self.here().texts;
        if at.is_finite() && texts.len() < MOST_LINES {
            texts.push(DrawnText { at, text: text.into(), color });
        }
    }

    /// All lines of the frame.
    pub fn lines(&self) -> impl Iterator<Item = &DrawnLine> {
        self.of_steps.lines.iter().chain(&self.of_frame.lines)
    }

    /// All texts of the frame.
    pub fn texts(&self) -> impl Iterator<Item = &DrawnText> {
        self.of_steps.texts.iter().chain(&self.of_frame.texts)
    }

    fn here(&mut self) -> &mut Drawings {
        if self.is_step { &mut self.of_steps } else { &mut self.of_frame }
    }

    pub(super) fn begin_step(&mut self) {
        self.of_steps = Drawings::default();
        (self.is_step, self.is_on_top) = (true, false);
    }

    pub(super) fn end_step(&mut self) {
        self.is_step = false;
    }

    pub(super) fn begin_frame(&mut self) {
        self.of_frame = Drawings::default();
        self.is_on_top = false;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shapes_have_their_size() {
        let mut draw = Draw::default();
        draw.sphere(Vec3::ONE, 2.0, Vec3::X);
        assert!(draw.lines().all(|line| (line.from.distance(Vec3::ONE) - 2.0).abs() < 1e-5));
        draw.begin_frame();
        draw.aabb(&Aabb { min: Vec3::ZERO, max: Vec3::new(1.0, 2.0, 3.0) }, Vec3::X);
        for (axis, length) in [(0, 1.0), (1, 2.0), (2, 3.0)] {
            let along = draw.lines().map(|line| (line.to - line.from).abs());
            assert_eq!(along.filter(|edge| edge[axis] == length && edge.length() == length).count(), 4);
        }
        draw.begin_frame();
        draw.arrow(Vec3::ZERO, Vec3::Y, Vec3::X);
        draw.path(&[Vec3::ZERO, Vec3::X, Vec3::Y], Vec3::X);
        assert_eq!(draw.lines().count(), 3 + 2);
    }

    #[test]
    fn what_steps_draw_lasts_until_the_next_step() {
        let mut draw = Draw::default();
        let count = |draw: &Draw| (draw.lines().count(), draw.texts().count());
        draw.begin_step();
        draw.line(Vec3::ZERO, Vec3::X, Vec3::X);
        draw.text(Vec3::ZERO, "step", Vec3::ONE);
        draw.end_step();
        draw.begin_frame();
        draw.line(Vec3::ZERO, Vec3::Y, Vec3::X);
        assert_eq!(count(&draw), (2, 1));
        draw.begin_frame();
        assert_eq!(count(&draw), (1, 1));
        draw.begin_step();
        draw.end_step();
        assert_eq!(count(&draw), (0, 0));
    }

    #[test]
    fn what_is_not_finite_draws_nothing_and_a_frame_has_a_bound() {
        let mut draw = Draw::default();
        draw.line(Vec3::NAN, Vec3::X, Vec3::X);
        draw.sphere(Vec3::ZERO, f32::INFINITY, Vec3::X);
        draw.text(Vec3::INFINITY, "far", Vec3::X);
        draw.arrow(Vec3::ONE, Vec3::ONE, Vec3::X);
        assert_eq!((draw.lines().count(), draw.texts().count()), (3, 0), "an arrow without length is a point");
        (0..MOST_LINES + 10).for_each(|_| draw.line(Vec3::ZERO, Vec3::X, Vec3::X));
        assert_eq!(draw.lines().count(), MOST_LINES);
    }
}
