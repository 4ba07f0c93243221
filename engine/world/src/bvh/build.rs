//! The builder: binned surface area heuristic (Wald, "On fast construction of SAH-based bounding volume
//! hierarchies", 2007).

use super::tree::{Bvh, MAX_DEPTH, Node, half_area};
use crate::core::Aabb;
use glam::Vec3;

/// Bins along an axis; more gain nothing measurable.
const BINS: usize = 16;

/// A box on its way into a leaf.
#[derive(Clone, Copy)]
struct Entry {
    bounds: Aabb,
    center: Vec3,
    index: u32,
}

/// A node that is still to be split.
struct Open {
    node: usize,
    first: usize,
    end: usize,
    depth: u32,
}

impl Bvh {
    /// Builds the hierarchy: binned surface area heuristic (Wald 2007), leaves of at most `leaf_size` boxes. Boxes
    /// that are empty or not finite are left out. Equal input gives equal nodes.
    pub fn new(boxes: &[Aabb], leaf_size: usize) -> Self {
        build(boxes, leaf_size.max(1))
    }
}

fn build(boxes: &[Aabb], leaf_size: usize) -> Bvh {
    let usable = |bounds: &Aabb| !bounds.is_empty() && bounds.min.is_finite() && bounds.max.is_finite();
    let entry = |(bounds, index): (&Aabb, u32)| Entry { bounds: *bounds, center: bounds.center(), index };
    let mut entries: Vec<Entry> = boxes.iter().zip(0..).filter(|(bounds, _)| usable(bounds)).map(entry).collect();
    if entries.is_empty() {
        return Bvh::default();
    }
    let mut nodes = Vec::with_capacity(2 * entries.len());
    nodes.push(Node::default());
    let mut open = Vec::from([Open { node: 0, first: 0, end: entries.len(), depth: 1 }]);
    while let Some(Open { node, first, end, depth }) = open.pop() {
        let part = &mut entries[first..end];
        let bounds = part.iter().fold(Aabb::EMPTY, |sum, entry| sum.union(&entry.bounds));
        nodes[node].set_bounds(&bounds);
        let Some(middle) = split(part, &bounds, leaf_size, depth) else {
            (nodes[node].first, nodes[node].count) = (first as u32, (end - first) as u32);
            continue;
        };
        let children = nodes.len();
        nodes[node].first = children as u32;
        nodes.extend([Node::default(), Node::default()]);
        let middle = first + middle;
        open.push(Open { node: children + 1, first: middle, end, depth: depth + 1 });
        open.push(Open { node: children, first, end: middle, depth: depth + 1 });
    }
    Bvh { nodes, order: entries.iter().map(|entry| entry.index).collect() }
}

/// Reorders the entries and says where the second half begins; none if they are best kept as a leaf.
fn split(part: &mut [Entry], bounds: &Aabb, leaf_size: usize, depth: u32) -> Option<usize> {
    if part.len() <= 1 {
        return None;
    }
    let centers = Aabb::from_points(part.iter().map(|entry| entry.center));
    let best = if depth + 1 < MAX_DEPTH { best_plane(part, &centers) } else { None };
    let Some(plane) = best else {
        return (part.len() > leaf_size).then(|| halve(part, &centers));
    };
    // Costs in tests of a box, two a node; a triangle costs as much as a box.
    let as_leaf = part.len() as f32;
    let as_node = 2.0 + plane.cost / half_area(bounds).max(f32::MIN_POSITIVE);
    if part.len() <= leaf_size && as_leaf <= as_node {
        return None;
    }
    let middle = partition(part, |entry| plane.bin_of(entry) < plane.bin);
    if middle == 0 || middle == part.len() {
        return (part.len() > leaf_size).then(|| halve(part, &centers));
    }
    Some(middle)
}

/// A plane between two bins.
struct Plane {
    axis: usize,
    bin: usize,
    low: f32,
    scale: f32,
    /// Areas of both sides, each times the number in it.
    cost: f32,
}

impl Plane {
    fn bin_of(&self, entry: &Entry) -> usize {
        bin(entry.center[self.axis], self.low, self.scale)
    }
}

fn bin(center: f32, low: f32, scale: f32) -> usize {
    (((center - low) * scale) as usize).min(BINS - 1)
}

/// The plane of least cost over all axes; none if all centres coincide.
fn best_plane(part: &[Entry], centers: &Aabb) -> Option<Plane> {
    let planes = (0..3).filter_map(|axis| best_on_axis(part, centers, axis));
    planes.min_by(|a, b| a.cost.total_cmp(&b.cost))
}

fn best_on_axis(part: &[Entry], centers: &Aabb, axis: usize) -> Option<Plane> {
    let (low, extent) = (centers.min[axis], centers.max[axis] - centers.min[axis]);
    let scale = BINS as f32 / extent;
    if !(extent > 0.0 && scale.is_finite()) {
        return None;
    }
    let mut bins = [(Aabb::EMPTY, 0_usize); BINS];
    for entry in part {
        let (bounds, count) = &mut bins[bin(entry.center[axis], low, scale)];
        *bounds = bounds.union(&entry.bounds);
        *count += 1;
    }
    let cost = |(bounds, count): (Aabb, usize)| half_area(&bounds) * count as f32;
    let add = |a: (Aabb, usize), b: (Aabb, usize)| (a.0.union(&b.0), a.1 + b.1);
    let mut right = [(Aabb::EMPTY, 0); BINS];
    right[BINS - 1] = bins[BINS - 1];
    for index in (0..BINS - 1).rev() {
        right[index] = add(right[index + 1], bins[index]);
    }
    let mut left = (Aabb::EMPTY, 0);
    let mut best: Option<Plane> = None;
    for index in 1..BINS {
        left = add(left, bins[index - 1]);
        if left.1 == 0 || right[index].1 == 0 {
            continue;
        }
        let cost = cost(left) + cost(right[index]);
        if best.as_ref().is_none_or(|plane| cost < plane.cost) {
            best = Some(Plane { axis, bin: index, low, scale, cost });
        }
    }
    best
}

/// Halves by count along the longest axis.
fn halve(part: &mut [Entry], centers: &Aabb) -> usize {
    let size = centers.size();
    let axis = (0..3).max_by(|&a, &b| size[a].total_cmp(&size[b])).unwrap_or(0);
    let middle = part.len() / 2;
    let key = |entry: &Entry| entry.center[axis];
    part.select_nth_unstable_by(middle, |a, b| key(a).total_cmp(&key(b)).then(a.index.cmp(&b.index)));
    middle
}

/// Moves what fulfils the condition to the front, and says how many do.
fn partition(part: &mut [Entry], condition: impl Fn(&Entry) -> bool) -> usize {
    let mut middle = 0;
    for index in 0..part.len() {
        if condition(&part[index]) {
            part.swap(index, middle);
            middle += 1;
        }
    }
    middle
}
