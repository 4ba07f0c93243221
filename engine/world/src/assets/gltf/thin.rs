//! Points and lines as thin solids, so that all passes see them: drawing, shadows, light and rays.

use super::face_normal::face_normal;
use crate::assets::Vertex;
use glam::Vec3;
use gltf::mesh::Mode;

/// Half the width of a line, and half the size of a point, as a part of the primitive's diagonal.
const HALF_WIDTH: f32 = 1.0 / 200.0;

/// Whether a primitive has points or lines.
pub(super) fn is_thin(mode: Mode) -> bool {
    matches!(mode, Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip)
}

/// Vertices, three for each triangle, and which vertex of the primitive each stands for. Without normals of their own:
/// faces are flat.
pub(super) fn solids(mode: Mode, vertices: &[Vertex], corners: &[u32]) -> (Vec<Vertex>, Vec<u32>) {
    let position = |i: u32| Vec3::from(vertices[i as usize].position);
    let (low, high) = corners
        .iter()
        .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), i| (low.min(position(*i)), high.max(position(*i))));
    let diagonal = (high - low).length();
    let half = HALF_WIDTH * if diagonal > 0.0 && diagonal.is_finite() { diagonal } else { 1.0 };
    let mut out = (Vec::new(), Vec::new());
    let mut add = |triangle: [(u32, Vec3); 3]| {
        let normal = face_normal(triangle.map(|(_, place)| place.to_array())).to_array();
        for (origin, place) in triangle {
            out.0.push(Vertex { position: place.to_array(), normal, ..vertices[origin as usize] });
            out.1.push(origin);
        }
    };
    for [start, end] in segments(mode, corners) {
        let axis = (position(end) - position(start)).try_normalize();
        let Some(axis) = axis.or((mode == Mode::Points).then_some(Vec3::X)) else { continue };
        let (side, up) = axis.any_orthonormal_pair();
        let around = [side, up, -side, -up].map(|d| half * d);
        for i in 0..4 {
            let (here, next) = (around[i], around[(i + 1) % 4]);
            let (a, b) = (position(start), position(end));
            if mode == Mode::Points {
                add([(start, a + here), (start, a + next), (start, a + half * axis)]);
                add([(start, a + next), (start, a + here), (start, a - half * axis)]);
                continue;
            }
            add([(start, a + here), (start, a + next), (end, b + next)]);
            add([(start, a + here), (end, b + next), (end, b + here)]);
            add([(start, a + next), (start, a + here), (start, a)]);
            add([(end, b + here), (end, b + next), (end, b)]);
        }
    }
    out
}

/// Ends of the lines; a point is a line without length.
pub(super) fn segments(mode: Mode, corners: &[u32]) -> Vec<[u32; 2]> {
    let strip = || corners.windows(2).map(|pair| [pair[0], pair[1]]);
    match (mode, corners) {
        (Mode::Points, _) => corners.iter().map(|i| [*i, *i]).collect(),
        (Mode::LineStrip, _) => strip().collect(),
        (Mode::LineLoop, [first, .., last]) => strip().chain([[*last, *first]]).collect(),
        (Mode::LineLoop, _) => Vec::new(),
        _ => corners.as_chunks::<2>().0.to_vec(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn corner(x: f32, y: f32) -> Vertex {
        Vertex { position: [x, y, 0.0], normal: [0.0; 3], tangent: [0.0; 4], uv: [x, y] }
    }

    /// Volume by the divergence theorem: positive if all faces look outwards and leave no gap.
    fn volume(vertices: &[Vertex]) -> f32 {
        let corners = vertices.as_chunks::<3>().0.iter();
        corners.map(|t| t.map(|v| Vec3::from(v.position))).map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum()
    }

    #[test]
    fn lines_are_closed_solids_of_their_length() {
        let vertices = [corner(0.0, 0.0), corner(3.0, 4.0), corner(3.0, 0.0)];
        // Squares across the diagonal.
        let section = 2.0 * (5.0 * HALF_WIDTH).powi(2);
        for (mode, length) in [(Mode::LineStrip, 9.0), (Mode::LineLoop, 12.0), (Mode::Lines, 5.0)] {
            let (solid, origins) = solids(mode, &vertices, &[0, 1, 2]);
            let found = volume(&solid);
            assert!((found / (section * length) - 1.0).abs() < 1e-2, "{mode:?}: {found}, {}", section * length);
            assert!(solid.iter().zip(&origins).all(|(v, i)| v.uv == vertices[*i as usize].uv));
        }
    }

    #[test]
    fn points_are_octahedra_and_lines_without_length_are_nothing() {
        let vertices = [corner(0.0, 0.0), corner(3.0, 4.0)];
        let (solid, _) = solids(Mode::Points, &vertices, &[0, 1]);
        assert_eq!(solid.len(), 2 * 8 * 3);
        // 4/3·r³ each.
        assert!(
            (volume(&solid) / (2.0 * 4.0 / 3.0 * (5.0 * HALF_WIDTH).powi(3)) - 1.0).abs() < 0.05,
            "{}",
            volume(&solid)
        );
        assert!(solids(Mode::Lines, &vertices, &[1, 1]).0.is_empty());
        assert!(solids(Mode::LineLoop, &vertices, &[0]).0.is_empty());
    }
}
