//! Where objects stood in the frame before, so that what is known of their surfaces moves with them: motion vectors, by object
//! instead of by pixel. See `lib/motion.wgsl`.

use crate::gpu::Gpu;
use crate::scene::Scene;
use bytemuck::{Pod, Zeroable};
use glam::{Affine3A, DAffine3};
use std::collections::HashMap;
use wgpu::BufferUsages;

/// `Moved` of `lib/motion.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub(crate) struct Moved {
    /// World of the frame before from that of this one, row by row.
    rows: [[f32; 4]; 3],
    id: u32,
    padding: [u32; 3],
}

/// Where moving objects stand, and where they stood a frame ago.
#[derive(Default)]
pub(crate) struct Motions {
    places: HashMap<u64, Affine3A>,
    /// Those that are elsewhere now, by their identity.
    moved: Vec<Moved>,
    buffer: Option<wgpu::Buffer>,
}

impl Motions {
    /// Takes note of a frame. What was not there in the last one, and what is or was squeezed flat, has no place before.
    pub fn update(&mut self, gpu: &Gpu, scene: &Scene) {
        let moving = || scene.primitives.iter().filter(|primitive| primitive.moving);
        self.moved.clear();
        self.moved.extend(moving().filter_map(|primitive| {
            let now = primitive.world_from_object;
            let before = self.places.get(&primitive.id.0).filter(|before| **before != now)?;
            Moved::new(primitive.id.0 as u32, before, &now)
        }));
        self.moved.sort_unstable_by_key(|moved| moved.id);
        self.places.clear();
        self.places.extend(moving().map(|primitive| (primitive.id.0, primitive.world_from_object)));
        self.buffer =
            (!self.moved.is_empty()).then(|| gpu.storage("moved objects", &self.moved, BufferUsages::empty()));
    }

    /// The objects that moved, as shaders read them; none if none did.
    pub fn buffer(&self) -> Option<&wgpu::Buffer> {
        self.buffer.as_ref()
    }
}

impl Moved {
    fn new(id: u32, before: &Affine3A, now: &Affine3A) -> Option<Self> {
        let wide =
            |place: &Affine3A| DAffine3::from_mat3_translation(place.matrix3.as_dmat3(), place.translation.as_dvec3());
        let way = wide(before) * wide(now).inverse();
        let m = (way.is_finite() && way.matrix3.determinant() != 0.0).then(|| way.as_affine3a())?;
        let rows = [0, 1, 2].map(|i| [m.x_axis[i], m.y_axis[i], m.z_axis[i], m.translation[i]]);
        Some(Self { rows, id, padding: [0; 3] })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Quat, Vec3};

    #[test]
    fn what_moved_is_found_where_it_was() {
        let before = Affine3A::from_scale_rotation_translation(
            Vec3::new(2.0, 1.0, 0.5),
            Quat::from_rotation_y(0.3),
            Vec3::new(100.0, 2.0, -3.0),
        );
        let now = Affine3A::from_rotation_x(0.7) * before;
        let moved = Moved::new(3, &before, &now).expect("a place");
        let point = Vec3::new(0.3, -0.2, 0.9);
        let (from, to) = (now.transform_point3(point).extend(1.0), before.transform_point3(point));
        let found = Vec3::from_array(moved.rows.map(|row| glam::Vec4::from_array(row).dot(from)));
        assert!(found.distance(to) < 1e-4, "{found}, not {to}");
        let flat = Affine3A::from_scale(Vec3::new(1.0, 0.0, 1.0));
        assert_eq!(Moved::new(3, &before, &flat), None, "what is flat has no inverse");
        assert_eq!(Moved::new(3, &flat, &before), None, "what was flat had no normal");
    }
}
