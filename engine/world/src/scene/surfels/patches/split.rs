//! Patches end at walls. Where one stands on a floor a cell may reach into two rooms, and their light must not mix.
//!
//! Surfels of a cell belong together if points a little before them see each other, at once or by way of others. Where they
//! do not, planes through what stands between them part the cell, as in a tree of binary space partitions (Fuchs, Kedem and
//! Naylor 1980). What of the cell has no surfel of its own, as a narrow strip behind a wall, has those of the cell beyond.

use super::cells::Cell;
use super::occluders::{Occluders, Point};
use glam::{Vec3, Vec4};
use std::ops::Range;

/// Parts of a cell that are told apart: what has more is no room.
const MOST_PARTS: usize = 8;

/// Most planes between the whole cell and a part, as `PATCH_DEPTH` of `lib/patches.wgsl`.
pub(super) const DEPTH: usize = 8;

/// The parts of a cell.
#[derive(Debug)]
pub(super) struct Split {
    /// Planes, in the grid of the object, and what is before and behind them. The first parts the whole cell.
    pub nodes: Vec<(Vec4, [Side; 2])>,
    pub parts: Vec<Part>,
}

/// One side of a plane.
#[derive(Clone, Copy, Debug)]
pub(super) enum Side {
    /// Index of another plane.
    Node(usize),
    /// Index of a part.
    Part(usize),
}

/// The patch or node of a part of a cell.
#[derive(Debug)]
pub(super) enum Part {
    /// Surfels of the cell.
    Own(Vec<u32>),
    /// A surfel of another cell, with its patch.
    Beyond(u32),
}

/// All cells of an object, in their order, and the surfels of each, which follow each other.
#[derive(Clone, Copy)]
pub(super) struct Sorted<'a> {
    pub cells: &'a [Cell],
    pub ranges: &'a [[u32; 2]],
    pub points: &'a [Point],
}

impl Sorted<'_> {
    fn surfels(&self, index: usize) -> Range<u32> {
        let [first, count] = self.ranges[index];
        first..first + count
    }

    fn point(&self, surfel: u32) -> &Point {
        &self.points[surfel as usize]
    }

    /// That one of some surfels that is nearest to a point of the grid.
    fn nearest(&self, surfels: impl Iterator<Item = u32>, to: Vec3) -> Option<u32> {
        let distance = |surfel: &u32| self.point(*surfel).surface.distance_squared(to);
        surfels.min_by(|a, b| distance(a).total_cmp(&distance(b)))
    }

    /// Cells without a surfel that have one on two sides which face each other, as where a wall hides all of a floor but
    /// two narrow strips.
    pub fn gaps(&self, index: usize) -> Vec<Cell> {
        let has = |cell: Cell| self.cells.binary_search(&cell).is_ok();
        let is_between = |cell: &Cell| {
            let around: Vec<Cell> = cell.around().collect();
            // The second half are the first one's opposites, from the last on.
            (0..13).any(|step| has(around[step]) && has(around[25 - step]))
        };
        self.cells[index].beside().filter(|cell| !has(*cell) && is_between(cell)).collect()
    }

    /// The parts of a cell without a surfel; none if it is whole.
    pub fn split_gap(&self, occluders: &Occluders, cell: Cell) -> Option<Split> {
        let mut groups = Groups { sorted: self, occluders, members: Vec::new(), planes: Vec::new() };
        let middle = Vec3::from_array(cell.at.map(|v| v as f32 + 0.5));
        for beside in cell.around() {
            let Ok(beside) = self.cells.binary_search(&beside) else { continue };
            let open = self.surfels(beside).filter(|surfel| !self.point(*surfel).is_hidden);
            let nearest = self.nearest(open, middle);
            nearest.into_iter().for_each(|surfel| groups.join(surfel));
        }
        groups.is_parted().then(|| Tree::new(&groups, 0..0).split)
    }

    /// The parts of a cell; none if it is whole.
    pub fn split(&self, occluders: &Occluders, index: usize) -> Option<Split> {
        let mut groups = Groups { sorted: self, occluders, members: Vec::new(), planes: Vec::new() };
        let own = self.surfels(index);
        own.clone().filter(|surfel| !self.point(*surfel).is_hidden).for_each(|surfel| groups.join(surfel));
        let middle = own.clone().map(|surfel| self.point(surfel).surface).sum::<Vec3>() / own.len() as f32;
        let cell = self.cells[index];
        for beside in cell.around() {
            let Ok(beside) = self.cells.binary_search(&beside) else { continue };
            let open = self.surfels(beside).filter(|surfel| !self.point(*surfel).is_hidden);
            let Some(other) = self.nearest(open, middle) else { continue };
            let Some(nearest) = self.nearest(own.clone(), self.point(other).surface) else { continue };
            let wall = occluders.between(self.point(nearest), self.point(other));
            if wall.is_some_and(|wall| occluders.reaches(&wall, self.point(nearest), cell)) {
                groups.join(other);
            }
        }
        groups.is_parted().then(|| Tree::new(&groups, own).split)
    }
}

/// Surfels, by which of them belong together.
struct Groups<'a> {
    sorted: &'a Sorted<'a>,
    occluders: &'a Occluders<'a>,
    /// Surfels, and the groups that they belong to.
    members: Vec<(u32, usize)>,
    /// Planes that separate groups.
    planes: Vec<Vec4>,
}

