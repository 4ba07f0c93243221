//! Patches: surfels that lie together on one side of an object, as one piece of surface whose light is known.
//!
//! Each object has a grid of its own, in its own space, so that its patches move with it: what lies in one cell of the grid
//! and faces the same of six ways is a patch. A hash table finds the patch of any point of a surface. It also holds the
//! cells next to patches, and for each cell a patch for every way that a surface may face there, since surfels are samples:
//! where a corner of a surface has none, the nearest patch answers.

use super::{Surfel, shape};
use glam::{Affine3A, IVec3, Mat3A, Vec3};
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::sync::Arc;

/// Surfels that an even surface has in a patch.
const SURFELS_A_PATCH: f32 = 4.0;

/// Stands for no patch, as `NO_PATCH` of `lib/patches.wgsl`.
pub const NO_PATCH: u32 = 0x000f_ffff;

/// How far before its surface a point is taken when its cell is chosen \[cells\], as `PATCH_BEFORE` of `lib/patches.wgsl`: a
/// surface that lies on the border between cells is then in one of them.
const BEFORE: f32 = 0.25;

/// Cells from the origin beyond which all are one, as `PATCH_REACH` of `lib/patches.wgsl`.
const REACH: f32 = 1e9;

/// Most places of the table that are looked at for a patch, as `PATCH_PROBES` of `lib/patches.wgsl`.
const PROBES: u32 = 32;

/// The patches of a scene. Those of a patch's surfels follow each other in the cloud.
#[derive(Debug, Default)]
pub struct Patches {
    /// First surfel and number of surfels of each patch.
    pub ranges: Vec<[u32; 2]>,
    /// Places of a hash table with open addressing, a power of two of them: the patches of a cell that face each of the six
    /// ways, or [`NO_PATCH`], its tag, and 1; all others end with 0.
    pub table: Vec<[u32; 8]>,
    /// Edge of a cell \[m\].
    pub size: f32,
    known: HashMap<usize, Arc<Arranged>>,
}

/// The surfels of an object, patch after patch.
#[derive(Debug)]
pub(super) struct Arranged {
    /// What they were made of. It is kept, so that its address stands for it.
    #[expect(dead_code)]
    source: Arc<Vec<Surfel>>,
    size: u32,
    /// All surfels.
    pub surfels: Vec<Surfel>,
    ranges: Vec<[u32; 2]>,
    cells: Vec<([i32; 3], Faces)>,
}

/// A cell of an object's grid, and which of the six ways its surface faces.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
struct Cell {
    at: [i32; 3],
    face: u32,
}

impl Patches {
    /// Arranges the surfels of each object, which stands at `places`, for patches that hold about [`SURFELS_A_PATCH`] of
    /// them. Costs little for objects that did not change.
    pub(super) fn update(
        &mut self,
        density: f32,
        places: &[Affine3A],
        objects: &[Arc<Vec<Surfel>>],
    ) -> Vec<Arc<Arranged>> {
        self.size = (SURFELS_A_PATCH / density).sqrt();
        let mut before = std::mem::take(&mut self.known);
        let size = self.size;
        let mut arranged = Vec::with_capacity(objects.len());
        for (source, place) in objects.iter().zip(places) {
            let address = Arc::as_ptr(source) as usize;
            let found = match self.known.entry(address) {
                Entry::Occupied(entry) => entry.get().clone(),
                Entry::Vacant(entry) => {
                    let known = before.remove(&address).filter(|known| known.size == size.to_bits());
                    let known = known.unwrap_or_else(|| Arc::new(Arranged::new(source.clone(), &shape(place), size)));
                    entry.insert(known).clone()
                }
            };
            arranged.push(found);
        }
        self.collect(&arranged);
        arranged
    }

    /// Puts the patches of all objects together.
    fn collect(&mut self, objects: &[Arc<Arranged>]) {
        self.ranges.clear();
        let mut surfels = 0;
        let mut cells = Vec::new();
        for (object, group) in objects.iter().zip(0..) {
            let first = self.ranges.len() as u32;
            self.ranges.extend(object.ranges.iter().map(|[start, count]| [start + surfels, *count]));
            let in_scene =
                |patches: &Faces| patches.map(|patch| if patch == NO_PATCH { NO_PATCH } else { first + patch });
            cells.extend(object.cells.iter().map(|(at, patches)| (hashes(group, *at), in_scene(patches))));
            surfels += object.surfels.len() as u32;
        }
        let mut places = (2 * cells.len()).next_power_of_two().max(2);
        self.table = loop {
            match table(&cells, places) {
                Some(table) => break table,
                None => places *= 2,
            }
        };
    }

