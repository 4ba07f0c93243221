//! The hierarchy's boxes as lists that rays follow without a stack, in the layout of `lib/rays.wgsl`.

use super::words::Texel;
use crate::bvh::{Bvh, Node};
use crate::scene::Aabb;
use glam::Vec3;

/// Marks the link of a leaf.
const LEAF: u32 = 1 << 31;
/// Bits of a leaf's link below the number of triangles less one.
const COUNT_BITS: u32 = 29;
/// Units of the frame that the contents span. Two at either side are left for rounding.
const UNITS: f32 = 65531.0;
/// Boxes grow by this part of a unit on each side before they are rounded: more than what arithmetic in floats can be
/// off by within the frame, 2⁻²⁴ of 2¹⁶ units for each of three operations.
const MARGIN: f32 = 1.0 / 32.0;
/// A leaf that rounding makes so many times as long is coarse.
const COARSE: f32 = 1.5;

/// A list of boxes for each of the eight signs of a direction.
pub(super) struct BoxLists {
    /// All lists, after the frame.
    pub(super) texels: Vec<Texel>,
    /// Boxes of one list.
    pub(super) box_count: u32,
    /// Whether boxes are kept in floats, two texels each: for scenes in which most things are smaller than a unit of
    /// the frame, such as a room on a plain of 100 km.
    pub(super) exact: bool,
}

impl BoxLists {
    /// The lists of a hierarchy.
    pub(super) fn new(bvh: &Bvh) -> Self {
        let Some(root) = bvh.nodes.first() else { return Self { texels: Vec::new(), box_count: 0, exact: false } };
        let frame = Frame::new(&root.bounds());
        let exact = is_coarse(bvh, &frame);
        let sizes = subtree_sizes(bvh);
        let mut texels = if exact { Vec::new() } else { frame.texels(bvh.nodes.len()).to_vec() };
        let mut first = texels.len() as u32;
        for octant in 0..8 {
            for (node, skip) in order(bvh, &sizes, octant) {
                let link =
                    if node.count > 0 { LEAF | (node.count - 1) << COUNT_BITS | node.first } else { first + skip };
                if exact {
                    texels.extend(exact_texels(&node, link));
                } else {
                    texels.push(frame.texel(&node.bounds(), link));
                }
            }
            first += bvh.nodes.len() as u32;
        }
        // Rays look at two boxes at once: after the last one of the last list comes one that leads nowhere.
        let nowhere = LEAF - 1;
        texels.extend([[0, 0, 0, nowhere]; 2]);
        Self { texels, box_count: bvh.nodes.len() as u32, exact }
    }
}

/// All nodes in the order in which rays of these signs meet them, each with the place in the list of the next node that
/// does not lie below it.
fn order<'a>(bvh: &'a Bvh, sizes: &'a [u32], octant: u32) -> impl Iterator<Item = (Node, u32)> + 'a {
    let mut open = Vec::from([0]);
    let mut place = 0;
    std::iter::from_fn(move || {
        let index = open.pop()?;
        let node = bvh.nodes[index];
        if node.count == 0 {
            let left = node.first as usize;
            let left_first = is_left_first(&bvh.nodes[left], &bvh.nodes[left + 1], octant);
            open.extend(if left_first { [left + 1, left] } else { [left, left + 1] });
        }
        let skip = place + sizes[index];
        place += 1;
        Some((node, skip))
    })
}

/// Judged along the axis on which the children lie farthest apart. Bit i of the octant: the direction is negative on
/// axis i.
fn is_left_first(left: &Node, right: &Node, octant: u32) -> bool {
    let apart = (right.bounds().min + right.bounds().max) - (left.bounds().min + left.bounds().max);
    let axis = apart.abs().max_position();
    (apart[axis] >= 0.0) == (octant >> axis & 1 == 0)
}

/// Nodes of the tree below each node, itself included. Children come after their parents.
fn subtree_sizes(bvh: &Bvh) -> Vec<u32> {
    let mut sizes = vec![1; bvh.nodes.len()];
    for (index, node) in bvh.nodes.iter().enumerate().rev() {
        if node.count == 0 {
            sizes[index] += sizes[node.first as usize] + sizes[node.first as usize + 1];
        }
    }
    sizes
}

fn exact_texels(node: &Node, link: u32) -> [Texel; 2] {
    let ([ax, ay, az], [bx, by, bz]) = (node.min.map(f32::to_bits), node.max.map(f32::to_bits));
    [[ax, ay, az, link], [bx, by, bz, 0]]
}

/// The grid of 2¹⁶ units an axis whose corners the boxes are rounded to.
struct Frame {
    origin: Vec3,
    unit: Vec3,
}

impl Frame {
    fn new(bounds: &Aabb) -> Self {
        // A flat scene has a thin frame, not none.
        let size = bounds.size();
        let least = (size.max_element() * 1e-6).max(1e-25);
        let unit = size.max(Vec3::splat(least)) / UNITS;
        Self { origin: bounds.min - 2.0 * unit, unit }
    }

    fn texels(&self, boxes: usize) -> [Texel; 2] {
        let words = |v: Vec3, word: u32| [v.x.to_bits(), v.y.to_bits(), v.z.to_bits(), word];
        [words(self.origin, boxes as u32), words(self.unit, 0)]
    }