impl Groups<'_> {
    /// Adds a surfel to all groups that see it, which become one; else to one of its own.
    fn join(&mut self, surfel: u32) {
        let mut groups: Vec<usize> = self.members.iter().map(|(_, group)| *group).collect();
        groups.sort_unstable();
        groups.dedup();
        let point = self.sorted.point(surfel);
        let mut seen = None;
        for &group in &groups {
            let of_group = self.members.iter().filter(|(_, of)| *of == group).map(|(member, _)| *member);
            let Some(nearest) = self.sorted.nearest(of_group, point.surface) else { continue };
            match (self.occluders.between(self.sorted.point(nearest), point), seen) {
                (Some(wall), _) => self.planes.extend(self.occluders.planes(&wall)),
                (None, None) => seen = Some(group),
                (None, Some(first)) => {
                    self.members.iter_mut().filter(|(_, of)| *of == group).for_each(|(_, of)| *of = first);
                }
            }
        }
        let next = groups.last().map_or(0, |last| last + 1);
        let last = groups.last().copied().filter(|_| groups.len() >= MOST_PARTS);
        self.members.push((surfel, seen.or(last).unwrap_or(next)));
    }

    fn is_parted(&self) -> bool {
        self.members.windows(2).any(|pair| pair[0].1 != pair[1].1)
    }
}

/// A tree of planes, while it is built.
struct Tree<'a> {
    groups: &'a Groups<'a>,
    own: Range<u32>,
    split: Split,
}

impl<'a> Tree<'a> {
    fn new(groups: &'a Groups<'a>, own: Range<u32>) -> Self {
        let is_hidden = |surfel: &u32| groups.sorted.point(*surfel).is_hidden;
        let hidden = own.clone().filter(is_hidden).collect();
        let mut tree = Self { groups, own, split: Split { nodes: Vec::new(), parts: Vec::new() } };
        tree.branch(groups.members.clone(), hidden, DEPTH);
        tree
    }

    fn branch(&mut self, members: Vec<(u32, usize)>, hidden: Vec<u32>, depth: usize) -> Side {
        let plane = if depth > 0 { self.best_plane(&members) } else { None };
        let Some(plane) = plane else {
            self.split.parts.push(self.part(&members, hidden));
            return Side::Part(self.split.parts.len() - 1);
        };
        let index = self.split.nodes.len();
        self.split.nodes.push((plane, [Side::Part(0); 2]));
        let (before, behind) = members.into_iter().partition(|(surfel, _)| self.is_before(plane, *surfel));
        let (hidden_before, hidden_behind) = hidden.into_iter().partition(|surfel| self.is_before(plane, *surfel));
        self.split.nodes[index].1 =
            [self.branch(before, hidden_before, depth - 1), self.branch(behind, hidden_behind, depth - 1)];
        Side::Node(index)
    }

    /// Surfels in cracks separate nothing: each belongs to the part around it.
    fn part(&self, members: &[(u32, usize)], hidden: Vec<u32>) -> Part {
        let open = members.iter().map(|(surfel, _)| *surfel).filter(|s| self.own.contains(s));
        let own: Vec<u32> = open.chain(hidden).collect();
        if own.is_empty() { Part::Beyond(members[0].0) } else { Part::Own(own) }
    }

    fn is_before(&self, plane: Vec4, surfel: u32) -> bool {
        plane.dot(self.groups.sorted.point(surfel).surface.extend(1.0)) >= 0.0
    }

    /// The plane that parts most pairs of surfels that do not belong together, and fewest of those that do; none if all do.
    /// Where no wall's plane parts any, as with what is curved, one in the middle between two surfels does.
    fn best_plane(&self, members: &[(u32, usize)]) -> Option<Vec4> {
        let best = |planes: &[Vec4]| {
            let scores = planes.iter().filter_map(|plane| Some((self.score(*plane, members)?, *plane)));
            scores.reduce(|best, next| if next.0 > best.0 { next } else { best }).map(|(_, plane)| plane)
        };
        best(&self.groups.planes).or_else(|| best(&self.bisectors(members)))
    }

    /// Pairs of different groups that a plane parts, less those of the same one; none if it parts no two groups.
    fn score(&self, plane: Vec4, members: &[(u32, usize)]) -> Option<i64> {
        let (mut before, mut behind) = (Vec::new(), Vec::new());
        for (surfel, group) in members {
            if self.is_before(plane, *surfel) { before.push(*group) } else { behind.push(*group) }
        }
        let all = (before.len() * behind.len()) as i64;
        let same: usize = before.iter().map(|group| behind.iter().filter(|other| *other == group).count()).sum();
        let same = same as i64;
        (all > same).then_some(all - 2 * same)
    }

    fn bisectors(&self, members: &[(u32, usize)]) -> Vec<Vec4> {
        let Some((first, group)) = members.first() else { return Vec::new() };
        let surface = |surfel: u32| self.groups.sorted.point(surfel).surface;
        let others = members.iter().filter(|(_, other)| other != group).map(|(surfel, _)| *surfel);
        let Some(other) = self.groups.sorted.nearest(others, surface(*first)) else { return Vec::new() };
        let (a, b) = (surface(*first), surface(other));
        let normal = (a - b).normalize_or_zero();
        vec![normal.extend(-0.5 * normal.dot(a + b))]
    }
}
