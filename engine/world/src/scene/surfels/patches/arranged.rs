//! The surfels of an object, patch after patch.

use super::cells::{Cell, Faces, grid_normal, with_neighbors};
use super::occluders::{Occluders, Point};
use super::split::{Part, Side, Sorted, Split};
use super::subject::{NODE, Subject};
use crate::assets::parallel;
use crate::scene::Surfel;
use glam::{Mat3A, Vec3, Vec4};
use std::ops::Range;
use std::sync::Arc;

/// Surfels, or cells, that are looked at together.
const CHUNK: usize = 1024;

/// The surfels of an object, patch after patch.
#[derive(Debug)]
pub(in crate::scene::surfels) struct Arranged {
    /// Their source. It is kept alive, so that its address identifies it.
    #[expect(dead_code)]
    source: Arc<Vec<Surfel>>,
    size: u32,
    /// All surfels.
    pub surfels: Vec<Surfel>,
    /// Which of the source each of them is.
    pub order: Vec<u32>,
    pub(super) ranges: Vec<[u32; 2]>,
    pub(super) cells: Vec<([i32; 3], Faces)>,
    pub(super) nodes: Vec<Node>,
}

/// A plane that parts a cell.
#[derive(Debug)]
pub(super) struct Node {
    /// In the grid of the object.
    pub plane: Vec4,
    /// The patch or node of either side, before and behind it.
    pub sides: [u32; 2],
}

/// An object's surfels in the order of its cells.
struct InOrder {
    surfels: Vec<Surfel>,
    /// Which of the source each of them is.
    order: Vec<u32>,
    cells: Vec<Cell>,
    ranges: Vec<[u32; 2]>,
}

/// The cells of an object that walls part.
#[derive(Default)]
struct Parted {
    /// By cell; there are none if the object moves.
    cells: Vec<Option<Split>>,
    /// Cells without a surfel.
    gaps: Vec<(Cell, Split)>,
}

/// The parts of a cell, if it has any, and cells beside it that have no surfel and may have some.
type Looked = (Option<Split>, Vec<Cell>);

/// Arranges the surfels of all objects for patches of a size \[m\].
pub(super) fn all(subjects: &[&Subject], size: f32) -> Vec<Arranged> {
    let ordered = parallel::map(subjects, |subject| InOrder::new(subject.surfels, &subject.shape, size));
    let parted = parted(subjects, &ordered);
    let objects: Vec<_> = subjects.iter().zip(ordered.iter().zip(&parted)).collect();
    parallel::map(&objects, |(subject, (object, parted))| Arranged::new(subject.surfels.clone(), size, object, parted))
}

/// The occluders that part the cells of each object.
fn parted(subjects: &[&Subject], ordered: &[InOrder]) -> Vec<Parted> {
    let occluders = |index: usize| subjects[index].occluders.as_ref();
    let count = |len: fn(&InOrder) -> usize| -> Vec<usize> {
        let counts = ordered.iter().zip(subjects);
        counts.map(|(object, subject)| if subject.occluders.is_some() { len(object) } else { 0 }).collect()
    };
    let points: Vec<Vec<Point>> = in_pieces(&count(|object| object.surfels.len()), |object, piece| {
        let point = |occluders: &Occluders| {
            ordered[object].surfels[piece].iter().map(|surfel| occluders.point(surfel)).collect()
        };
        occluders(object).map_or_else(Vec::new, point)
    });
    let sorted = |object: usize| {
        let InOrder { cells, ranges, .. } = &ordered[object];
        Sorted { cells, ranges, points: &points[object] }
    };
    let looked = in_pieces(&count(|object| object.cells.len()), |object, piece| {
        let sorted = sorted(object);
        let look =
            |occluders: &Occluders| piece.map(|cell| (sorted.split(occluders, cell), sorted.gaps(cell))).collect();
        occluders(object).map_or_else(Vec::new, look)
    });
    let finish = |(object, looked): (usize, Vec<Looked>)| {
        let (cells, gaps): (Vec<_>, Vec<_>) = looked.into_iter().unzip();
        let mut gaps: Vec<Cell> = gaps.into_iter().flatten().collect();
        gaps.sort_unstable();
        gaps.dedup();
        let split = |gap: Cell| Some((gap, sorted(object).split_gap(occluders(object)?, gap)?));
        Parted { cells, gaps: gaps.into_iter().filter_map(split).collect() }
    };
    looked.into_iter().enumerate().map(finish).collect()
}

/// Works on each of so many things of several objects; those of all objects together share the cores.
fn in_pieces<T: Send>(counts: &[usize], work: impl Fn(usize, Range<usize>) -> Vec<T> + Sync) -> Vec<Vec<T>> {
    let pieces = |(object, count): (usize, &usize)| {
        let count = *count;
        (0..count).step_by(CHUNK).map(move |first| (object, first..count.min(first + CHUNK)))
    };
    let pieces: Vec<(usize, Range<usize>)> = counts.iter().enumerate().flat_map(pieces).collect();
    let mut all: Vec<Vec<T>> = counts.iter().map(|count| Vec::with_capacity(*count)).collect();
    for ((object, _), done) in pieces.iter().zip(parallel::map(&pieces, |(object, piece)| work(*object, piece.clone())))
    {
        all[*object].extend(done);
    }
    all
}

