//! A hierarchy whose nodes have up to eight children (Dammertz et al. 2008, "Shallow bounding volume hierarchies for fast
//! SIMD ray tracing of incoherent rays"), with boxes of a byte a coordinate (Ylitie et al. 2017, "Efficient incoherent ray
//! traversal on GPUs through compressed wide BVHs"): a ray waits for memory a few times where lists of boxes make it wait
//! at each box.
//!
//! A node's children lie in slots by where they lie in its box: bit i of a slot says that the child is on the upper side of
//! axis i. Of slots whose numbers are combined with the octant of a direction (exclusive or) the lowest come first on the
//! way of a ray.

use super::words::Texel;
use crate::bvh::{Bvh, MAX_DEPTH, Node};
use crate::scene::Aabb;
use glam::Vec3;

/// Texels of a node.
pub(super) const TEXELS: usize = 6;
/// Children of a node.
const WIDTH: usize = 8;
/// Most nodes from a root to a leaf. Two such trees, one above the other, are what `waiting` of `lib/walk.wgsl` has room
/// for. A binary hierarchy halves below [`MAX_DEPTH`], and so has at most 23 levels more with 2²³ leaves of two triangles,
/// which is more than a texture has room for.
const LEVELS: u32 = 24;
const _: () = assert!(MAX_DEPTH + 23 < LEVELS_OF_A_NODE * LEVELS);
/// Where the tallest child is opened first, children are so much less tall than their parent: at most 1 + 2 + 4 nodes are
/// to be opened for that.
const LEVELS_OF_A_NODE: u32 = 3;

/// Units of a node's grid that its box spans at most. One is left at the lower side, the rest at the upper side is for
/// rounding.
const UNITS: f32 = 252.0;
/// Boxes grow by this part of a unit before they are rounded: more than what arithmetic in floats is off by from where a
/// node is worth telling from its neighbours, 2⁻²⁴ of the distance.
const MARGIN: f64 = 1.0 / 32.0;
/// A unit is this part of the coordinates or more, so that its grid can be placed.
const FINEST: f32 = 1.0 / (1 << 20) as f32;
/// Exponents of a unit; with slopes of up to 10²⁰, as `inverse_direction` of `lib/rays.wgsl` leaves them, no product overflows.
const EXPONENTS: std::ops::RangeInclusive<i32> = -100..=53;
/// What is added to an exponent to make a byte of it.
const BIAS: i32 = 128;
/// Coordinates below this are such that no product overflows, and no unit is too large.
const FARTHEST: f32 = (1_u64 << 59) as f32;

/// Bits of a leaf's word below the number of its triangles less one: how far its first one is behind that of the node.
const OFFSET_BITS: u32 = 14;

/// In a slot of a node: nothing.
const EMPTY: u32 = u32::MAX;

/// Whether boxes within these bounds can be encoded.
pub(super) fn can_hold(bounds: &Aabb) -> bool {
    bounds.is_empty() || bounds.min.abs().max(bounds.max.abs()).max_element() < FARTHEST
}

/// A node of a wide hierarchy.
#[derive(Clone, Copy, Debug)]
pub(super) struct WideNode {
    /// The node of the binary hierarchy whose box it has. If that is a leaf, it is its only child.
    pub(super) source: u32,
    /// Nodes of the binary hierarchy, or [`EMPTY`].
    slots: [u32; WIDTH],
    /// The slots whose children are nodes of their own, a bit each. These lie side by side, in the order of the slots.
    inner: u8,
    /// The first of them.
    first_child: u32,
}

/// A binary hierarchy made wide. Its root is the first node.
#[derive(Debug, Default)]
pub(super) struct WideTree {
    pub(super) nodes: Vec<WideNode>,
}

/// What becomes of leaves.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Leaves {
    /// Triangles of the nodes above them.
    Triangles,
    /// Nodes of their own, to be put in their places.
    Nodes,
}

/// Most nodes that a hierarchy over so many things becomes: one for each node but its leaves, and for leaves that lie too
/// far from the others of their node.
pub(super) fn most_nodes(things: usize) -> usize {
    2 * things.max(1)
}

impl WideNode {
    fn new(source: u32) -> Self {
        Self { source, slots: [EMPTY; WIDTH], inner: 0, first_child: 0 }
    }

