//! Cells of an object's grid, and the patches that answer in them.

use crate::scene::surfels::group::shape;
use glam::{Affine3A, IVec3, Mat3A, Vec3};
use std::collections::HashMap;

/// Stands for no patch, as `NO_PATCH` of `lib/patches.wgsl`.
pub const NO_PATCH: u32 = 0x000f_ffff;

/// How far before its surface a point is taken when its cell is chosen \[cells\], as `PATCH_BEFORE` of `lib/patches.wgsl`: a
/// surface that lies on the border between cells is then in one of them.
pub(super) const BEFORE: f32 = 0.25;

/// Cells from the origin beyond which all are one, as `PATCH_REACH` of `lib/patches.wgsl`.
const REACH: f32 = 1e9;

/// Entries of a cell for the six directions that a surface may face: a patch, [`NO_PATCH`], or a node that chooses
/// between patches by the side of a plane, see [`super::split`].
pub(in crate::scene::surfels) type Faces = [u32; 6];

/// A cell of an object's grid, and which of the six ways its surface faces.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(in crate::scene::surfels) struct Cell {
    pub at: [i32; 3],
    pub face: u32,
}

impl Cell {
    /// The cell of a point, in cells, of a surface with that normal.
    pub fn of(point: Vec3, normal: Vec3) -> Self {
        let at = (point + BEFORE * normal).floor().to_array();
        let at = at.map(|v| if v.is_finite() { v.clamp(-REACH, REACH) as i32 } else { 0 });
        Self { at, face: face_of(normal) }
    }

    /// The cells around it that face the same way.
    pub fn around(self) -> impl Iterator<Item = Self> {
        steps().filter(|step| *step != IVec3::ZERO).map(move |step| self.moved(step))
    }

    /// Those of them that share a face with it.
    pub fn beside(self) -> impl Iterator<Item = Self> {
        steps().filter(|step| step.length_squared() == 1).map(move |step| self.moved(step))
    }

    fn moved(self, step: IVec3) -> Self {
        Self { at: std::array::from_fn(|axis| self.at[axis].saturating_add(step[axis])), face: self.face }
    }
}

/// A cell and all that touch it.
fn steps() -> impl Iterator<Item = IVec3> + Clone {
    (0..27).map(|i| IVec3::new(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1))
}

/// Which of the six ways a normal faces: +x, −x, +y, −y, +z, −z.
fn face_of(normal: Vec3) -> u32 {
    let size = normal.abs();
    let axis = if size.x >= size.y && size.x >= size.z {
        0
    } else if size.y >= size.z {
        1
    } else {
        2
    };
    2 * axis + u32::from(normal[axis as usize] < 0.0)
}

/// A normal of an object in its grid: by the cofactor matrix, its sign taken out, as `surfels.wgsl` does for the world.
pub(in crate::scene::surfels) fn grid_normal(shape: &Mat3A, normal: Vec3) -> Vec3 {
    let [a, b, c] = [shape.x_axis, shape.y_axis, shape.z_axis].map(Vec3::from);
    let cofactor = b.cross(c) * normal.x + c.cross(a) * normal.y + a.cross(b) * normal.z;
    let turned = if a.dot(b.cross(c)) < 0.0 { -1.0 } else { 1.0 };
    turned * cofactor.normalize_or_zero()
}

/// Cells of an object's grid from world space, without a change of size but that from metres to cells. The grid turns with its
/// object; that of sheared and flat objects lies along the axes of the world.
pub fn cells_from_world(place: &Affine3A, size: f32) -> Affine3A {
    let shape = shape(place);
    let turn = if shape == place.matrix3 { Mat3A::IDENTITY } else { shape * place.matrix3.inverse() };
    let turn = if turn.is_finite() { turn } else { Mat3A::IDENTITY };
    let linear = turn * (1.0 / size);
    Affine3A { matrix3: linear, translation: -(linear * place.translation) }
}

/// The cells of patches and those around them. Each face has the nearest patch that faces so.
#[derive(Default)]
struct Cells {
    places: HashMap<[i32; 3], usize>,
    cells: Vec<([i32; 3], Faces)>,
}

impl Cells {
    /// Adds patches where nothing is known yet, nearer ones first.
    fn add(&mut self, patches: &[(Cell, u32)]) {
        for distance in 0..4 {
            let steps: Vec<IVec3> = steps().filter(|step| step.length_squared() == distance).collect();
            for (cell, patch) in patches {
                for step in &steps {
                    let known = &mut self.faces(cell.moved(*step).at)[cell.face as usize];
                    if *known == NO_PATCH {
                        *known = *patch;
                    }
                }
            }
        }
    }

    fn faces(&mut self, at: [i32; 3]) -> &mut Faces {
        let place = *self.places.entry(at).or_insert_with(|| {
            self.cells.push((at, [NO_PATCH; 6]));
            self.cells.len() - 1
        });
        &mut self.cells[place].1
    }

    /// Where a cell knows no patch that faces some way, another one of it answers, at last the one that faces away.
    fn fill(&mut self, has_opposite: bool) {
        for (_, faces) in &mut self.cells {
            let known = *faces;
            for (face, patch) in faces.iter_mut().enumerate().filter(|(_, patch)| **patch == NO_PATCH) {
                let beside = (0..6).filter(|other| *other != face ^ 1).chain(has_opposite.then_some(face ^ 1));
                *patch = beside.map(|other| known[other]).find(|other| *other != NO_PATCH).unwrap_or(NO_PATCH);
            }
        }
    }
}

/// The cells in which patches are found whose surfels may lie anywhere, by the cell of each surfel and its patch: those with
/// surfels and those around them.
pub(in crate::scene::surfels) fn cells_of(surfels: impl Iterator<Item = (Cell, u32)>) -> Vec<([i32; 3], Faces)> {
    let mut surfels: Vec<(Cell, u32)> = surfels.collect();
    surfels.sort_unstable();
    let mut own: Vec<(Cell, u32)> = Vec::new();
    for in_cell in surfels.chunk_by(|(a, _), (b, _)| a == b) {
        let patches = in_cell.chunk_by(|(_, a), (_, b)| a == b);
        own.extend(
            patches.reduce(|most, other| if other.len() > most.len() { other } else { most }).map(|most| most[0]),
        );
    }
    with_neighbors(&own, &vec![false; own.len()], &[])
}

/// The cells with patches and those around them, with what answers for each of the six ways. What lies in cracks answers
/// only where nothing else does: it is dark, and what is seen of a surface is not. What answers in gaps is known already.
pub(super) fn with_neighbors(own: &[(Cell, u32)], is_hidden: &[bool], gaps: &[(Cell, u32)]) -> Vec<([i32; 3], Faces)> {
    let patches = |hidden: bool| -> Vec<(Cell, u32)> {
        let all = own.iter().zip(is_hidden);
        all.filter(|(_, is_hidden)| **is_hidden == hidden).map(|(patch, _)| *patch).collect()
    };
    let mut cells = Cells::default();
    for (cell, answer) in gaps {
        cells.faces(cell.at)[cell.face as usize] = *answer;
    }
    cells.add(&patches(false));
    cells.fill(false);
    cells.add(&patches(true));
    cells.fill(true);
    cells.cells
}