impl InOrder {
    fn new(source: &[Surfel], shape: &Mat3A, size: f32) -> Self {
        let cell = |surfel: &Surfel| {
            let normal = grid_normal(shape, surfel.normal.into());
            Cell::of(*shape * Vec3::from(surfel.position) / size, normal)
        };
        let mut order: Vec<(Cell, u32)> = source.iter().map(cell).zip(0..).collect();
        order.sort_unstable();
        let surfels = order.iter().map(|(_, index)| source[*index as usize]).collect();
        let (mut ranges, mut cells): (Vec<[u32; 2]>, Vec<Cell>) = (Vec::new(), Vec::new());
        for ((cell, _), index) in order.iter().zip(0..) {
            match ranges.last_mut() {
                Some([_, count]) if cells.last() == Some(cell) => *count += 1,
                _ => {
                    ranges.push([index, 1]);
                    cells.push(*cell);
                }
            }
        }
        Self { surfels, order: order.into_iter().map(|(_, index)| index).collect(), cells, ranges }
    }
}

impl Arranged {
    /// Whether it has patches of a size \[m\].
    pub(super) fn is_of(&self, size: f32) -> bool {
        self.size == size.to_bits()
    }

    fn new(source: Arc<Vec<Surfel>>, size: f32, object: &InOrder, parted: &Parted) -> Self {
        let split = |cell: usize| parted.cells.get(cell).and_then(Option::as_ref);
        let numbers = Numbers::of(object, split);
        let mut nodes = Vec::new();
        let mut own = Vec::with_capacity(object.cells.len());
        let mut is_hidden = Vec::with_capacity(object.cells.len());
        for (cell, [first, count]) in object.ranges.iter().enumerate() {
            let answers = match split(cell) {
                None => numbers.patch_of[*first as usize],
                Some(split) => numbers.add_nodes(split, &mut nodes),
            };
            own.push((object.cells[cell], answers));
            let surfels = &object.surfels[*first as usize..][..*count as usize];
            // Beyond a wall there may be light.
            let is_beyond = |split: &Split| split.parts.iter().any(|part| matches!(part, Part::Beyond(_)));
            is_hidden.push(surfels.iter().all(Surfel::is_hidden) && !split(cell).is_some_and(is_beyond));
        }
        let gap = |(cell, split): &(Cell, Split)| (*cell, numbers.add_nodes(split, &mut nodes));
        let gaps: Vec<(Cell, u32)> = parted.gaps.iter().map(gap).collect();
        let cells = with_neighbors(&own, &is_hidden, &gaps);
        let surfels = numbers.order.iter().map(|index| object.surfels[*index as usize]).collect();
        let order = numbers.order.iter().map(|index| object.order[*index as usize]).collect();
        Self { source, size: size.to_bits(), surfels, order, ranges: numbers.ranges, cells, nodes }
    }

    pub fn patch_count(&self) -> u32 {
        self.ranges.len() as u32
    }

    /// The patch of each surfel.
    pub fn patch_of_surfels(&self) -> impl Iterator<Item = u32> + '_ {
        (0..).zip(&self.ranges).flat_map(|(patch, [_, count])| (0..*count).map(move |_| patch))
    }
}

/// Which surfels are which patch.
struct Numbers {
    order: Vec<u32>,
    ranges: Vec<[u32; 2]>,
    /// By surfel.
    patch_of: Vec<u32>,
}

impl Numbers {
    fn of<'a>(object: &InOrder, split: impl Fn(usize) -> Option<&'a Split>) -> Self {
        let surfels = object.surfels.len();
        let mut numbers = Self { order: Vec::with_capacity(surfels), ranges: Vec::new(), patch_of: vec![0; surfels] };
        for (cell, [first, count]) in object.ranges.iter().enumerate() {
            match split(cell) {
                None => numbers.add(*first..first + count),
                Some(split) => split.parts.iter().for_each(|part| match part {
                    Part::Own(own) => numbers.add(own.iter().copied()),
                    Part::Beyond(_) => {}
                }),
            }
        }
        numbers
    }

    /// Adds a patch.
    fn add(&mut self, surfels: impl Iterator<Item = u32>) {
        let (patch, first) = (self.ranges.len() as u32, self.order.len());
        self.order.extend(surfels);
        for surfel in &self.order[first..] {
            self.patch_of[*surfel as usize] = patch;
        }
        self.ranges.push([first as u32, (self.order.len() - first) as u32]);
    }

    /// Adds the nodes of a cell, and gives what answers in it.
    fn add_nodes(&self, split: &Split, nodes: &mut Vec<Node>) -> u32 {
        let first = nodes.len();
        let answer = |side: Side| match side {
            Side::Node(index) => NODE | (first + index) as u32,
            Side::Part(index) => match &split.parts[index] {
                Part::Own(surfels) => self.patch_of[surfels[0] as usize],
                Part::Beyond(surfel) => self.patch_of[*surfel as usize],
            },
        };
        nodes.extend(split.nodes.iter().map(|(plane, sides)| Node { plane: *plane, sides: sides.map(answer) }));
        answer(if split.nodes.is_empty() { Side::Part(0) } else { Side::Node(0) })
    }
}