    /// Slots and the nodes of the binary hierarchy that are in them.
    fn children(&self) -> impl Iterator<Item = (usize, u32)> + '_ {
        self.slots.iter().copied().enumerate().filter(|(_, child)| *child != EMPTY)
    }

    fn is_inner(&self, slot: usize) -> bool {
        self.inner >> slot & 1 != 0
    }

    /// The first triangle of the leaves in its slots.
    fn first_triangle(&self, bvh: &Bvh) -> u32 {
        let leaves = self.children().map(|(_, child)| &bvh.nodes[child as usize]).filter(|child| child.count > 0);
        leaves.map(|leaf| leaf.first).min().unwrap_or(0)
    }

    /// The node in the layout of `lib/wide_nodes.wgsl`, for nodes and triangles that lie from these places on.
    pub(super) fn encode(&self, bvh: &Bvh, nodes: u32, triangles: u32) -> [Texel; TEXELS] {
        let grid = Grid::new(&bvh.nodes[self.source as usize].bounds());
        let first_triangle = self.first_triangle(bvh);
        let (mut words, mut corners, mut leaves) = ([0_u16; WIDTH], [[0_u8; WIDTH]; 6], 0);
        for (slot, child) in self.children() {
            let child = &bvh.nodes[child as usize];
            let bytes = grid.corners(&child.bounds());
            (0..6).for_each(|plane| corners[plane][slot] = bytes[plane]);
            if !self.is_inner(slot) {
                leaves |= 1 << slot;
                words[slot] = ((child.first - first_triangle) | ((child.count - 1) << OFFSET_BITS)) as u16;
            }
        }
        let mut texels = [[0; 4]; TEXELS];
        let [x, y, z] = grid.origin.to_array().map(f32::to_bits);
        let [ex, ey, ez] = grid.exponents.map(|exponent| (exponent + BIAS) as u32);
        texels[0] = [x, y, z, ex | ey << 8 | ez << 16];
        texels[1] = [nodes.wrapping_add(self.first_child), triangles + first_triangle, u32::from(self.inner), leaves];
        texels[2] = std::array::from_fn(|i| u32::from(words[2 * i]) | u32::from(words[2 * i + 1]) << 16);
        let word =
            |plane: usize, half: usize| u32::from_le_bytes(std::array::from_fn(|i| corners[plane][4 * half + i]));
        // Lower and upper planes of four children at a time.
        for half in 0..2 {
            texels[3 + half] = [word(0, half), word(1, half), word(2, half), word(3, half)];
            texels[5][2 * half..][..2].copy_from_slice(&[word(4, half), word(5, half)]);
        }
        texels
    }
}

/// Whole numbers of a power of two of metres, from a point on.
struct Grid {
    origin: Vec3,
    exponents: [i32; 3],
}

impl Grid {
    fn new(bounds: &Aabb) -> Self {
        let finest = FINEST * bounds.min.abs().max(bounds.max.abs()).max_element();
        let exponents = bounds.size().to_array().map(|size| exponent_above((size / UNITS).max(finest)));
        let unit = Vec3::from(exponents.map(power_of_two));
        Self { origin: bounds.min - unit, exponents }
    }

    /// Lower corner in units, rounded down, and upper one, rounded up.
    fn corners(&self, bounds: &Aabb) -> [u8; 6] {
        let units = |corner: Vec3, axis: usize| {
            (f64::from(corner[axis]) - f64::from(self.origin[axis])) / f64::from(power_of_two(self.exponents[axis]))
        };
        std::array::from_fn(|plane| match plane {
            0..3 => (units(bounds.min, plane) - MARGIN).floor() as u8,
            _ => (units(bounds.max, plane - 3) + MARGIN).ceil() as u8,
        })
    }
}

/// The least exponent whose power of two is above a number, of those that there are.
fn exponent_above(value: f32) -> i32 {
    let exponent = (value.to_bits() >> 23) as i32 - 127 + 1;
    exponent.clamp(*EXPONENTS.start(), *EXPONENTS.end())
}

fn power_of_two(exponent: i32) -> f32 {
    f32::from_bits(((exponent + 127) as u32) << 23)
}

/// Up to eight nodes below one.
#[derive(Default)]
struct Children {
    nodes: [u32; WIDTH],
    count: usize,
}

impl Children {
    fn nodes(&self) -> &[u32] {
        &self.nodes[..self.count]
    }

    fn push(&mut self, node: u32) {
        self.nodes[self.count] = node;
        self.count += 1;
    }
}

/// Opens what has the highest priority until nothing can be opened.
fn children_of(bvh: &Bvh, node: u32, priority: impl Fn(u32) -> f32) -> Children {
    let mut children = Children::default();
    children.push(node);
    while children.count < WIDTH {
        let is_open = |at: &usize| bvh.nodes[children.nodes[*at] as usize].count == 0;
        let by_priority = |a: &usize, b: &usize| priority(children.nodes[*a]).total_cmp(&priority(children.nodes[*b]));
        let Some(opened) = (0..children.count).filter(is_open).max_by(by_priority) else { break };
        let first = bvh.nodes[children.nodes[opened] as usize].first;
        children.nodes[opened] = first;
        children.push(first + 1);
    }
    children
}

