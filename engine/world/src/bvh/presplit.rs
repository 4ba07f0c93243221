//! Triangles that lie across the axes fill little of their boxes: a ray through a room of turned walls meets the boxes of
//! most of them. Before the hierarchy is built such triangles are cut into pieces with boxes of their own (early split
//! clipping, Ernst and Greiner 2007), a limited number of them, where most is gained (Karras and Aila 2013, "Fast parallel
//! construction of high-quality bounding volume hierarchies", section 4.2). Pieces refer to their whole triangle.

use super::tree::half_area;
use crate::core::Aabb;
use glam::Vec3;

/// Pieces that a small scene may have beside its triangles.
const FEW: usize = 16_384;
/// Most pieces of a triangle, in a small scene and on average.
const PIECES: usize = 8;
/// By how much boxes of pieces overlap: part of the largest coordinate and extent. Rounding must hide no hit between them.
const OVERLAP: f32 = 1e-5;

/// A piece of a triangle on its way to be cut further.
struct Piece {
    /// Corners of the convex polygon \[m\].
    corners: Vec<Vec3>,
    bounds: Aabb,
    cuts: usize,
}

/// The boxes of triangles and of pieces of triangles, each with the index of the triangle. Boxes that are empty stay so.
/// Equal input gives equal boxes. Only triangles that `may_split` are cut: rays that go through glass must meet each of its
/// triangles once.
pub(crate) fn presplit(triangles: &[[Vec3; 3]], boxes: &[Aabb], may_split: &[bool]) -> (Vec<Aabb>, Vec<u32>) {
    let whole = boxes.iter().fold(Aabb::EMPTY, |sum, bounds| sum.union(bounds));
    let cuts = cuts(triangles, boxes, may_split);
    let (mut pieces, mut indices) = (Vec::with_capacity(boxes.len()), Vec::with_capacity(boxes.len()));
    for (index, &cuts) in (0..).zip(&cuts) {
        let bounds = boxes[index as usize];
        let before = pieces.len();
        if cuts > 0 {
            let corners = triangles[index as usize].to_vec();
            cut_all(Piece { corners, bounds, cuts }, &bounds, &whole, &mut pieces);
        }
        if pieces.len() == before {
            pieces.push(bounds);
        }
        indices.resize(pieces.len(), index);
    }
    (pieces, indices)
}

/// How many times each triangle is cut: in proportion to the cube root of what its box has too much, as Karras and Aila
/// do, so that few large ones do not take all.
fn cuts(triangles: &[[Vec3; 3]], boxes: &[Aabb], may_split: &[bool]) -> Vec<usize> {
    let weight = |((corners, bounds), may_split): ((&[Vec3; 3], &Aabb), &bool)| {
        if *may_split { excess(corners, bounds).cbrt() } else { 0.0 }
    };
    let weights: Vec<f64> = triangles.iter().zip(boxes).zip(may_split).map(weight).collect();
    let total: f64 = weights.iter().sum();
    let budget = (boxes.len() / 3).max(FEW.min(PIECES * boxes.len()));
    let scale = if total > 0.0 { budget as f64 / total } else { 0.0 };
    weights.iter().map(|weight| (weight * scale) as usize).collect()
}

/// Half area by which a box is larger than that of a right triangle along the axes with the same projections \[m²\].
fn excess([a, b, c]: &[Vec3; 3], bounds: &Aabb) -> f64 {
    if bounds.is_empty() {
        return 0.0;
    }
    let projected = (*b - *a).cross(*c - *a).abs().element_sum();
    let excess = f64::from(half_area(bounds)) - 1.001 * f64::from(projected);
    if excess.is_finite() { excess.max(0.0) } else { 0.0 }
}

fn cut_all(piece: Piece, triangle: &Aabb, whole: &Aabb, boxes: &mut Vec<Aabb>) {
    let mut open = vec![piece];
    while let Some(piece) = open.pop() {
        let halves = if piece.cuts > 0 { cut(&piece, triangle, whole) } else { None };
        match halves {
            Some(halves) => open.extend(halves),
            None => boxes.push(piece.bounds),
        }
    }
}

/// Both halves of a piece, on either side of the plane that [`plane`] finds; none if it cannot be cut.
fn cut(piece: &Piece, triangle: &Aabb, whole: &Aabb) -> Option<[Piece; 2]> {
    let (axis, at) = plane(&piece.bounds, whole)?;
    let overlap = OVERLAP * whole.min.abs().max(whole.max.abs()).max_element();
    let half = |side: f32| {
        let corners = clip(&piece.corners, axis, at, side);
        let exact = Aabb::from_points(corners.iter().copied());
        let wider = Aabb { min: exact.min - overlap, max: exact.max + overlap };
        let bounds = wider.intersection(triangle);
        (corners.len() >= 3 && !bounds.is_empty()).then_some((corners, bounds))
    };
    let (low, high) = (half(1.0)?, half(-1.0)?);
    let sizes = [&low, &high].map(|(_, bounds)| bounds.size().max_element());
    let left = piece.cuts - 1;
    let of_low = ((left as f32 * sizes[0] / (sizes[0] + sizes[1]).max(f32::MIN_POSITIVE)).round() as usize).min(left);
    let piece = |(corners, bounds), cuts| Piece { corners, bounds, cuts };
    Some([piece(low, of_low), piece(high, left - of_low)])
}

/// The coarsest plane that halves, quarters … the whole and goes through a box: pieces of neighbours then end alike.
fn plane(bounds: &Aabb, whole: &Aabb) -> Option<(usize, f32)> {
    let size = whole.size().max_element();
    let mut step = 0.5 * size;
    for _ in 0..20 {
        for axis in 0..3 {
            let (low, high) = (bounds.min[axis], bounds.max[axis]);
            let at = whole.min[axis] + ((low - whole.min[axis]) / step + 1.0).floor() * step;
            // Not next to an end: the piece would be as large as before.
            let margin = 0.05 * (high - low);
            if at > low + margin && at < high - margin {
                return Some((axis, at));
            }
        }
        step *= 0.5;
    }
    None
}

/// The part of a convex polygon below a plane across an axis (`side` 1) or above it (−1) (Sutherland and Hodgman 1974).
fn clip(corners: &[Vec3], axis: usize, at: f32, side: f32) -> Vec<Vec3> {
    let inside = |point: Vec3| side * (at - point[axis]);
    let mut kept = Vec::with_capacity(corners.len() + 1);
    for (index, &corner) in corners.iter().enumerate() {
        let next = corners[(index + 1) % corners.len()];
        let (here, there) = (inside(corner), inside(next));
        if here >= 0.0 {
            kept.push(corner);
        }
        if (here > 0.0 && there < 0.0) || (here < 0.0 && there > 0.0) {
            kept.push(corner + (next - corner) * (here / (here - there)));
        }
    }
    kept
}
