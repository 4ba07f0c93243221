//! The camera of interactive play: the scene's own, until it is moved by hand.

use glam::{Affine3A, EulerRot, Quat, Vec3};
use lightwell::scene::{SceneCamera, ViewProjection};
use serde::{Deserialize, Serialize};
use std::f32::consts::FRAC_PI_2;

/// Turn for a drag over one pixel \[rad\].
const TURN: f32 = 0.004;
/// Steepest look up or down \[rad\]: a little less than upright, where the heading is lost.
const STEEPEST: f32 = FRAC_PI_2 - 0.01;

/// Place and direction of a camera without roll.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pose {
    position: Vec3,
    heading: f32,
    pitch: f32,
}

impl Pose {
    fn of(world_from_view: &Affine3A) -> Self {
        let forward = -Vec3::from(world_from_view.matrix3.z_axis).normalize_or(Vec3::Z);
        Self {
            position: world_from_view.translation.into(),
            heading: (-forward.x).atan2(-forward.z),
            pitch: forward.y.clamp(-1.0, 1.0).asin().clamp(-STEEPEST, STEEPEST),
        }
    }

    fn rotation(&self) -> Quat {
        Quat::from_euler(EulerRot::YXZ, self.heading, self.pitch, 0.0)
    }

    fn turn(&mut self, pixels: [f32; 2]) {
        self.heading -= pixels[0] * TURN;
        self.pitch = (self.pitch - pixels[1] * TURN).clamp(-STEEPEST, STEEPEST);
    }
}

/// A camera that can be flown.
#[derive(Clone, Debug, Default)]
pub struct FlyCamera {
    /// Set once it was moved by hand.
    free: Option<Pose>,
    /// Height of what an orthographic camera sees, once it was changed by hand \[m\].
    height: Option<f32>,
}

impl FlyCamera {
    /// Whether it was moved by hand.
    pub fn is_free(&self) -> bool {
        self.free.is_some()
    }

    /// Back to the scene's camera.
    pub fn reset(&mut self) {
        *self = Self::default();
    }

    /// Where it was flown to.
    pub fn place(&self) -> Option<Pose> {
        self.free
    }

    /// Goes to a place, or back to the scene's camera.
    pub fn go(&mut self, place: Option<Pose>) {
        self.free = place;
    }

    /// Keeps the direction and stands so far away from a point \[m\] that it is in the middle.
    pub fn look_from(&mut self, camera: &SceneCamera, point: Vec3, distance: f32) {
        let pose = self.pose(camera);
        pose.position = point - pose.rotation() * Vec3::NEG_Z * distance;
    }

    /// Sets the height of what an orthographic camera sees \[m\].
    pub fn set_height(&mut self, height: f32) {
        self.height = Some(height.clamp(1e-3, 1e6));
    }

    /// The camera to draw with: the scene's lens at the place flown to.
    pub fn apply(&self, camera: &SceneCamera) -> SceneCamera {
        let mut camera = camera.clone();
        if let Some(pose) = &self.free {
            camera.world_from_view = Affine3A::from_rotation_translation(pose.rotation(), pose.position);
        }
        if let (ViewProjection::Orthographic { height }, Some(own)) = (&mut camera.projection, self.height) {
            *height = own;
        }
        camera
    }

    /// Looks around by a drag \[pixels\].
    pub fn look(&mut self, camera: &SceneCamera, pixels: [f32; 2]) {
        self.pose(camera).turn(pixels);
    }

    /// Circles by a drag \[pixels\] around the point that lies `distance` ahead \[m\].
    pub fn orbit(&mut self, camera: &SceneCamera, pixels: [f32; 2], distance: f32) {
        let pose = self.pose(camera);
        let pivot = pose.position + pose.rotation() * Vec3::NEG_Z * distance;
        pose.turn(pixels);
        pose.position = pivot - pose.rotation() * Vec3::NEG_Z * distance;
    }

    /// Flies along the camera's own axes \[m\]: right, up, back.
    pub fn fly(&mut self, camera: &SceneCamera, along: Vec3) {
        let pose = self.pose(camera);
        pose.position += pose.rotation() * along;
    }

    /// The origin that places are told from has moved \[m\].
    pub fn rebase(&mut self, moved: Vec3) {
        if let Some(pose) = &mut self.free {
            pose.position -= moved;
        }
    }

    fn pose(&mut self, camera: &SceneCamera) -> &mut Pose {
        self.free.get_or_insert_with(|| Pose::of(&camera.world_from_view))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lightwell::scene::SceneId;

    fn camera(from: Vec3, to: Vec3) -> SceneCamera {
        let back = (from - to).normalize();
        let right = Vec3::Y.cross(back).normalize();
        SceneCamera {
            id: SceneId(1),
            name: "Camera".into(),
            world_from_view: Affine3A::from_cols(right.into(), back.cross(right).into(), back.into(), from.into()),
            projection: ViewProjection::Perspective { vertical_fov: 1.0 },
            near: 0.1,
            far: None,
            primary: true,
            lens: Default::default(),
            grading: None,
        }
    }

    #[test]
    fn taking_over_does_not_jump() {
        let scene = camera(Vec3::new(1.0, 2.0, 3.0), Vec3::new(-4.0, 0.5, 0.2));
        let mut fly = FlyCamera::default();
        assert_eq!(fly.apply(&scene), scene);
        fly.fly(&scene, Vec3::ZERO);
        assert!(fly.is_free());
        assert!(fly.apply(&scene).world_from_view.abs_diff_eq(scene.world_from_view, 1e-5));
        fly.reset();
        assert_eq!(fly.apply(&scene), scene);
    }

    #[test]
    fn orbits_keep_the_distance() {
        let scene = camera(Vec3::new(0.0, 1.0, 5.0), Vec3::new(0.0, 1.0, 0.0));
        let mut fly = FlyCamera::default();
        fly.orbit(&scene, [300.0, 120.0], 5.0);
        let eye: Vec3 = fly.apply(&scene).world_from_view.translation.into();
        assert!((eye.distance(Vec3::Y) - 5.0).abs() < 1e-4, "{eye}");
    }

    #[test]
    fn the_height_is_that_of_orthographic_cameras() {
        let mut scene = camera(Vec3::ZERO, Vec3::X);
        let mut fly = FlyCamera::default();
        fly.set_height(3.0);
        assert_eq!(fly.apply(&scene), scene);
        scene.projection = ViewProjection::Orthographic { height: 8.0 };
        assert_eq!(fly.apply(&scene).half_height(), 1.5);
        fly.reset();
        assert_eq!(fly.apply(&scene), scene);
    }

    #[test]
    fn flight_follows_the_view() {
        let scene = camera(Vec3::ZERO, Vec3::X);
        let mut fly = FlyCamera::default();
        fly.fly(&scene, Vec3::new(0.0, 0.0, -2.0));
        let eye: Vec3 = fly.apply(&scene).world_from_view.translation.into();
        assert!(eye.abs_diff_eq(Vec3::new(2.0, 0.0, 0.0), 1e-5), "{eye}");
    }
}
