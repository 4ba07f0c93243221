//! A hierarchy as lists of boxes, one for the signs of each octant of directions: each begins with what rays meet first.

use super::boxes::{COUNT_BITS, Encoding, LEAF};
use super::words::Texel;
use crate::bvh::{Bvh, Node};

/// For each axis the octants whose directions are not negative on it.
const POSITIVE: [u8; 3] = [0b0101_0101, 0b0011_0011, 0b0000_1111];

/// The order in which rays meet the nodes of a hierarchy.
pub(super) struct Order<'a> {
    bvh: &'a Bvh,
    /// Nodes below each node, itself included.
    sizes: Vec<u32>,
    /// The octants in which the left child of each node comes first, a bit each.
    left_first: Vec<u8>,
}

impl<'a> Order<'a> {
    pub(super) fn new(bvh: &'a Bvh) -> Self {
        let mut sizes = vec![1; bvh.nodes.len()];
        let mut left_first = vec![0; bvh.nodes.len()];
        // Children come after their parents.
        for (index, node) in bvh.nodes.iter().enumerate().rev().filter(|(_, node)| node.count == 0) {
            let left = node.first as usize;
            sizes[index] += sizes[left] + sizes[left + 1];
            left_first[index] = left_first_in(&bvh.nodes[left], &bvh.nodes[left + 1]);
        }
        Self { bvh, sizes, left_first }
    }

    /// The same with the first child of the root in front, in every octant.
    fn with_first_child_in_front(mut self) -> Self {
        self.left_first.first_mut().into_iter().for_each(|root| *root = u8::MAX);
        self
    }

    /// Indices of all nodes, each with the place in the list of the next node that does not lie below it. Bit i of the
    /// octant: the direction is negative on axis i.
    pub(super) fn nodes(&self, octant: u32) -> impl Iterator<Item = (usize, u32)> + '_ {
        let mut open = Vec::from_iter(self.bvh.nodes.first().map(|_| 0));
        let mut place = 0;
        std::iter::from_fn(move || {
            let index = open.pop()?;
            let node = &self.bvh.nodes[index];
            if node.count == 0 {
                let left = node.first as usize;
                let is_left_first = self.left_first[index] >> octant & 1 != 0;
                open.extend(if is_left_first { [left + 1, left] } else { [left, left + 1] });
            }
            let skip = place + self.sizes[index];
            place += 1;
            Some((index, skip))
        })
    }
}

/// Judged along the axis on which the children lie farthest apart.
fn left_first_in(left: &Node, right: &Node) -> u8 {
    let apart = (right.bounds().min + right.bounds().max) - (left.bounds().min + left.bounds().max);
    let axis = apart.abs().max_position();
    if apart[axis] >= 0.0 { POSITIVE[axis] } else { !POSITIVE[axis] }
}

/// What a list leads to.
#[derive(Clone, Copy)]
pub(super) struct Links {
    /// Its first box.
    pub(super) first: u32,
    /// The box that rays go on at which leave it.
    pub(super) behind: u32,
    /// The first triangle of its leaves.
    pub(super) triangle: u32,
}

/// A hierarchy with all that its lists have in common.
pub(super) struct BoxList<'a> {
    bvh: &'a Bvh,
    order: Order<'a>,
    /// The boxes of all nodes, without links.
    boxes: Vec<Texel>,
}

impl<'a> BoxList<'a> {
    pub(super) fn new(bvh: &'a Bvh, encoding: Encoding) -> Self {
        let mut boxes = Vec::with_capacity(2 * bvh.nodes.len());
        bvh.nodes.iter().for_each(|node| encoding.push(&mut boxes, &node.bounds(), 0));
        Self { bvh, order: Order::new(bvh), boxes }
    }

    /// The same with the first child of the root in front, in every list.
    pub(super) fn with_first_child_in_front(self) -> Self {
        Self { order: self.order.with_first_child_in_front(), ..self }
    }

    /// Adds the list of an octant.
    pub(super) fn push(&self, texels: &mut Vec<Texel>, octant: u32, links: Links) {
        let in_box = self.boxes.len() / self.bvh.nodes.len().max(1);
        let end = self.bvh.nodes.len() as u32;
        for (index, skip) in self.order.nodes(octant) {
            let node = &self.bvh.nodes[index];
            let leaf = LEAF | (node.count.wrapping_sub(1)) << COUNT_BITS | (links.triangle + node.first);
            let behind = if skip == end { links.behind } else { links.first + skip };
            let boxes = &self.boxes[index * in_box..][..in_box];
            let [x, y, z, _] = boxes[0];
            texels.push([x, y, z, if node.count > 0 { leaf } else { behind }]);
            texels.extend_from_slice(&boxes[1..]);
        }
    }
}