    /// Corners in units, lower ones rounded down and upper ones up.
    fn corners(&self, bounds: &Aabb) -> [[u32; 3]; 2] {
        let low = ((bounds.min - self.origin) / self.unit - MARGIN).floor();
        let high = ((bounds.max - self.origin) / self.unit + MARGIN).ceil();
        [low, high].map(|corner| corner.to_array().map(|units| units as u16 as u32))
    }

    fn texel(&self, bounds: &Aabb, link: u32) -> Texel {
        let [[ax, ay, az], [bx, by, bz]] = self.corners(bounds);
        [ax | ay << 16, az | bx << 16, by | bz << 16, link]
    }

    /// The box that the texel stands for.
    fn rounded(&self, bounds: &Aabb) -> Aabb {
        let [min, max] =
            self.corners(bounds).map(|corner| self.origin + Vec3::from(corner.map(|c| c as f32)) * self.unit);
        Aabb { min, max }
    }
}

/// Whether a quarter of the leaves or more would be coarse. What rays cost there shows in no mean over the whole scene:
/// they may all stay in one room of it.
fn is_coarse(bvh: &Bvh, frame: &Frame) -> bool {
    let leaves = || bvh.nodes.iter().filter(|node| node.count > 0).map(Node::bounds);
    let longest = |bounds: &Aabb| bounds.size().max_element();
    let coarse = leaves().filter(|bounds| longest(&frame.rounded(bounds)) > COARSE * longest(bounds)).count();
    4 * coarse >= leaves().count()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn boxes(count: usize, extent: f32) -> impl Strategy<Value = Vec<Aabb>> {
        let corner = move || (-extent..extent, -extent..extent, -extent..extent).prop_map(Vec3::from);
        let size = (0.0..1.0_f32, 0.0..1.0_f32, 0.0..1.0_f32).prop_map(Vec3::from);
        let bounds = (corner(), size).prop_map(|(min, size)| Aabb { min, max: min + size });
        proptest::collection::vec(bounds, 1..count)
    }

    /// Leaves in the order of a list, as `go_on` of `lib/rays.wgsl` goes: into all boxes that `meets` says yes to, two
    /// boxes at once.
    fn walk(lists: &BoxLists, octant: u32, mut meets: impl FnMut(&Texel) -> bool) -> Vec<u32> {
        assert!(!lists.exact, "these boxes are rounded");
        let first = 2 + octant * lists.box_count;
        let end = first + lists.box_count;
        let mut next = first;
        let mut leaves = Vec::new();
        while next < end {
            let mut goes_on = true;
            for texel in &lists.texels[next as usize..][..2] {
                let (met, is_leaf) = (meets(texel), texel[3] >= LEAF);
                if goes_on && met && is_leaf {
                    leaves.push(texel[3]);
                }
                if goes_on {
                    goes_on = met || is_leaf;
                    next = if goes_on { next + 1 } else { texel[3] };
                }
            }
        }
        leaves
    }

    proptest! {
        #[test]
        fn every_list_has_every_leaf_once(boxes in boxes(60, 20.0), octant in 0..8_u32) {
            let bvh = Bvh::new(&boxes, 2);
            let lists = BoxLists::new(&bvh);
            let mut leaves = walk(&lists, octant, |_| true);
            leaves.sort_unstable();
            if bvh.nodes.len() == 1 {
                // The only leaf may be met again, as the box behind itself.
                leaves.dedup();
            }
            let link = |node: &Node| LEAF | (node.count - 1) << COUNT_BITS | node.first;
            let mut expected: Vec<u32> = bvh.nodes.iter().filter(|node| node.count > 0).map(link).collect();
            expected.sort_unstable();
            prop_assert_eq!(leaves, expected);
            // Whoever misses the root misses all.
            prop_assert!(walk(&lists, octant, |_| false).is_empty());
        }

        #[test]
        fn rounded_boxes_hold_what_they_round(boxes in boxes(20, 1e3)) {
            let frame = Frame::new(&boxes.iter().fold(Aabb::EMPTY, |sum, bounds| sum.union(bounds)));
            for bounds in &boxes {
                let rounded = frame.rounded(bounds);
                prop_assert!(rounded.min.cmple(bounds.min).all() && rounded.max.cmpge(bounds.max).all());
            }
        }
    }

    #[test]
    fn a_room_on_a_wide_plain_keeps_its_boxes() {
        let plain = Aabb { min: Vec3::new(-1e5, -1.0, -1e5), max: Vec3::new(1e5, 0.0, 1e5) };
        let things = (0..64).map(|i| {
            let min = Vec3::new((i % 8) as f32, 0.0, (i / 8) as f32) * 0.4;
            Aabb { min, max: min + 0.2 }
        });
        let wide: Vec<Aabb> = things.clone().chain([plain]).collect();
        assert!(BoxLists::new(&Bvh::new(&wide, 2)).exact);
        assert!(!BoxLists::new(&Bvh::new(&things.collect::<Vec<_>>(), 2)).exact);
        assert_eq!(BoxLists::new(&Bvh::default()).box_count, 0);
    }
}
