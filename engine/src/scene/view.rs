//! Cameras and the view that a frame is drawn from.

use super::SceneId;
use glam::{Affine3A, Mat4, Vec3, Vec4};

/// A camera in world space. Looks along −Z, up is +Y.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneCamera {
    /// Persistent identity; the order of [`super::Scene::cameras`].
    pub id: SceneId,
    /// Name, as `--camera` takes it.
    pub name: String,
    /// World from camera space, rigid (scale removed).
    pub world_from_view: Affine3A,
    /// Vertical field of view \[rad\].
    pub vertical_fov: f32,
    /// Near plane \[m\].
    pub near: f32,
    /// Far plane \[m\]; none: infinite.
    pub far: Option<f32>,
    /// The camera that is used when none is named (the first such by SceneId, else the first).
    pub primary: bool,
}

/// One view to draw: a camera, an image size and a sub-pixel shift.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneView {
    /// The camera.
    pub camera: SceneCamera,
    /// Image size \[pixels\].
    pub size: [u32; 2],
    /// Shift of the pixel grid in pixels, each in −½..½, for anti-aliasing by averaged frames.
    pub jitter: [f32; 2],
}

impl SceneView {
    /// Clip from world space: reversed depth (1 near, 0 far), the jitter included.
    pub fn clip_from_world(&self) -> Mat4 {
        self.clip_from_view() * Mat4::from(self.camera.world_from_view.inverse())
    }

    /// World from clip space. Inverted by parts, since each is well conditioned by itself.
    pub fn world_from_clip(&self) -> Mat4 {
        Mat4::from(self.camera.world_from_view) * self.clip_from_view().inverse()
    }

    fn clip_from_view(&self) -> Mat4 {
        let [width, height] = self.size.map(|s| s.max(1) as f32);
        let unshifted = perspective(self.camera.vertical_fov, width / height, self.camera.near, self.camera.far);
        let shift = Vec3::new(2.0 * self.jitter[0] / width, -2.0 * self.jitter[1] / height, 0.0);
        Mat4::from_translation(shift) * unshifted
    }

    /// World position of the eye \[m\].
    pub fn eye(&self) -> Vec3 {
        self.camera.world_from_view.translation.into()
    }
}

/// Right-handed perspective projection with reversed depth: z = 1 at `near`, 0 at `far` or at infinity.
pub fn perspective(vertical_fov: f32, aspect: f32, near: f32, far: Option<f32>) -> Mat4 {
    let focal = 1.0 / (0.5 * vertical_fov).tan();
    let (a, b) = match far {
        // z_clip = a·z_view + b with z_clip/w = 1 at −near and 0 at −far, w = −z_view.
        Some(far) => (near / (far - near), near * far / (far - near)),
        None => (0.0, near),
    };
    Mat4::from_cols(
        Vec4::new(focal / aspect, 0.0, 0.0, 0.0),
        Vec4::new(0.0, focal, 0.0, 0.0),
        Vec4::new(0.0, 0.0, a, -1.0),
        Vec4::new(0.0, 0.0, b, 0.0),
    )
}
