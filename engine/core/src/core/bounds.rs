//! Axis-aligned boxes and view frusta.

use glam::{Affine3A, Mat4, Vec3, Vec4};

/// Axis-aligned box. Empty when `min > max`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// Lower corner \[m\].
    pub min: Vec3,
    /// Upper corner \[m\].
    pub max: Vec3,
}

impl Aabb {
    /// Contains nothing; the identity of [`Aabb::union`].
    pub const EMPTY: Self = Self { min: Vec3::INFINITY, max: Vec3::NEG_INFINITY };

    /// The smallest box around the points; those that are not finite are passed over.
    pub fn from_points(points: impl IntoIterator<Item = Vec3>) -> Self {
        points
            .into_iter()
            .filter(|p| p.is_finite())
            .fold(Self::EMPTY, |b, p| Self { min: b.min.min(p), max: b.max.max(p) })
    }

    /// Whether it contains no point at all.
    pub fn is_empty(&self) -> bool {
        !self.min.cmple(self.max).all()
    }

    /// The smallest box around both.
    pub fn union(&self, other: &Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// The part that both share, empty if none.
    pub fn intersection(&self, other: &Self) -> Self {
        Self { min: self.min.max(other.min), max: self.max.min(other.max) }
    }

    /// Centre; zero for the empty box.
    pub fn center(&self) -> Vec3 {
        if self.is_empty() { Vec3::ZERO } else { 0.5 * self.min + 0.5 * self.max }
    }

    /// Edge lengths \[m\]; zero for the empty box.
    pub fn size(&self) -> Vec3 {
        if self.is_empty() { Vec3::ZERO } else { self.max - self.min }
    }

    /// The eight corners.
    pub fn corners(&self) -> [Vec3; 8] {
        std::array::from_fn(|i| {
            Vec3::new(
                if i & 1 == 0 { self.min.x } else { self.max.x },
                if i & 2 == 0 { self.min.y } else { self.max.y },
                if i & 4 == 0 { self.min.z } else { self.max.z },
            )
        })
    }

    /// Bounds of the transformed box (Arvo, Graphics Gems 1990, "Transforming axis-aligned bounding boxes").
    pub fn transformed(&self, target_from_source: &Affine3A) -> Self {
        if self.is_empty() {
            return Self::EMPTY;
        }
        let center = target_from_source.transform_point3(self.center());
        let half = 0.5 * self.size();
        let m = target_from_source.matrix3;
        let extent = Vec3::from(m.x_axis.abs()) * half.x
            + Vec3::from(m.y_axis.abs()) * half.y
            + Vec3::from(m.z_axis.abs()) * half.z;
        Self { min: center - extent, max: center + extent }
    }

    /// Distance from a point to the box \[m\]; zero inside.
    pub fn distance(&self, point: Vec3) -> f32 {
        if self.is_empty() {
            return f32::INFINITY;
        }
        (self.min - point).max(point - self.max).max(Vec3::ZERO).length()
    }
}

/// The planes of a clip space, pointing inwards: n·p + d ≥ 0 inside. Reversed or not, finite or infinite far plane.
#[derive(Clone, Copy, Debug)]
pub struct Frustum {
    /// n and d of four planes at a time: their x, their y, their z, their d.
    planes: [[Vec4; 4]; 2],
}

impl Frustum {
    /// Planes of the matrix's clip volume −w ≤ x, y ≤ w, 0 ≤ z ≤ w (Gribb and Hartmann 2001).
    pub fn new(clip_from_world: &Mat4) -> Self {
        let r = clip_from_world.transpose();
        let (x, y, z, w) = (r.x_axis, r.y_axis, r.z_axis, r.w_axis);
        // The last two stand there twice, so that it is eight.
        let four = |planes: [Vec4; 4]| {
            let lanes = Mat4::from_cols(planes[0], planes[1], planes[2], planes[3]).transpose();
            [lanes.x_axis, lanes.y_axis, lanes.z_axis, lanes.w_axis]
        };
        Self { planes: [four([w + x, w - x, w + y, w - y]), four([z, w - z, z, w - z])] }
    }

    /// False only if the box is certainly outside (conservative).
    pub fn intersects(&self, aabb: &Aabb) -> bool {
        // A NaN (infinite far plane times zero) must not cull.
        !aabb.is_empty() && self.planes.iter().all(|four| !farthest(four, aabb.min, aabb.max).cmplt(Vec4::ZERO).any())
    }

