//! Cameras and the view that a frame is drawn from.

use crate::assets::CubeTable;
use crate::core::{SceneId, ViewProjection, orthographic, perspective};
use crate::world::Lens;
use glam::{Affine3A, Mat4, Vec3, Vec4};
use std::sync::Arc;

/// Far plane of an orthographic camera that names none, in heights of what it sees. Its depth is linear: beyond this the
/// numbers of single precision would be farther apart than a hundredth of a pixel.
const ORTHOGRAPHIC_REACH: f32 = 100.0;

/// A camera in world space. Looks along −Z, up is +Y.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneCamera {
    /// Persistent identity; the order of [`super::Scene::cameras`].
    pub id: SceneId,
    /// Name, as `--camera` takes it.
    pub name: String,
    /// World from camera space, rigid (scale removed).
    pub world_from_view: Affine3A,
    /// Projection.
    pub projection: ViewProjection,
    /// Near plane \[m\].
    pub near: f32,
    /// Far plane \[m\]; none: infinite, or 100 heights behind the near plane of an orthographic camera.
    pub far: Option<f32>,
    /// The camera that is used when none is named (the first such by SceneId, else the first).
    pub primary: bool,
    /// Lens and display response, with all values in range.
    pub lens: Lens,
    /// The colour table of the lens.
    pub grading: Option<Arc<CubeTable>>,
}

impl SceneCamera {
    /// Half the height of what is seen: at distance 1 in a perspective, at all distances \[m\] if orthographic.
    pub fn half_height(&self) -> f32 {
        match self.projection {
            ViewProjection::Perspective { vertical_fov } => (0.5 * vertical_fov).tan(),
            ViewProjection::Orthographic { height } => 0.5 * height,
        }
    }

    /// Whether lines of sight are parallel.
    pub fn is_orthographic(&self) -> bool {
        matches!(self.projection, ViewProjection::Orthographic { .. })
    }

    /// The far plane that is used \[m\]; none: infinite.
    pub fn far_plane(&self) -> Option<f32> {
        match self.projection {
            ViewProjection::Perspective { .. } => self.far,
            ViewProjection::Orthographic { height } => {
                Some(self.far.unwrap_or(self.near + ORTHOGRAPHIC_REACH * height))
            }
        }
    }

    /// Radius of its lens \[m\]; none: all is sharp. An orthographic camera has no lens that focuses.
    pub fn lens_radius(&self) -> Option<f32> {
        let depth_of_field = self.lens.depth_of_field.as_ref().filter(|_| !self.is_orthographic())?;
        Some(depth_of_field.lens_radius(self.half_height()))
    }