    /// The patch that a point of a surface belongs to, by the point and the normal in the grid of its object (see
    /// [`cells_from_world`]), as shaders find it; none where no surfel is near.
    pub fn at(&self, group: u32, point: Vec3, normal: Vec3) -> Option<u32> {
        let cell = Cell::of(point, normal);
        let [start, tag] = hashes(group, cell.at);
        let mask = self.table.len() as u32 - 1;
        let found = (0..PROBES).map(|step| &self.table[(start.wrapping_add(step) & mask) as usize]);
        let found = found.take_while(|place| place[7] != 0).find(|place| place[6] == tag);
        found.map(|place| place[cell.face as usize]).filter(|patch| *patch != NO_PATCH)
    }
}

/// Writes all cells into a table of so many places; none if some would lie too far from where they are looked for.
fn table(cells: &[([u32; 2], Faces)], places: usize) -> Option<Vec<[u32; 8]>> {
    let mut table = vec![[0; 8]; places];
    let mask = places as u32 - 1;
    for ([start, tag], [a, b, c, d, e, f]) in cells {
        let step = (0..PROBES).find(|step| table[(start.wrapping_add(*step) & mask) as usize][7] == 0)?;
        table[(start.wrapping_add(step) & mask) as usize] = [*a, *b, *c, *d, *e, *f, *tag, 1];
    }
    Some(table)
}

impl Arranged {
    fn new(source: Arc<Vec<Surfel>>, shape: &Mat3A, size: f32) -> Self {
        let cell = |surfel: &Surfel| {
            let normal = grid_normal(shape, surfel.normal.into());
            Cell::of(*shape * Vec3::from(surfel.position) / size, normal)
        };
        let mut order: Vec<(Cell, u32)> = source.iter().map(cell).zip(0..).collect();
        order.sort_unstable();
        let surfels: Vec<Surfel> = order.iter().map(|(_, index)| source[*index as usize]).collect();
        let (mut ranges, mut own): (Vec<[u32; 2]>, Vec<Cell>) = (Vec::new(), Vec::new());
        for ((cell, _), index) in order.iter().zip(0..) {
            match ranges.last_mut() {
                Some([_, count]) if own.last() == Some(cell) => *count += 1,
                _ => {
                    ranges.push([index, 1]);
                    own.push(*cell);
                }
            }
        }
        let hidden = |range: &[u32; 2]| {
            let [first, count] = range.map(|v| v as usize);
            surfels[first..first + count].iter().all(Surfel::is_hidden)
        };
        let is_hidden: Vec<bool> = ranges.iter().map(hidden).collect();
        let cells = with_neighbors(&own, &is_hidden);
        Self { source, size: size.to_bits(), surfels, ranges, cells }
    }
}

/// Patches of a cell that face each of the six ways.
type Faces = [u32; 6];

/// The cells of patches and those around them. Each face has the nearest patch that faces so.
#[derive(Default)]
struct Cells {
    places: HashMap<[i32; 3], usize>,
    cells: Vec<([i32; 3], Faces)>,
}