    /// True only if the box is certainly inside; then [`Frustum::intersects`] holds for every box in it that is not
    /// empty, to the bit, since roundings keep the order of sums.
    pub fn holds(&self, aabb: &Aabb) -> bool {
        // The nearest corner is the farthest of the box with its corners swapped.
        !aabb.is_empty() && self.planes.iter().all(|four| farthest(four, aabb.max, aabb.min).cmpge(Vec4::ZERO).all())
    }
}

/// Distances, in lengths of their normals, to four planes of the corner that lies farthest along each one's normal.
fn farthest([x, y, z, d]: &[Vec4; 4], min: Vec3, max: Vec3) -> Vec4 {
    let along = |normal: Vec4, min: f32, max: f32| Vec4::select(normal.cmpge(Vec4::ZERO), normal * max, normal * min);
    along(*x, min.x, max.x) + along(*y, min.y, max.y) + along(*z, min.z, max.z) + *d
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Quat;
    use proptest::prelude::*;

    #[test]
    fn transformed_box_holds_every_transformed_corner() {
        let aabb = Aabb { min: Vec3::new(-1.0, 2.0, 0.5), max: Vec3::new(3.0, 2.5, 4.0) };
        let m = Affine3A::from_scale_rotation_translation(
            Vec3::new(-2.0, 0.5, 3.0),
            Quat::from_euler(glam::EulerRot::XYZ, 0.3, 1.1, -2.0),
            Vec3::new(5.0, -6.0, 7.0),
        );
        let bounds = aabb.transformed(&m);
        let exact = Aabb::from_points(aabb.corners().map(|c| m.transform_point3(c)));
        assert!(
            bounds.min.abs_diff_eq(exact.min, 1e-4) && bounds.max.abs_diff_eq(exact.max, 1e-4),
            "{bounds:?} {exact:?}"
        );
    }

    #[test]
    fn frustum_keeps_what_it_sees_and_drops_what_lies_behind() {
        let clip_from_world = crate::core::perspective(1.0, 1.0, 0.1, Some(10.0));
        let frustum = Frustum::new(&clip_from_world);
        let at = |z: f32| Aabb { min: Vec3::new(-0.1, -0.1, z - 0.1), max: Vec3::new(0.1, 0.1, z + 0.1) };
        assert!(frustum.intersects(&at(-5.0)));
        assert!(!frustum.intersects(&at(5.0)));
        assert!(!frustum.intersects(&at(-50.0)));
        assert!(!frustum.intersects(&Aabb::EMPTY));
    }

    fn corner() -> impl Strategy<Value = Vec3> {
        prop::array::uniform3(-20.0_f32..20.0).prop_map(Vec3::from)
    }

    fn view() -> impl Strategy<Value = Frustum> {
        (corner(), corner(), 0.2_f32..3.0, prop::option::of(1.0_f32..40.0)).prop_map(|(eye, center, fov, far)| {
            let up = if (center - eye).normalize_or_zero().y.abs() > 0.9 { Vec3::X } else { Vec3::Y };
            let view_from_world = glam::camera::rh::view::look_at_mat4(eye, center + Vec3::splat(0.001), up);
            Frustum::new(&(crate::core::perspective(fov, 1.5, 0.1, far) * view_from_world))
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]

        #[test]
        fn a_box_in_a_box_inside_is_seen_and_in_a_box_outside_is_not(
            frustum in view(), (a, b) in (corner(), corner()), size in 0.0_f32..1.0,
            parts in prop::array::uniform2(prop::array::uniform3(0.0_f32..=1.0)),
        ) {
            let outer = Aabb { min: a.min(a.lerp(b, size)), max: a.max(a.lerp(b, size)) };
            let at = |t: [f32; 3]| (outer.min + (outer.max - outer.min) * Vec3::from(t)).min(outer.max);
            let inner = Aabb::from_points(parts.map(at));
            prop_assert!(!frustum.holds(&outer) || frustum.intersects(&inner));
            prop_assert!(frustum.intersects(&outer) || !frustum.intersects(&inner));
            prop_assert!(!frustum.holds(&inner) || frustum.intersects(&inner));
        }
    }

    #[test]
    fn a_box_that_a_border_cuts_is_seen_and_not_held() {
        let frustum = Frustum::new(&crate::core::perspective(1.0, 1.0, 0.1, Some(10.0)));
        let at =
            |z: f32, half: f32| Aabb { min: Vec3::new(-half, -half, z - 1.0), max: Vec3::new(half, half, z + 1.0) };
        assert!(frustum.holds(&at(-5.0, 0.5)));
        for cut in [at(-5.0, 9.0), at(-10.0, 0.5), at(0.0, 0.01)] {
            assert!(frustum.intersects(&cut) && !frustum.holds(&cut), "{cut:?}");
        }
        assert!(!frustum.holds(&Aabb::EMPTY));
    }
}
