//! Occluders between the surfels of a static object.

use super::cells::{BEFORE, Cell, cells_from_world};
use crate::scene::Surfel;
use crate::scene::surfels::still::Still;
use crate::scene::world_normal;
use glam::{Affine3A, Vec3, Vec4};

/// Cosine from which on two faces of a wall are taken for parallel.
const PARALLEL: f32 = 0.9;

/// The static scene around an object.
#[derive(Clone, Copy)]
pub(in crate::scene::surfels) struct Occluders<'a> {
    still: &'a Still,
    place: Affine3A,
    grid: Affine3A,
    size: f32,
    before: f32,
}

/// A surfel, and a point before it that others may see.
#[derive(Clone, Copy, Debug)]
pub(super) struct Point {
    /// The surfel, in the object's grid.
    pub surface: Vec3,
    /// In the world \[m\]: as far before it as where its cell is chosen, or half way to what is nearer.
    before: Vec3,
    /// Whether it lies in a crack, see [`Surfel::is_hidden`].
    pub is_hidden: bool,
}

/// The first hits of two points towards each other: both sides of a wall.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wall {
    /// Points \[m\] and unit normals in the world.
    sides: [[Vec3; 2]; 2],
}

impl<'a> Occluders<'a> {
    /// For an object at a place, in patches of a size \[m\]. Rays start so far before surfels \[m\].
    pub fn new(still: &'a Still, place: Affine3A, size: f32, before: f32) -> Self {
        Self { still, place, grid: cells_from_world(&place, size), size, before }
    }

    pub(super) fn point(&self, surfel: &Surfel) -> Point {
        let normal = world_normal(&self.place, surfel.normal.into());
        let surface = self.place.transform_point3(surfel.position.into());
        let from = surface + normal * (self.before + 1e-5 * surface.abs().max_element());
        let lift = BEFORE * self.size * normal;
        let share = self.still.obstacle(from, from + lift).map_or(1.0, |obstacle| 0.5 * obstacle.share);
        let (surface, is_hidden) = (self.grid.transform_point3(surface), surfel.is_hidden());
        Point { surface, before: from + share * lift, is_hidden }
    }

    /// The occluder between two points; none if they see each other.
    pub(super) fn between(&self, a: &Point, b: &Point) -> Option<Wall> {
        let side = |from: Vec3, to: Vec3| {
            let obstacle = self.still.obstacle(from, to)?;
            Some([from.lerp(to, obstacle.share), obstacle.normal])
        };
        let near = side(a.before, b.before)?;
        Some(Wall { sides: [near, side(b.before, a.before).unwrap_or(near)] })
    }

    /// Whether some of a cell may lie beyond a wall, as seen from a point in it.
    pub(super) fn reaches(&self, wall: &Wall, from: &Point, cell: Cell) -> bool {
        let middle = Vec3::from_array(cell.at.map(|v| v as f32 + 0.5));
        self.planes(wall).any(|plane| {
            let side = if plane.dot(from.surface.extend(1.0)) >= 0.0 { 1.0 } else { -1.0 };
            let reach = 0.5 * plane.truncate().abs().element_sum();
            side * plane.dot(middle.extend(1.0)) < reach
        })
    }

    /// Planes in the grid that part what is on either side of a wall: the one in its middle where its sides are parallel.
    pub(super) fn planes(&self, wall: &Wall) -> impl Iterator<Item = Vec4> {
        let [a, b] = wall.sides.map(|[point, normal]| {
            [self.grid.transform_point3(point), self.grid.transform_vector3(normal).normalize_or_zero()]
        });
        let plane = |point: Vec3, normal: Vec3| normal.extend(-normal.dot(point));
        let is_parallel = a[1].dot(b[1]).abs() > PARALLEL;
        let planes = if is_parallel {
            [Some(plane(0.5 * (a[0] + b[0]), a[1])), None]
        } else {
            [Some(plane(a[0], a[1])), Some(plane(b[0], b[1]))]
        };
        planes.into_iter().flatten()
    }
}
