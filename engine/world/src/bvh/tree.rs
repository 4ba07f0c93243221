//! Hierarchies as they are: their nodes, the traversal by rays, and fitting to what has moved.

use crate::core::{Aabb, Ray};
use bytemuck::{Pod, Zeroable};
use glam::Vec3;

/// Most nodes between a root and a leaf, of which one may join two hierarchies. Below it the builder halves by count, which ends after log₂ n levels more;
/// traversal stacks are sized by it.
pub const MAX_DEPTH: u32 = 48;

/// A node. The two children of an inner node lie side by side.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Node {
    /// Lower corner of the box.
    pub min: [f32; 3],
    /// Inner node: index of the first child. Leaf: first entry in [`Bvh::order`].
    pub first: u32,
    /// Upper corner of the box.
    pub max: [f32; 3],
    /// Number of entries of a leaf; 0 for inner nodes.
    pub count: u32,
}

impl Node {
    /// The box.
    pub fn bounds(&self) -> Aabb {
        Aabb { min: self.min.into(), max: self.max.into() }
    }

    pub(super) fn set_bounds(&mut self, bounds: &Aabb) {
        (self.min, self.max) = (bounds.min.to_array(), bounds.max.to_array());
    }

    /// Where the ray enters the box, if it does so before `t_max`.
    pub fn entry(&self, ray: &Ray, t_max: f32) -> Option<f32> {
        ray.enters(&self.bounds(), t_max)
    }
}

/// A hierarchy over boxes that are known by their index.
#[derive(Clone, Debug, Default)]
pub struct Bvh {
    /// Nodes; the first is the root. Empty if there are no boxes.
    pub nodes: Vec<Node>,
    /// Indices of the boxes in the order of the leaves. In the static part of a scene a triangle may be in several leaves.
    pub order: Vec<u32>,
}

impl Bvh {
    /// A hierarchy whose root has two others as its children; neither may be empty.
    #[doc(hidden)]
    pub fn joined(left: Self, right: Self) -> Self {
        let (nodes_of_left, entries_of_left) = (left.nodes.len() as u32, left.order.len() as u32);
        let moved = |node: &Node, [nodes, entries]: [u32; 2]| Node {
            first: node.first + if node.count > 0 { entries } else { nodes },
            ..*node
        };
        let [of_left, of_right] = [[2, 0], [nodes_of_left + 1, entries_of_left]];
        let mut root = Node { first: 1, count: 0, ..Node::default() };
        root.set_bounds(&left.nodes[0].bounds().union(&right.nodes[0].bounds()));
        let mut nodes = vec![root, moved(&left.nodes[0], of_left), moved(&right.nodes[0], of_right)];
        nodes.extend(left.nodes[1..].iter().map(|node| moved(node, of_left)));
        nodes.extend(right.nodes[1..].iter().map(|node| moved(node, of_right)));
        Self { nodes, order: [left.order, right.order].concat() }
    }

    /// Fits the boxes of all nodes to moved contents without changing the tree. `boxes` must be as many as at the
    /// building.
    ///
    /// The tree stays correct whatever moved, but slows down where neighbours have parted: see [`Bvh::cost`].
    pub fn refit(&mut self, boxes: &[Aabb]) {
        self.refit_by(|index| boxes[index as usize]);
    }

    /// The same with a function that gives the box of an index.
    pub fn refit_by(&mut self, bounds_of: impl Fn(u32) -> Aabb) {
        for index in (0..self.nodes.len()).rev() {
            let node = self.nodes[index];
            let bounds = if node.count > 0 {
                let entries = &self.order[node.first as usize..][..node.count as usize];
                entries.iter().fold(Aabb::EMPTY, |sum, &entry| sum.union(&bounds_of(entry)))
            } else {
                // Children come after their parents, and are fitted already.
                self.nodes[node.first as usize].bounds().union(&self.nodes[node.first as usize + 1].bounds())
            };
            self.nodes[index].set_bounds(&bounds);
        }
    }

    /// Expected cost of a random ray that meets the root: boxes tested plus contents tested, each weighted by its
    /// chance to be met (MacDonald and Booth 1990).
    pub fn cost(&self) -> f32 {
        let Some(root) = self.nodes.first() else { return 0.0 };
        let whole = half_area(&root.bounds()).max(f32::MIN_POSITIVE);
        let part =
            |node: &Node| half_area(&node.bounds()) / whole * if node.count > 0 { node.count as f32 } else { 2.0 };
        self.nodes.iter().map(part).sum()
    }

    /// Nodes on the longest way from the root to a leaf.
    pub fn depth(&self) -> u32 {
        let mut deepest = 0;
        let mut open = Vec::from([(0, 1)]);
        while let Some((index, depth)) = open.pop() {
            let Some(node) = self.nodes.get(index as usize) else { continue };
            deepest = deepest.max(depth);
            if node.count == 0 {
                open.extend([(node.first, depth + 1), (node.first + 1, depth + 1)]);
            }
        }
        deepest
    }

    /// Visits the contents of every leaf that the ray meets before `t_max`, near ones first. `visit` gets an index of
    /// a box and the bound so far, and returns the bound from there on.
    pub fn traverse(&self, ray: &Ray, mut t_max: f32, mut visit: impl FnMut(u32, f32) -> f32) {
        let Some(root) = self.nodes.first().filter(|root| root.entry(ray, t_max).is_some()) else { return };
        let mut stack = [(0_u32, 0.0_f32); MAX_DEPTH as usize + 32];
        let mut top = 0;
        let mut node = root;
        loop {
            if node.count > 0 {
                for &entry in &self.order[node.first as usize..][..node.count as usize] {
                    t_max = visit(entry, t_max);
                }
            } else {
                let near = &self.nodes[node.first as usize];
                let far = &self.nodes[node.first as usize + 1];
                match (near.entry(ray, t_max), far.entry(ray, t_max)) {
                    (Some(a), Some(b)) => {
                        let (first, second, later) =
                            if a <= b { (near, node.first + 1, b) } else { (far, node.first, a) };
                        stack[top] = (second, later);
                        top += 1;
                        node = first;
                        continue;
                    }
                    (Some(_), None) => {
                        node = near;
                        continue;
                    }
                    (None, Some(_)) => {
                        node = far;
                        continue;
                    }
                    (None, None) => {}
                }
            }
            loop {
                if top == 0 {
                    return;
                }
                top -= 1;
                let (next, entry) = stack[top];
                if entry <= t_max {
                    node = &self.nodes[next as usize];
                    break;
                }
            }
        }
    }
}

impl Bvh {
    /// Visits the contents of every leaf whose box meets the bounds; contents themselves may lie apart from them.
    pub fn overlapping(&self, bounds: &Aabb, mut visit: impl FnMut(u32)) {
        let meets = |node: &Node| !node.bounds().intersection(bounds).is_empty();
        let mut open: Vec<u32> = if self.nodes.is_empty() { Vec::new() } else { vec![0] };
        while let Some(index) = open.pop() {
            let node = &self.nodes[index as usize];
            if !meets(node) {
                continue;
            }
            match node.count {
                0 => open.extend([node.first + 1, node.first]),
                count => self.order[node.first as usize..][..count as usize].iter().for_each(|entry| visit(*entry)),
            }
        }
    }
}

/// Half the surface of a box; zero for an empty one.
pub(super) fn half_area(bounds: &Aabb) -> f32 {
    let s: Vec3 = bounds.size();
    s.x * s.y + s.y * s.z + s.z * s.x
}
