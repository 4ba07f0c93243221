//! Where particles of a directional light start: side by side before the scene, and only where something is in their way.

use super::random::frame;
use crate::bvh::Bvh;
use crate::scene::Aabb;
use crate::scene::SceneBvh;
use glam::{Vec2, Vec3, Vec3Swizzles};

/// Cells along an edge of the rectangle before the scene; a column is the bits of a `u64`.
const CELLS: usize = 64;
/// Triangles seem larger by this \[cells\], so that rounding leaves none out.
const MARGIN: f32 = 1e-3;

/// The part of the rectangle before the scene, across a direction, behind which there is anything. Starting in all of
/// the rectangle would be right too, but particles that pass the scene are lost: three quarters of them for a sparse
/// scene under a low sun.
#[derive(Clone, Debug, Default)]
pub(super) struct Beam {
    corner: Vec3,
    right: Vec3,
    up: Vec3,
    columns: Vec<u64>,
    /// Cells of all columns together.
    cells: u32,
}

impl Beam {
    pub(super) fn new(direction: Vec3, bounds: &Aabb, bvh: &SceneBvh) -> Self {
        let axes = frame(direction);
        let local = Aabb::from_points(bounds.corners().map(|corner| axes.transpose() * corner));
        // Before the first surface, by a little of the scene's depth.
        let start = local.min.z - 1e-3 * local.size().max_element();
        let mut beam = Self {
            corner: axes * Vec3::new(local.min.x, local.min.y, start),
            right: axes.x_axis * local.size().x,
            up: axes.y_axis * local.size().y,
            columns: vec![0; CELLS],
            cells: 0,
        };
        let scale = CELLS as f32 / local.size().xy().max(Vec2::splat(f32::MIN_POSITIVE));
        let to_cells = |p: Vec3| ((axes.transpose() * p).xy() - local.min.xy()) * scale;
        beam.find_cells(bvh, &to_cells);
        beam.cells = beam.columns.iter().map(|column| column.count_ones()).sum();
        if beam.cells == 0 {
            beam.columns.fill(u64::MAX);
            beam.cells = (CELLS * CELLS) as u32;
        }
        beam
    }

    /// Marks the cells before all triangles: from the roots of the hierarchies to boxes that are no larger than a cell.
    fn find_cells(&mut self, bvh: &SceneBvh, to_cells: &dyn Fn(Vec3) -> Vec2) {
        for tree in bvh.trees() {
            self.find_cells_of(tree, bvh, to_cells);
        }
    }

    fn find_cells_of(&mut self, tree: &Bvh, bvh: &SceneBvh, to_cells: &dyn Fn(Vec3) -> Vec2) {
        let mut stack: Vec<u32> = (0..tree.nodes.len().min(1) as u32).collect();
        while let Some(index) = stack.pop() {
            let node = &tree.nodes[index as usize];
            let corners = node.bounds().corners().map(to_cells);
            let low = corners.iter().copied().reduce(Vec2::min).unwrap_or_default();
            let high = corners.iter().copied().reduce(Vec2::max).unwrap_or_default();
            if (high - low).max_element() <= 1.0 {
                self.mark(low, high, |_| true);
            } else if node.count == 0 {
                stack.extend([node.first, node.first + 1]);
            } else {
                for &triangle in &tree.order[node.first as usize..][..node.count as usize] {
                    self.mark_triangle(bvh.triangles[triangle as usize].corners.map(to_cells));
                }
            }
        }
    }

    fn mark_triangle(&mut self, [a, b, c]: [Vec2; 3]) {
        let double = (b - a).perp_dot(c - a);
        let sign = if double < 0.0 { -1.0 } else { 1.0 };
        let edges = [(a, b), (b, c), (c, a)];
        // A cell is out if its corner that lies farthest inwards is still outside of an edge.
        let inside = |middle: Vec2| {
            edges.iter().all(|&(from, to)| {
                let inward = (to - from).perp() * sign;
                inward.dot(middle - from) + 0.5 * (inward.abs().element_sum()) + MARGIN * inward.length() >= 0.0
            })
        };
        self.mark(a.min(b).min(c), a.max(b).max(c), inside);
    }

    /// Marks the cells of a rectangle whose middle the test takes.
    fn mark(&mut self, low: Vec2, high: Vec2, takes: impl Fn(Vec2) -> bool) {
        let last = CELLS as f32 - 1.0;
        let first = (low - MARGIN).floor().clamp(Vec2::ZERO, Vec2::splat(last)).as_usizevec2();
        let end = (high + MARGIN).floor().clamp(Vec2::ZERO, Vec2::splat(last)).as_usizevec2();
        for x in first.x..=end.x {
            for y in first.y..=end.y {
                if takes(Vec2::new(x as f32 + 0.5, y as f32 + 0.5)) {
                    self.columns[x] |= 1 << y;
                }
            }
        }
    }

    /// Area that particles start in \[m²\].
    pub(super) fn area(&self) -> f32 {
        self.right.length() * self.up.length() * (self.cells as f32 / (CELLS * CELLS) as f32)
    }

    /// The start point of a pair of numbers in [0, 1): columns by their cells, then the cells of the column, so that
    /// what is even in the numbers stays even.
    pub(super) fn start(&self, u: Vec2) -> Vec3 {
        let at = u.x * self.cells as f32;
        let mut before = 0.0;
        for (x, column) in self.columns.iter().enumerate() {
            let own = column.count_ones() as f32;
            if at < before + own {
                let across = x as f32 + (at - before) / own;
                let along = cell_at(*column, u.y * own);
                return self.corner + (across * self.right + along * self.up) / CELLS as f32;
            }
            before += own;
        }
        self.corner
    }
}

/// Place along a column at so many of its cells.
fn cell_at(column: u64, at: f32) -> f32 {
    let mut left = column;
    for _ in 0..at as u32 {
        left &= left.wrapping_sub(1);
    }
    left.trailing_zeros().min(CELLS as u32 - 1) as f32 + at.fract()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn cells_of_a_column_are_counted() {
        let column = 0b1011_0000;
        assert_eq!([0.0, 0.5, 1.25, 2.75].map(|at| cell_at(column, at)), [4.0, 4.5, 5.25, 7.75]);
    }

    #[test]
    fn a_triangle_marks_what_it_covers_and_its_border() {
        let mut beam = Beam { columns: vec![0; CELLS], ..Default::default() };
        beam.mark_triangle([Vec2::new(10.0, 10.0), Vec2::new(42.0, 10.0), Vec2::new(10.0, 42.0)]);
        let marked: u32 = beam.columns.iter().map(|column| column.count_ones()).sum();
        // Half of 32 × 32, the diagonal, and those that it touches.
        assert!((528..=700).contains(&marked), "{marked}");
        for i in 0..2000 {
            let (s, t) = ((i as f32 * 0.618_034).fract(), (i as f32 * 0.754_878).fract());
            let (s, t) = if s + t > 1.0 { (1.0 - s, 1.0 - t) } else { (s, t) };
            let [x, y] = [10.0 + 32.0 * s, 10.0 + 32.0 * t].map(|c| c as usize);
            assert!(beam.columns[x] >> y & 1 == 1, "cell {x}, {y}");
        }
    }
}
