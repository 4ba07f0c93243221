//! Transforms, relative to a parent and in the world.

use bevy_ecs::prelude::*;
use glam::{Affine3A, DVec3, Mat3, Mat3A, Quat, Vec3};

/// Place relative to the parent: scale first, then rotation, then translation.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
#[require(GlobalTransform, Orientation)]
pub struct Transform {
    /// Translation \[m\].
    pub translation: Vec3,
    /// Rotation; need not be normalised in files, is normalised on use.
    pub rotation: Quat,
    /// Scale along the local axes; negative mirrors.
    pub scale: Vec3,
}

impl Default for Transform {
    fn default() -> Self {
        Self { translation: Vec3::ZERO, rotation: Quat::IDENTITY, scale: Vec3::ONE }
    }
}

impl Transform {
    /// At a position \[m\].
    pub fn from_xyz(x: f32, y: f32, z: f32) -> Self {
        Self::from_translation(Vec3::new(x, y, z))
    }

    /// At a position \[m\].
    pub fn from_translation(translation: Vec3) -> Self {
        Self { translation, ..Self::default() }
    }

    /// Turned.
    pub fn from_rotation(rotation: Quat) -> Self {
        Self { rotation, ..Self::default() }
    }

    /// The same with another rotation.
    #[must_use]
    pub fn with_rotation(self, rotation: Quat) -> Self {
        Self { rotation, ..self }
    }

    /// The same with another scale along the local axes.
    #[must_use]
    pub fn with_scale(self, scale: Vec3) -> Self {
        Self { scale, ..self }
    }

    /// The same, turned so that −Z points to a place beside it, and +Y as far up as it goes.
    #[must_use]
    pub fn looking_at(self, target: Vec3) -> Self {
        Self { rotation: look_rotation(target - self.translation), ..self }
    }

    /// Where −Z points, among its siblings: the direction of cameras and beams.
    pub fn forward(&self) -> Vec3 {
        self.unit_rotation() * Vec3::NEG_Z
    }

    /// The matrix `parent_from_local`.
    pub fn matrix(&self) -> Affine3A {
        Affine3A::from_scale_rotation_translation(self.scale, self.unit_rotation(), self.translation)
    }

    /// The rotation, normalised; none at all if its length is zero or not finite.
    pub fn unit_rotation(&self) -> Quat {
        // Keeps the squares in range.
        let largest = self.rotation.to_array().into_iter().fold(0.0_f32, |m, c| m.max(c.abs()));
        let scale = if (1e-15..1e15).contains(&largest) { 1.0 } else { largest.recip() };
        let length = (self.rotation * scale).length();
        if length.is_finite() && length > 0.0 { self.rotation * scale / length } else { Quat::IDENTITY }
    }
}

/// The rotation that turns −Z to the direction, +Y as far up as it goes.
pub fn look_rotation(direction: Vec3) -> Quat {
    let Some(forward) = direction.try_normalize() else { return Quat::IDENTITY };
    let up = if forward.y.abs() > 0.9999 { Vec3::NEG_Z * forward.y.signum() } else { Vec3::Y };
    let right = forward.cross(up).normalize_or(Vec3::X);
    Quat::from_mat3(&Mat3::from_cols(right, right.cross(forward), -forward)).normalize()
}

/// World place, computed from the [`Transform`]s up the hierarchy once a frame.
///
/// Far from the origin the numbers of single precision are coarse: 8 mm apart at 100 km. What the translation loses by
/// them is kept beside it, so that what stands on the same distant parent fits together, see
/// [`relative_to`](Self::relative_to).
#[derive(Component, Clone, Copy, Debug, Default, PartialEq)]
pub struct GlobalTransform(pub Affine3A, #[doc(hidden)] pub Vec3);

impl GlobalTransform {
    /// World place on an origin of one's own \[m\], such as `Scene::origin`.
    pub fn relative_to(&self, origin: DVec3) -> Affine3A {
        let translation = self.translation() - origin;
        Affine3A { matrix3: self.0.matrix3, translation: translation.as_vec3().into() }
    }

    /// World position \[m\].
    pub fn position(&self) -> Vec3 {
        self.0.translation.into()
    }

    /// World position \[m\] in all its precision.
    pub fn translation(&self) -> DVec3 {
        Vec3::from(self.0.translation).as_dvec3() + self.1.as_dvec3()
    }

    /// A place of so much precision as two single numbers hold.
    #[doc(hidden)]
    pub fn new(matrix3: Mat3A, translation: DVec3) -> Self {
        let high = translation.as_vec3();
        // Beyond the range of single precision nothing is left to keep.
        let low = if high.is_finite() { (translation - high.as_dvec3()).as_vec3() } else { Vec3::ZERO };
        Self(Affine3A { matrix3, translation: high.into() }, low)
    }
}

/// World orientation, computed with the [`GlobalTransform`]: right-handed orthonormal axes, whatever the scale. The
/// entity's own scale plays no part; a parent that mirrors turns −Z to where it shows in the mirror.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq)]
pub struct Orientation(pub Mat3A);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_made_in_a_line() {
        let place = Transform::from_xyz(0.0, 1.0, 5.0).looking_at(Vec3::Y).with_scale(Vec3::splat(2.0));
        assert!(place.forward().abs_diff_eq(Vec3::NEG_Z, 1e-6) && place.scale == Vec3::splat(2.0));
        let aside = place.looking_at(Vec3::new(5.0, 1.0, 5.0));
        assert!(aside.forward().abs_diff_eq(Vec3::X, 1e-6), "{}", aside.forward());
        let turned = Transform::from_rotation(aside.rotation).with_rotation(Quat::IDENTITY);
        assert_eq!((turned, Transform::from_translation(Vec3::ZERO)), (Transform::default(), Transform::default()));
    }
}
