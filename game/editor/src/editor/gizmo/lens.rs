//! From the world to the screen and back.

use egui::{Pos2, Rect};
use glam::{Mat4, Vec3, Vec4};
use lightwell::scene::{SceneCamera, SceneView};

/// From the world to the screen and back.
pub struct Lens {
    clip_from_world: Mat4,
    world_from_clip: Mat4,
    /// Homogeneous: a direction where lines of sight are parallel.
    pub(super) eye: Vec4,
    /// Least of clip w that is seen; w is 1 everywhere where lines of sight are parallel.
    near: f32,
    focal: f32,
    pub(super) rect: Rect,
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
    pub(super) fn length(&self, at: Vec3, points: f32) -> f32 {
        points * self.clip(at).w.max(self.near) / self.focal
    }

    /// The line of sight through a point of the screen: where it starts, and its direction.
    pub(super) fn ray(&self, at: Pos2) -> (Vec3, Vec3) {
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
    pub(super) fn along(&self, origin: Vec3, axis: Vec3, at: Pos2) -> Option<f32> {
        let (start, ray) = self.ray(at);
        let across = axis.dot(ray);
        let from = origin - start;
        let denominator = 1.0 - across * across;
        (denominator > 1e-4).then(|| (across * ray.dot(from) - axis.dot(from)) / denominator)
    }

    /// Where the line of sight meets a plane.
    pub(super) fn on_plane(&self, origin: Vec3, normal: Vec3, at: Pos2) -> Option<Vec3> {
        let (start, ray) = self.ray(at);
        let across = ray.dot(normal);
        let distance = (origin - start).dot(normal) / across;
        (across.abs() > 1e-3 && (distance > 0.0 || self.eye.w == 0.0)).then(|| start + ray * distance)
    }
}