/// Of each node how many nodes there are to its farthest leaf, both included.
fn heights(bvh: &Bvh) -> Vec<u8> {
    let mut heights = vec![1_u8; bvh.nodes.len()];
    // Children come after their parents.
    for (index, node) in bvh.nodes.iter().enumerate().rev().filter(|(_, node)| node.count == 0) {
        let first = node.first as usize;
        heights[index] = heights[first].max(heights[first + 1]).saturating_add(1);
    }
    heights
}

fn surface(node: &Node) -> f32 {
    let size = node.bounds().size();
    size.x * size.y + size.y * size.z + size.z * size.x
}

/// Gives each child the free slot that suits it best, those first that lie farthest out.
fn slots_of(bvh: &Bvh, bounds: &Aabb, children: &[u32]) -> [u32; WIDTH] {
    let middle = bounds.min + bounds.max;
    let offset = |child: &u32| {
        let bounds = bvh.nodes[*child as usize].bounds();
        bounds.min + bounds.max - middle
    };
    let offsets: [Vec3; WIDTH] = std::array::from_fn(|i| children.get(i).map_or(Vec3::ZERO, offset));
    let mut slots = [EMPTY; WIDTH];
    let mut left = (1_u32 << children.len()) - 1;
    while left != 0 {
        let free = (0..WIDTH).filter(|slot| slots[*slot] == EMPTY);
        let mut best = (f32::NEG_INFINITY, left.trailing_zeros() as usize, free.clone().next().unwrap_or(0));
        for child in (0..children.len()).filter(|child| left >> child & 1 != 0) {
            for slot in free.clone() {
                let side =
                    |axis: usize| if slot >> axis & 1 != 0 { offsets[child][axis] } else { -offsets[child][axis] };
                let score = side(0) + side(1) + side(2);
                if score > best.0 {
                    best = (score, child, slot);
                }
            }
        }
        let (_, child, slot) = best;
        slots[slot] = children[child];
        left &= !(1 << child);
    }
    slots
}

