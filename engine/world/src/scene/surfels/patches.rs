//! Patches: surfels that lie together on one side of an object, as one piece of surface whose light is known.
//!
//! Each object has a grid of its own, in its own space, so that its patches move with it: what lies in one cell of the grid
//! and faces the same of six ways is a patch, or several where something static stands in between. A hash table finds the
//! patch of any point of a surface. It also holds the cells next to patches, and for each cell a patch for every way that a
//! surface may face there, since surfels are samples: where a corner of a surface has none, the nearest patch answers.
//!
//! Objects that bend have the patches of their mesh at rest, see [`super::bending`], and a hash table of their own: a pose
//! changes nothing but where in it they are found.

mod arranged;
mod cells;
mod occluders;
mod split;
mod subject;
#[cfg(test)]
mod tests;

pub(super) use arranged::Arranged;
pub(super) use cells::{Cell, Faces, cells_of, grid_normal};
pub use cells::{NO_PATCH, cells_from_world};
pub(super) use occluders::Occluders;
pub(super) use subject::Subject;

use super::bending::Bending;
use arranged::Node;
use glam::{Vec3, Vec4};
use std::collections::{HashMap, HashSet};
use std::sync::Arc;
use subject::NODE;

/// Surfels that an even surface has in a patch.
const SURFELS_A_PATCH: f32 = 4.0;

/// Most places of the table that are looked at for a patch, as `PATCH_PROBES` of `lib/patches.wgsl`.
const PROBES: u32 = 32;

/// Cells in which a patch of an object that bends may be found, about: its own and those beside it, which it shares.
const CELLS_OF_A_PATCH: usize = 8;

/// The patches of a scene. Those of a patch's surfels follow each other in the cloud.
#[derive(Debug, Default)]
pub struct Patches {
    /// First surfel and number of surfels of each patch.
    pub ranges: Vec<[u32; 2]>,
    /// First the places of a hash table with open addressing, a power of two of them: what answers in a cell for each of the
    /// six ways that a surface may face, its tag, and 1; those that are empty end with 0. Then nodes: a plane in the
    /// grid of the object, as bits of floats, and what answers before and behind it. What answers is a patch,
    /// [`NO_PATCH`], or the highest bit and the index of a node. At last the places of another table, for objects that bend.
    pub table: Vec<[u32; 8]>,
    /// Edge of a cell \[m\].
    pub size: f32,
    /// Number of places of the first table.
    places: usize,
    /// Where the second one begins.
    bending: usize,
    /// Whether it is the one of a group.
    bends: Vec<bool>,
    known: HashMap<usize, Arc<Arranged>>,
}

/// Where the patches of an object are looked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PatchTable {
    /// Its first place.
    pub first: u32,
    /// Number of places, a power of two.
    pub places: u32,
    /// Where nodes begin.
    pub nodes: u32,
}

/// Edge of a patch \[m\], for so many surfels a square metre.
pub(super) fn patch_size(density: f32) -> f32 {
    (SURFELS_A_PATCH / density).sqrt()
}

impl Patches {
    /// Arranges the surfels of each object for patches of a size \[m\]. Costs little for objects that did not change.
    pub(super) fn arrange(&mut self, size: f32, subjects: &[Subject]) -> Vec<Arc<Arranged>> {
        self.size = size;
        let mut before = std::mem::take(&mut self.known);
        let (mut missing, mut seen) = (Vec::new(), HashSet::new());
        for subject in subjects.iter().filter(|subject| seen.insert(address(subject))) {
            match before.remove(&address(subject)).filter(|known| known.is_of(size) && !subject.is_changed) {
                Some(known) => drop(self.known.insert(address(subject), known)),
                None => missing.push(subject),
            }
        }
        for (subject, arranged) in missing.iter().zip(arranged::all(&missing, size)) {
            self.known.insert(address(subject), Arc::new(arranged));
        }
        subjects.iter().map(|subject| self.known[&address(subject)].clone()).collect()
    }

    /// Puts the patches of all objects together. Whether they are found elsewhere than before.
    pub(super) fn collect(&mut self, objects: &[Arc<Arranged>], bent: &[Bending]) -> bool {
        let (table_before, starts_before) = (std::mem::take(&mut self.table), [self.places, self.bending]);
        self.ranges.clear();
        self.bends = vec![false; objects.len()];
        bent.iter().for_each(|bent| self.bends[bent.group] = true);
        let mut surfels = 0;
        let (mut cells, mut nodes) = (Vec::new(), Vec::new());
        for (object, group) in objects.iter().zip(0_u32..) {
            let first = [self.ranges.len() as u32, nodes.len() as u32];
            self.ranges.extend(object.ranges.iter().map(|[start, count]| [start + surfels, *count]));
            surfels += object.surfels.len() as u32;
            if !self.bends[group as usize] {
                cells.extend(in_scene(group, &object.cells, first));
                nodes.extend(object.nodes.iter().map(|node| encoded(node, first)));
            }
        }
        self.table = table(&cells, 2 * cells.len());
        self.places = self.table.len();
        self.table.extend(nodes);
        self.bending = self.table.len();
        if !bent.is_empty() {
            // Other poses take other cells, seldom more than so many a patch.
            let patches: usize = bent.iter().map(|bent| objects[bent.group].patch_count() as usize).sum();
            let cells = cells_of_poses(bent);
            self.table.extend(table(&cells, 2 * cells.len().max(CELLS_OF_A_PATCH * patches)));
        }
        table_before != self.table || starts_before != [self.places, self.bending]
    }