impl Cells {
    /// Adds patches where nothing is known yet, nearer ones first.
    fn add(&mut self, patches: &[(Cell, u32)]) {
        let around = (0..27).map(|i| IVec3::new(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1));
        for distance in 0..4 {
            let steps: Vec<IVec3> = around.clone().filter(|step| step.length_squared() == distance).collect();
            for (cell, patch) in patches {
                for step in &steps {
                    let at = std::array::from_fn(|axis| cell.at[axis].saturating_add(step[axis]));
                    let known = &mut self.faces(at)[cell.face as usize];
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

/// The cells of all patches and those around them, with a patch for each of the six ways. What lies in cracks answers only
/// where nothing else does: it is dark, and what is seen of a surface is not.
fn with_neighbors(own: &[Cell], is_hidden: &[bool]) -> Vec<([i32; 3], Faces)> {
    let patches = |hidden: bool| -> Vec<(Cell, u32)> {
        let all = own.iter().copied().zip(0..).zip(is_hidden);
        all.filter(|(_, is_hidden)| **is_hidden == hidden).map(|(patch, _)| patch).collect()
    };
    let mut cells = Cells::default();
    cells.add(&patches(false));
    cells.fill(false);
    cells.add(&patches(true));
    cells.fill(true);
    cells.cells
}

impl Cell {
    /// The cell of a point, in cells, of a surface with that normal.
    fn of(point: Vec3, normal: Vec3) -> Self {
        let at = (point + BEFORE * normal).floor();
        let at = at.to_array().map(|v| if v.is_finite() { v.clamp(-REACH, REACH) as i32 } else { 0 });
        Self { at, face: face_of(normal) }
    }
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
fn grid_normal(shape: &Mat3A, normal: Vec3) -> Vec3 {
    let [a, b, c] = [shape.x_axis, shape.y_axis, shape.z_axis].map(Vec3::from);
    let cofactor = b.cross(c) * normal.x + c.cross(a) * normal.y + a.cross(b) * normal.z;
    let turned = if a.dot(b.cross(c)) < 0.0 { -1.0 } else { 1.0 };
    turned * cofactor.normalize_or_zero()
}

/// Cells of an object's grid from world space, without a change of size but that from metres to cells. Objects that are
/// scaled evenly have a grid that turns with them; others one along the axes of the world.
pub fn cells_from_world(place: &Affine3A, size: f32) -> Affine3A {
    let shape = shape(place);
    let turn = if shape == place.matrix3 { Mat3A::IDENTITY } else { shape * place.matrix3.inverse() };
    let turn = if turn.is_finite() { turn } else { Mat3A::IDENTITY };
    let linear = turn * (1.0 / size);
    Affine3A { matrix3: linear, translation: -(linear * place.translation) }
}

/// Where a cell of an object is looked for in the table, and the tag by which it is known, as in `lib/patches.wgsl`.
fn hashes(group: u32, cell: [i32; 3]) -> [u32; 2] {
    let [x, y, z] = cell.map(|v| v as u32);
    let start = hash(x ^ hash(y ^ hash(z ^ hash(group))));
    let tag = hash(z ^ hash(x ^ hash(y ^ hash(group ^ 0x9e37_79b9))));
    [start, tag]
}

/// As `hash` of `lib/sampling.wgsl`.
fn hash(value: u32) -> u32 {
    let state = value.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    (word >> 22) ^ word
}

#[cfg(test)]
mod tests {
    use super::super::{SurfelCloud, triangles};
    use super::*;
    use crate::assets::{Material, Shape};
    use crate::scene::{Primitive, Revisions, Scene, SceneId};

    fn primitive(id: u64, shape: Shape, place: Affine3A) -> Primitive {
        let mesh = Arc::new(shape.mesh().expect("a valid shape"));
        Primitive {
            id: SceneId(id),
            bounds: mesh.bounds.transformed(&place),
            world_from_object: place,
            material: Arc::new(Material::diffuse("stone", Vec3::splat(0.5))),
            mesh,
            casts_shadow: true,
            moving: false,
            geometry_revision: 0,
            material_revision: 0,
        }
    }

    fn scene(primitives: Vec<Primitive>) -> Scene {
        let revisions = Revisions { geometry: 1, ..Default::default() };
        Scene { identity: 1, revisions, primitives, ..Default::default() }
    }

    /// A point within a triangle, and its outward normal, in the world.
    fn points(primitive: &Primitive) -> impl Iterator<Item = (Vec3, Vec3)> {
        let place = primitive.world_from_object;
        let turned = if place.matrix3.determinant() < 0.0 { -1.0 } else { 1.0 };
        triangles(primitive).flat_map(move |triangle| {
            let [a, b, c] = triangle.corners.map(|corner| place.transform_point3(corner));
            let normal = turned * (b - a).cross(c - a).normalize_or_zero();
            let weights = [[0.9, 0.05, 0.05], [0.05, 0.9, 0.05], [0.05, 0.05, 0.9], [0.34, 0.33, 0.33]];
            weights.map(|[u, v, w]| (u * a + v * b + w * c, normal))
        })
    }

    /// Every point of every surface has a patch whose surfels lie near it and face its way, however the object is turned,
    /// scaled or mirrored, and it is the same object's.
    #[test]
    fn every_point_of_a_surface_has_a_patch_nearby() {
        let places = [
            Affine3A::IDENTITY,
            Affine3A::from_rotation_y(0.4)
                * Affine3A::from_rotation_x(1.1)
                * Affine3A::from_translation(Vec3::splat(3.0)),
            Affine3A::from_scale_rotation_translation(
                Vec3::splat(2.5),
                glam::Quat::from_rotation_z(0.3),
                Vec3::X * 9.0,
            ),
            Affine3A::from_scale_rotation_translation(
                Vec3::new(2.0, 0.5, 1.0),
                glam::Quat::from_rotation_z(0.3),
                Vec3::X * -9.0,
            ),
            Affine3A::from_scale_rotation_translation(
                Vec3::new(-1.0, 1.0, 1.0),
                glam::Quat::from_rotation_y(0.3),
                Vec3::Y * 9.0,
            ),
        ];
        let shapes = [
            Shape::Box { size: [1.0, 2.0, 0.1] },
            Shape::Sphere { radius: 0.7, segments: 24, rings: 12 },
            Shape::Box { size: [0.05, 0.9, 0.05] },
        ];
        for cell in [0.1, 0.45] {
            for shape in &shapes {
                let primitives = (1..).zip(&places).map(|(id, place)| primitive(id, shape.clone(), *place)).collect();
                let scene = scene(primitives);
                let mut cloud = SurfelCloud::default();
                cloud.update(&scene, cell);
                let patches = &cloud.patches;
                let (mut facing, mut all) = (0, 0);
                let is_small = matches!(shape, Shape::Box { size } if size[0] < cell && size[2] < cell);
                for (index, primitive) in scene.primitives.iter().enumerate() {
                    let group = cloud.place_of_primitive[index];
                    let grid = cells_from_world(&cloud.places[group as usize], patches.size);
                    for (point, normal) in points(primitive) {
                        let turned = grid.transform_vector3(normal).normalize();
                        let patch = patches.at(group, grid.transform_point3(point), turned).expect("a patch");
                        let [first, count] = patches.ranges[patch as usize].map(|v| v as usize);
                        let surfels = &cloud.surfels[first..first + count];
                        assert!(surfels.iter().all(|surfel| surfel.group() == group as usize));
                        let place = cloud.places[group as usize];
                        let nearest = surfels.iter().map(|s| place.transform_point3(s.position.into()).distance(point));
                        let nearest = nearest.fold(f32::INFINITY, f32::min);
                        assert!(nearest < 5.0 * patches.size, "{nearest} m, patches of {} m", patches.size);
                        let faces =
                            surfels.iter().any(|s| crate::bvh::world_normal(&place, s.normal.into()).dot(normal) > 0.4);
                        facing += u32::from(faces);
                        all += 1;
                    }
                }
                // Some sides of what is smaller than a cell have no surfels, and others answer for them.
                let least = if is_small { 0.5 } else { 0.9 };
                assert!(f64::from(facing) > least * f64::from(all), "{facing} of {all} face the same way");
            }
        }
    }

    #[test]
    fn each_surfel_is_in_one_patch_and_objects_that_move_keep_theirs() {
        let mut scene = scene(vec![primitive(1, Shape::Box { size: [1.0; 3] }, Affine3A::IDENTITY)]);
        let mut cloud = SurfelCloud::default();
        cloud.update(&scene, 0.2);
        let mut next = 0;
        for [first, count] in &cloud.patches.ranges {
            assert!(*first == next && *count > 0);
            next += count;
        }
        assert_eq!(next as usize, cloud.surfels.len());
        let (ranges, table) = (cloud.patches.ranges.clone(), cloud.patches.table.clone());
        scene.primitives[0].world_from_object = Affine3A::from_rotation_y(1.0) * Affine3A::from_translation(Vec3::ONE);
        scene.revisions.geometry += 1;
        cloud.update(&scene, 0.2);
        assert!(cloud.patches.ranges == ranges && cloud.patches.table == table);
    }
}