impl WideTree {
    /// A node is opened into its children, of these the one of the largest surface into its own, until there are eight.
    pub(super) fn new(bvh: &Bvh, leaves: Leaves) -> Self {
        let mut tree = Self { nodes: Vec::with_capacity(bvh.nodes.len() / 3 + 1) };
        if bvh.nodes.is_empty() {
            return tree;
        }
        let heights = heights(bvh);
        tree.nodes.push(WideNode::new(0));
        let mut open = vec![(0, LEVELS)];
        while let Some((index, levels)) = open.pop() {
            let source = tree.nodes[index].source;
            let is_tall = u32::from(heights[source as usize]) + 2 > LEVELS_OF_A_NODE * levels;
            let priority = |node: u32| match is_tall {
                true => f32::from(heights[node as usize]),
                false => surface(&bvh.nodes[node as usize]),
            };
            let children = children_of(bvh, source, priority);
            let first_child = tree.nodes.len() as u32;
            let node = &mut tree.nodes[index];
            node.first_child = first_child;
            node.slots = slots_of(bvh, &bvh.nodes[source as usize].bounds(), children.nodes());
            let first_triangle = node.first_triangle(bvh);
            let is_inner = |child: &Node, at: u32| {
                child.count == 0
                    || (at != source && (leaves == Leaves::Nodes || child.first - first_triangle >= 1 << OFFSET_BITS))
            };
            let mut inner = Vec::with_capacity(WIDTH);
            for slot in (0..WIDTH).filter(|slot| node.slots[*slot] != EMPTY) {
                let child = node.slots[slot];
                if is_inner(&bvh.nodes[child as usize], child) {
                    node.inner |= 1 << slot;
                    inner.push(child);
                }
            }
            open.extend((first_child as usize..).zip(&inner).map(|(place, _)| (place, levels.saturating_sub(1))));
            tree.nodes.extend(inner.into_iter().map(WideNode::new));
        }
        tree
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use proptest::prelude::*;

    /// A box as a node has it, in numbers that do not round.
    pub(in super::super) type Corners = [[f64; 3]; 2];

    /// The children of a node in the order of an octant, as `lib/wide_nodes.wgsl` reads it: node or first triangle and
    /// number of triangles, and the box.
    fn children(node: &[Texel], octant: usize) -> Vec<(u32, u32, Corners)> {
        let byte = |word: u32, i: usize| f64::from(word >> (8 * i) & 0xff);
        let [inner, leaves] = [node[1][2], node[1][3]];
        let mut found = Vec::new();
        for slot in (0..8).map(|turn| turn ^ octant).filter(|slot| (inner | leaves) >> slot & 1 != 0) {
            let (half, i) = (slot / 4, slot % 4);
            let planes = node[3 + half].iter().chain(&node[5][2 * half..2 * half + 2]);
            let planes: Vec<f64> = planes.map(|word| byte(*word, i)).collect();
            let place = |axis: usize, units: f64| {
                let unit = f64::from(node[0][3] >> (8 * axis) & 0xff) - f64::from(BIAS);
                f64::from(f32::from_bits(node[0][axis])) + units * unit.exp2()
            };
            let corners = [0, 3].map(|first| std::array::from_fn(|axis| place(axis, planes[first + axis])));
            let word = node[2][slot / 2] >> (16 * (slot % 2)) & 0xffff;
            found.push(match inner >> slot & 1 {
                0 => (node[1][1] + (word & ((1 << OFFSET_BITS) - 1)), (word >> OFFSET_BITS) + 1, corners),
                _ => (node[1][0] + (inner & ((1 << slot) - 1)).count_ones(), 0, corners),
            });
        }
        found
    }

    /// Triangles that a ray comes by as `go_on` of `lib/walk.wgsl` goes, with the most groups that wait.
    pub(in super::super) fn walk(
        nodes: &[Texel],
        octant: usize,
        mut meets: impl FnMut(&Corners) -> bool,
    ) -> (Vec<u32>, usize) {
        let (mut triangles, mut most, mut steps) = (Vec::new(), 0, 0);
        let mut groups = vec![vec![0]];
        while let Some(group) = groups.last_mut() {
            let node = group.remove(0) as usize;
            if group.is_empty() {
                groups.pop();
            }
            most = most.max(groups.len());
            let met = children(&nodes[node * TEXELS..][..TEXELS], octant).into_iter().filter(|child| meets(&child.2));
            let (leaves, inner): (Vec<_>, Vec<_>) = met.partition(|child| child.1 > 0);
            triangles.extend(leaves.iter().flat_map(|leaf| leaf.0..leaf.0 + leaf.1));
            if !inner.is_empty() {
                groups.push(inner.iter().map(|child| child.0).collect());
            }
            steps += 1;
            assert!(steps < 1_000_000, "the nodes lead in a circle");
        }
        (triangles, most)
    }

    fn encoded(bvh: &Bvh, triangles: u32) -> Vec<Texel> {
        let tree = WideTree::new(bvh, Leaves::Triangles);
        tree.nodes.iter().flat_map(|node| node.encode(bvh, 0, triangles)).collect()
    }

    fn boxes(count: usize, extent: f32) -> impl Strategy<Value = Vec<Aabb>> {
        let corner = move || (-extent..extent, -extent..extent, -extent..extent).prop_map(Vec3::from);
        let size = (0.0..1.0_f32, 0.0..1.0_f32, 0.0..1.0_f32).prop_map(Vec3::from);
        let bounds = (corner(), size).prop_map(|(min, size)| Aabb { min, max: min + size });
        proptest::collection::vec(bounds, 1..count)
    }

    proptest! {
        #[test]
        fn rays_come_by_every_triangle_once(boxes in boxes(200, 20.0), octant in 0..8_usize, first in 0..1000_u32) {
            let nodes = encoded(&Bvh::new(&boxes, 2), first);
            let (mut triangles, _) = walk(&nodes, octant, |_| true);
            triangles.sort_unstable();
            prop_assert_eq!(triangles, (first..first + boxes.len() as u32).collect::<Vec<_>>());
            prop_assert!(walk(&nodes, octant, |_| false).0.is_empty());
        }

        #[test]
        fn boxes_hold_what_they_are_around(
            boxes in boxes(40, 1e3),
            away in prop_oneof![Just(0.0), -1e7..1e7_f32, Just(1e17)],
            scale in prop_oneof![Just(1.0), Just(1e-20), Just(1e-6), Just(1e12), Just(1e14)],
        ) {
            let placed = |bounds: &Aabb| Aabb { min: bounds.min * scale + away, max: bounds.max * scale + away };
            let boxes: Vec<Aabb> = boxes.iter().map(placed).collect();
            let whole = boxes.iter().fold(Aabb::EMPTY, |sum, bounds| sum.union(bounds));
            prop_assert!(can_hold(&whole));
            let bvh = Bvh::new(&boxes, 2);
            let nodes = encoded(&bvh, 0);
            // A point in a box is in all boxes on the way to it.
            for (place, index) in bvh.order.iter().enumerate() {
                let point = boxes[*index as usize].center();
                let holds = |corners: &Corners| {
                    (0..3).all(|axis| (corners[0][axis]..=corners[1][axis]).contains(&f64::from(point[axis])))
                };
                prop_assert!(walk(&nodes, 0, holds).0.contains(&(place as u32)));
            }
            // They are not much larger than they must be: those of the root span what is there and a few units.
            let corners = children(&nodes[..TEXELS], 0).into_iter().map(|child| child.2);
            let finest = f64::from(FINEST * whole.min.abs().max(whole.max.abs()).max_element());
            for [low, high] in corners {
                for axis in 0..3 {
                    let unit = f64::from(whole.size()[axis] / 126.0).max(2.0 * finest).max(2e-30);
                    prop_assert!(f64::from(whole.min[axis]) - low[axis] <= 2.0 * unit);
                    prop_assert!(high[axis] - f64::from(whole.max[axis]) <= 2.0 * unit);
                }
            }
        }

        #[test]
        fn no_hierarchy_is_too_tall(turns in prop::collection::vec(any::<u16>(), 60..400), tall in any::<bool>()) {
            let bvh = grown(&turns, tall);
            let nodes = encoded(&bvh, 0);
            for octant in 0..8 {
                let (triangles, most) = walk(&nodes, octant, |_| true);
                prop_assert_eq!(triangles.len(), bvh.order.len());
                prop_assert!(most < LEVELS as usize, "{} groups wait", most);
            }
        }
    }

    /// A hierarchy that no builder makes: each turn opens a leaf, the newest or any, as long as it is no taller than allowed.
    fn grown(turns: &[u16], tall: bool) -> Bvh {
        let mut nodes = vec![Node { min: [0.0; 3], max: [1.0; 3], first: 0, count: 1 }];
        let mut leaves = vec![(0, 1)];
        for turn in turns {
            let at = if tall && turn % 8 != 0 { leaves.len() - 1 } else { *turn as usize % leaves.len() };
            let (leaf, depth): (usize, u32) = leaves[at];
            if depth == LEVELS_OF_A_NODE * LEVELS {
                continue;
            }
            leaves.remove(at);
            let first = nodes.len();
            // Boxes whose sizes say nothing about what is in them.
            let child = |side: u32| Node { max: [f32::from(turn >> (side * 8) & 0xff) / 256.0; 3], ..nodes[leaf] };
            let children = [child(0), child(1)];
            nodes[leaf] = Node { first: first as u32, count: 0, ..nodes[leaf] };
            nodes.extend(children);
            leaves.extend([(first, depth + 1), (first + 1, depth + 1)]);
        }
        let mut count = 0;
        for node in nodes.iter_mut().filter(|node| node.count > 0) {
            (node.first, count) = (count, count + 1);
        }
        Bvh { nodes, order: (0..count).collect() }
    }

    #[test]
    fn near_children_come_first() {
        let corner = |i: u32| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32) * 3.0;
        let boxes: Vec<Aabb> = (0..8).map(|i| Aabb { min: corner(i), max: corner(i) + 1.0 }).collect();
        let bvh = Bvh::new(&boxes, 1);
        let nodes = encoded(&bvh, 0);
        assert_eq!(nodes.len(), TEXELS, "all in one node");
        for octant in 0..8 {
            let (triangles, _) = walk(&nodes, octant, |_| true);
            let met: Vec<u32> = triangles.iter().map(|triangle| bvh.order[*triangle as usize]).collect();
            assert_eq!(met, (0..8).map(|turn| turn ^ octant as u32).collect::<Vec<_>>());
        }
    }

    #[test]
    fn leaves_that_lie_far_from_each_other_are_reached() {
        let leaf = |first: u32, x: f32| Node { min: [x; 3], max: [x + 1.0; 3], first, count: 2 };
        let root = Node { min: [0.0; 3], max: [9.0; 3], first: 1, count: 0 };
        let bvh = Bvh { nodes: vec![root, leaf(30_000, 0.0), leaf(7, 8.0)], order: (0..30_002).collect() };
        assert_eq!(walk(&encoded(&bvh, 100), 0, |_| true).0, [107, 108, 30_100, 30_101]);
    }

    #[test]
    fn coordinates_have_a_limit() {
        let at = |x: f32| Aabb { min: Vec3::splat(-x), max: Vec3::splat(x) };
        assert!(can_hold(&at(1e17)) && can_hold(&Aabb::EMPTY) && !can_hold(&at(1e18)));
    }
}