    /// Takes over where objects that bend are now. False if there is no room for that.
    pub(super) fn bend(&mut self, bent: &[Bending]) -> bool {
        let cells = cells_of_poses(bent);
        let places = self.table.len() - self.bending;
        let Some(table) = (2 * cells.len() <= places).then(|| table_of(&cells, places)).flatten() else {
            return false;
        };
        self.table[self.bending..].copy_from_slice(&table);
        true
    }

    /// The table of objects that bend, and where it begins in the whole.
    pub fn bending(&self) -> (usize, &[[u32; 8]]) {
        (self.bending, &self.table[self.bending..])
    }

    /// Where patches of a group are looked for.
    pub fn table_of(&self, group: usize) -> PatchTable {
        let (first, places) = match self.bends.get(group) {
            Some(true) => (self.bending, self.table.len() - self.bending),
            _ => (0, self.places),
        };
        PatchTable { first: first as u32, places: places as u32, nodes: self.places as u32 }
    }

    /// The patch that a point of a surface belongs to, by the point and the normal in the grid of its object (see
    /// [`cells_from_world`]), as shaders find it; none where no surfel is near.
    pub fn at(&self, group: u32, point: Vec3, normal: Vec3) -> Option<u32> {
        let cell = Cell::of(point, normal);
        let [start, tag] = hashes(group, cell.at);
        let PatchTable { first, places, nodes } = self.table_of(group as usize);
        let place = |step: u32| first + (start.wrapping_add(step) & (places - 1));
        let found = (0..PROBES).map(|step| &self.table[place(step) as usize]);
        let found = found.take_while(|place| place[7] != 0).find(|place| place[6] == tag)?;
        let mut patch = found[cell.face as usize];
        for _ in 0..split::DEPTH {
            if patch & NODE != 0 {
                let node = &self.table[(nodes + (patch & !NODE)) as usize];
                let plane = Vec4::from_array([0, 1, 2, 3].map(|i| f32::from_bits(node[i])));
                patch = if plane.dot(point.extend(1.0)) >= 0.0 { node[4] } else { node[5] };
            }
        }
        (patch != NO_PATCH).then_some(patch)
    }
}

/// Stands for an object's surfels, as long as they are kept.
fn address(subject: &Subject) -> usize {
    Arc::as_ptr(subject.surfels) as usize
}

/// Converts an entry of a cell from an object's numbering to the scene's, given the object's first patch and node.
fn moved(face: u32, [patch, node]: [u32; 2]) -> u32 {
    match face {
        NO_PATCH => NO_PATCH,
        _ if face & NODE != 0 => face + node,
        _ => face + patch,
    }
}

fn encoded(node: &Node, first: [u32; 2]) -> [u32; 8] {
    let [x, y, z, w] = node.plane.to_array().map(f32::to_bits);
    let [before, behind] = node.sides.map(|side| moved(side, first));
    [x, y, z, w, before, behind, 0, 0]
}

/// Cells of a group, and where they are looked for in a table, by its first patch and node.
fn in_scene(group: u32, cells: &[([i32; 3], Faces)], first: [u32; 2]) -> impl Iterator<Item = ([u32; 2], Faces)> {
    cells.iter().map(move |(at, faces)| (hashes(group, *at), faces.map(|face| moved(face, first))))
}

fn cells_of_poses(bent: &[Bending]) -> Vec<([u32; 2], Faces)> {
    bent.iter().flat_map(|bent| in_scene(bent.group as u32, &bent.cells, [bent.first_patch, 0])).collect()
}

/// All cells in a table of so many places, or more.
fn table(cells: &[([u32; 2], Faces)], least: usize) -> Vec<[u32; 8]> {
    let mut places = least.next_power_of_two().max(2);
    loop {
        match table_of(cells, places) {
            Some(table) => return table,
            None => places *= 2,
        }
    }
}

/// All cells in a table of so many places; none if some would lie too far from where they are looked for.
fn table_of(cells: &[([u32; 2], Faces)], places: usize) -> Option<Vec<[u32; 8]>> {
    let mut table = vec![[0; 8]; places];
    let mask = places as u32 - 1;
    for ([start, tag], [a, b, c, d, e, f]) in cells {
        let step = (0..PROBES).find(|step| table[(start.wrapping_add(*step) & mask) as usize][7] == 0)?;
        table[(start.wrapping_add(step) & mask) as usize] = [*a, *b, *c, *d, *e, *f, *tag, 1];
    }
    Some(table)
}

/// Where a cell of an object is looked for in the table, and the tag by which it is known, as in `lib/patches.wgsl`.
fn hashes(group: u32, cell: [i32; 3]) -> [u32; 2] {
    let [x, y, z] = cell.map(|v| v as u32);
    let start = hash(x ^ hash(y ^ hash(z ^ hash(group))));
    let tag = hash(z ^ hash(x ^ hash(y ^ hash(group ^ 0x9e37_79b9))));
    [start, tag]
}

/// Equals `hash` of `lib/sampling.wgsl`.
fn hash(value: u32) -> u32 {
    let state = value.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    (word >> 22) ^ word
}
