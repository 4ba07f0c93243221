//! What helps to see what is going on: lines over the picture.

use crate::scene::Aabb;
use glam::Vec3;

/// The twelve edges of a box.
pub fn box_edges(bounds: &Aabb) -> [[Vec3; 2]; 12] {
    let corner = |i: usize| {
        let pick = |bit: usize, axis: usize| if i >> bit & 1 == 0 { bounds.min[axis] } else { bounds.max[axis] };
        Vec3::new(pick(0, 0), pick(1, 1), pick(2, 2))
    };
    const EDGES: [[usize; 2]; 12] =
        [[0, 1], [2, 3], [4, 5], [6, 7], [0, 2], [1, 3], [4, 6], [5, 7], [0, 4], [1, 5], [2, 6], [3, 7]];
    EDGES.map(|edge| edge.map(corner))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_has_four_edges_along_each_axis() {
        let edges = box_edges(&Aabb { min: Vec3::ZERO, max: Vec3::new(1.0, 2.0, 3.0) });
        for (axis, length) in [(0, 1.0), (1, 2.0), (2, 3.0)] {
            let along = edges.iter().filter(|[a, b]| (*b - *a)[axis] == length && (*b - *a).length() == length);
            assert_eq!(along.count(), 4);
        }
    }
}