    /// Direction of view, a unit vector.
    pub fn forward(&self) -> Vec3 {
        -Vec3::from(self.world_from_view.matrix3.z_axis)
    }
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
        let (camera, aspect) = (&self.camera, width / height);
        let unshifted = match camera.projection {
            ViewProjection::Perspective { vertical_fov } => perspective(vertical_fov, aspect, camera.near, camera.far),
            ViewProjection::Orthographic { height } => {
                let far = camera.far_plane().unwrap_or(camera.near + height);
                orthographic(height, aspect, camera.near, far)
            }
        };
        let shift = Vec3::new(2.0 * self.jitter[0] / width, -2.0 * self.jitter[1] / height, 0.0);
        Mat4::from_translation(shift) * unshifted
    }

    /// World position of the eye \[m\].
    pub fn eye(&self) -> Vec3 {
        self.camera.world_from_view.translation.into()
    }

    /// Where the lines of sight come from, in homogeneous coordinates: the eye \[m\] with w = 1, or the direction towards
    /// it with w = 0. From a point p the eye lies along xyz − w·p.
    pub fn eye_point(&self) -> Vec4 {
        match self.camera.projection {
            ViewProjection::Perspective { .. } => self.eye().extend(1.0),
            ViewProjection::Orthographic { .. } => (-self.camera.forward()).extend(0.0),
        }
    }

    /// Width of a pixel at a depth of 1 m, or where lines of sight are parallel at any depth \[m\].
    pub fn pixel_width(&self) -> f32 {
        let upwards = self.clip_from_world().row(1).truncate();
        2.0 / (upwards.length().max(f32::MIN_POSITIVE) * self.size[1].max(1) as f32)
    }

    /// The plane from which distances along the view's axis are measured \[m\]: its scalar product with (p, 1).
    pub fn axis(&self) -> Vec4 {
        match self.camera.projection {
            // The divisor of the projection.
            ViewProjection::Perspective { .. } => self.clip_from_world().row(3),
            ViewProjection::Orthographic { .. } => {
                let forward = self.camera.forward();
                forward.extend(-forward.dot(self.eye()))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn view(projection: ViewProjection, near: f32, far: Option<f32>) -> SceneView {
        let place = Vec3::new(1.0, -2.0, 3.0);
        let view_from_world = glam::camera::rh::view::look_at_affine3a(place, Vec3::new(4.0, 1.0, -2.0), Vec3::Y);
        let world_from_view = view_from_world.inverse();
        let (id, name, lens) = (SceneId(1), "camera".to_owned(), Lens::default());
        let camera =
            SceneCamera { id, name, world_from_view, projection, near, far, primary: true, lens, grading: None };
        SceneView { camera, size: [320, 200], jitter: [0.0; 2] }
    }

    fn at(view: &SceneView, x: f32, y: f32, distance: f32) -> Vec3 {
        view.camera.world_from_view.transform_point3(Vec3::new(x, y, -distance))
    }

    #[test]
    fn an_orthographic_image_has_one_scale_and_linear_depth() {
        let view = view(ViewProjection::Orthographic { height: 5.0 }, 0.0, Some(40.0));
        let clip = view.clip_from_world();
        for distance in [0.0, 10.0, 30.0, 40.0] {
            let seen = clip * at(&view, 4.0, 2.5, distance).extend(1.0);
            let expected = Vec4::new(1.0, 1.0, 1.0 - distance / 40.0, 1.0);
            assert!(seen.abs_diff_eq(expected, 1e-5), "{distance} m: {seen}, not {expected}");
            let back = view.world_from_clip() * seen;
            assert!(back.abs_diff_eq(at(&view, 4.0, 2.5, distance).extend(1.0), 1e-4));
        }
    }

    #[test]
    fn without_a_far_plane_it_reaches_a_hundred_heights() {
        let camera = view(ViewProjection::Orthographic { height: 5.0 }, 2.0, None).camera;
        assert_eq!((camera.far_plane(), camera.half_height()), (Some(502.0), 2.5));
        assert_eq!(view(ViewProjection::Perspective { vertical_fov: 1.0 }, 2.0, None).camera.far_plane(), None);
    }

    #[test]
    fn eye_and_axis_agree_with_what_is_seen() {
        for projection in
            [ViewProjection::Perspective { vertical_fov: 0.8 }, ViewProjection::Orthographic { height: 3.0 }]
        {
            let view = view(projection, 0.1, Some(100.0));
            let (eye, inverse) = (view.eye_point(), view.world_from_clip());
            for (x, y, distance) in [(0.3, -0.7, 2.0), (-1.0, 0.4, 50.0)] {
                let point = at(&view, x, y, distance);
                assert!((view.axis().dot(point.extend(1.0)) - distance).abs() < 1e-4);
                // The line of sight is that on which all points fall on one pixel.
                let clip = view.clip_from_world() * point.extend(1.0);
                let near = inverse * Vec4::new(clip.x / clip.w, clip.y / clip.w, 1.0, 1.0);
                let sight = (near.truncate() / near.w - point).normalize();
                let to_eye = (eye.truncate() - point * eye.w).normalize();
                assert!(to_eye.abs_diff_eq(sight, 1e-4), "{projection:?}: {to_eye}, not {sight}");
            }
        }
    }
}
