//! The building: rooms side by side, floor, ceilings, and walls with openings, all of them boxes.
//!
//! Rooms are cells of a small grid. Boxes that meet reach into one another a little, and where they do, one of them is
//! thinner by a hair: nothing leaks between them, and no two visible faces lie in one plane.

use super::random::Random;
use super::solid::{Form, Item};
use super::wall::{Hole, Stretch, hole};
use glam::DVec3;

/// How a building lets light in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Openness {
    /// Walls and ceilings without openings.
    Closed,
    /// Windows or doors in the outer walls.
    Windows,
    /// One room without an outer wall.
    OpenFront,
    /// One room without a ceiling.
    OpenTop,
}

/// A room of the building.
#[derive(Clone, Debug)]
pub struct Cell {
    /// Its place in the grid.
    pub place: [usize; 2],
    /// Least corner of its air [m]; the floor is at y = 0.
    pub low: DVec3,
    /// Greatest corner of its air [m].
    pub high: DVec3,
    /// Whether it has a ceiling.
    pub covered: bool,
}

/// A hole in a wall.
#[derive(Clone, Debug)]
pub struct Opening {
    /// Its centre, in the middle of the wall [m].
    pub at: DVec3,
    /// Half of its width [m].
    pub half_width: f64,
    /// Lower and upper edge [m].
    pub heights: [f64; 2],
    /// Unit vector along the wall.
    pub along: DVec3,
    /// Unit vector through the wall; of outer walls it points outwards.
    pub out: DVec3,
    /// The rooms on its two sides; an outer wall has one.
    pub rooms: Vec<usize>,
}

/// The building.
#[derive(Clone, Debug)]
pub struct Building {
    /// The rooms.
    pub cells: Vec<Cell>,
    /// The openings.
    pub openings: Vec<Opening>,
    /// Thickness of walls and slabs [m].
    pub wall: f64,
    /// How light gets in.
    pub openness: Openness,
    /// The room that is seen.
    pub main: usize,
    /// Walls, floor and ceilings.
    pub items: Vec<Item>,
}

/// Names of the materials that a building takes.
pub const FLOOR: &str = "floor";
/// See [`FLOOR`].
pub const CEILING: &str = "ceiling";
/// See [`FLOOR`].
pub const WALLS: [&str; 4] = ["wall 1", "wall 2", "wall 3", "wall 4"];

/// Places of rooms in the grid, the first of which is the main room.
fn places(random: &mut Random) -> Vec<[usize; 2]> {
    match 1 + random.weighted(&[0.4, 0.3, 0.15, 0.15]) {
        1 => vec![[0, 0]],
        2 => vec![[0, 0], [1, 0]],
        3 if random.chance(0.5) => vec![[0, 0], [1, 0], [2, 0]],
        3 => vec![[0, 0], [1, 0], [0, 1]],
        4 if random.chance(0.3) => vec![[0, 0], [1, 0], [2, 0], [3, 0]],
        _ => vec![[0, 0], [1, 0], [0, 1], [1, 1]],
    }
}

/// The middles of the walls along one axis, from the widths of the air between them.
fn lines(widths: &[f64], wall: f64) -> Vec<f64> {
    let mut lines = vec![0.0];
    for width in widths {
        lines.push(lines[lines.len() - 1] + width + wall);
    }
    let middle = 0.5 * lines[lines.len() - 1];
    lines.iter().map(|line| line - middle).collect()
}

impl Building {
    /// Draws a building.
    pub fn draw(random: &mut Random) -> Self {
        let places = places(random);
        let openness = [Openness::Closed, Openness::Windows, Openness::OpenFront, Openness::OpenTop]
            [random.weighted(&[0.42, 0.28, 0.15, 0.15])];
        let count = |axis: usize| 1 + places.iter().map(|place| place[axis]).max().unwrap_or(0);
        // Of one room; long rows of large ones stay below 50 m.
        let longest = random.log_within(1.0, 30.0).min(50.0 / count(0) as f64);
        let mut widths = |count: usize| -> Vec<f64> {
            (0..count).map(|_| longest * if random.chance(0.35) { 1.0 } else { random.within(0.45, 1.0) }).collect()
        };
        let (mut columns, rows) = (widths(count(0)), widths(count(1)));
        // One room at least is as long as that.
        columns[0] = longest;
        let height = (longest * random.log_within(0.3, 0.9)).min(20.0);
        let least = columns.iter().chain(&rows).copied().fold(height, f64::min);
        let wall = random.log_within(0.01, 0.3).min(0.2 * least);
        let (x, z) = (lines(&columns, wall), lines(&rows, wall));
        let half = 0.5 * wall;
        let mut cells: Vec<Cell> = places
            .iter()
            .map(|&[i, k]| Cell {
                place: [i, k],
                low: DVec3::new(x[i] + half, 0.0, z[k] + half),
                high: DVec3::new(x[i + 1] - half, height, z[k + 1] - half),
                covered: true,
            })
            .collect();
        let main = random.below(cells.len());
        cells[main].covered = openness != Openness::OpenTop;
        let mut building = Self { cells, openings: Vec::new(), wall, openness, main, items: Vec::new() };
        let mut stretches = building.stretches(&x, &z);
        if openness == Openness::OpenFront {
            // Every room has an outer wall: no grid here has more than two rooms across.
            let outer: Vec<usize> =
                (0..stretches.len()).filter(|&i| stretches[i].is_outer() && stretches[i].touches(main)).collect();
            let front = outer[random.below(outer.len())];
            let gone = stretches.remove(front);
            building.openings.push(gone.opening(Hole { from: gone.span[0], to: gone.span[1], low: 0.0, high: height }));
        }
        let holes = building.holes(random, &stretches, height);
        for (index, (stretch, holes)) in stretches.iter().zip(&holes).enumerate() {
            let name = format!("Wall {}", index + 1);
            building.items.push(stretch.build(name, holes, wall, height, WALLS[random.below(WALLS.len())]));
        }
        building.posts(&x, &z, &stretches, height);
        building.slabs(&x, &z, height);
        building
    }

    fn cell_at(&self, i: isize, k: isize) -> Option<usize> {
        self.cells.iter().position(|cell| cell.place[0] as isize == i && cell.place[1] as isize == k)
    }

    /// All stretches of grid lines with a room on at least one side.
    fn stretches(&self, x: &[f64], z: &[f64]) -> Vec<Stretch> {
        let (mut all, half) = (Vec::new(), 0.5 * self.wall);
        for i in 0..x.len() {
            for k in 0..z.len() {
                let (column, row) = (i as isize, k as isize);
                if k + 1 < z.len() {
                    let sides = [self.cell_at(column - 1, row), self.cell_at(column, row)];
                    let span = [z[k] + half, z[k + 1] - half];
                    all.push(Stretch { sides, x_normal: true, at: x[i], span });
                }
                if i + 1 < x.len() {
                    let sides = [self.cell_at(column, row - 1), self.cell_at(column, row)];
                    let span = [x[i] + half, x[i + 1] - half];
                    all.push(Stretch { sides, x_normal: false, at: z[k], span });
                }
            }
        }
        all.retain(|stretch| stretch.sides.iter().any(Option::is_some));
        all
    }

    /// Draws the holes of all walls. All rooms hang together: the inner walls of a grid without loops each have a hole,
    /// and of four rooms in a square one wall may be without.
    fn holes(&mut self, random: &mut Random, stretches: &[Stretch], height: f64) -> Vec<Vec<Hole>> {
        let mut holes = vec![Vec::new(); stretches.len()];
        let inner: Vec<usize> = (0..stretches.len()).filter(|&i| !stretches[i].is_outer()).collect();
        let whole = if inner.len() == 4 && random.chance(0.6) { Some(inner[random.below(4)]) } else { None };
        for &index in inner.iter().filter(|&&index| Some(index) != whole) {
            let hole = match random.weighted(&[0.6, 0.2, 0.2]) {
                0 => hole(random, &stretches[index], [0.12, 0.45], [0.0, 0.0], [0.55, 0.9], height),
                1 => hole(random, &stretches[index], [0.6, 0.9], [0.0, 0.0], [0.7, 0.97], height),
                _ => hole(random, &stretches[index], [0.1, 0.5], [0.2, 0.5], [0.6, 0.9], height),
            };
            holes[index].push(hole);
        }
        if self.openness == Openness::Windows {
            let outer: Vec<usize> = (0..stretches.len()).filter(|&i| stretches[i].is_outer()).collect();
            let of_main: Vec<usize> = outer.iter().copied().filter(|&i| stretches[i].touches(self.main)).collect();
            // The first lights the main room, or one beside it.
            let through =
                stretches.iter().zip(&holes).filter(|(stretch, holes)| stretch.touches(self.main) && !holes.is_empty());
            let beside: Vec<usize> = through.flat_map(|(stretch, _)| stretch.sides.into_iter().flatten()).collect();
            let of_beside: Vec<usize> =
                outer.iter().copied().filter(|&i| beside.iter().any(|&cell| stretches[i].touches(cell))).collect();
            for number in 0..random.whole(1, 3) {
                let among = match number {
                    0 if of_beside.is_empty() || random.chance(0.75) => &of_main,
                    0 => &of_beside,
                    _ => &outer,
                };
                let index = among[random.below(among.len())];
                if !holes[index].is_empty() {
                    continue;
                }
                let hole = match random.weighted(&[0.6, 0.15, 0.25]) {
                    0 => hole(random, &stretches[index], [0.12, 0.6], [0.2, 0.5], [0.6, 0.95], height),
                    1 => hole(random, &stretches[index], [0.03, 0.08], [0.1, 0.5], [0.7, 0.95], height),
                    _ => hole(random, &stretches[index], [0.12, 0.4], [0.0, 0.0], [0.5, 0.9], height),
                };
                holes[index].push(hole);
            }
        }
        for (stretch, holes) in stretches.iter().zip(&holes) {
            self.openings.extend(holes.iter().map(|&hole| stretch.opening(hole)));
        }
        holes
    }

    /// Where stretches meet. A post is thinner than a wall, so that walls cover it.
    fn posts(&mut self, x: &[f64], z: &[f64], stretches: &[Stretch], height: f64) {
        let mut item = Item::new("Posts");
        let near = |a: f64, b: f64| (a - b).abs() < self.wall;
        for (i, &px) in x.iter().enumerate() {
            for (k, &pz) in z.iter().enumerate() {
                let meets = |stretch: &&Stretch| {
                    let (along, across) = if stretch.x_normal { (pz, px) } else { (px, pz) };
                    near(stretch.at, across) && (near(stretch.span[0], along) || near(stretch.span[1], along))
                };
                if stretches.iter().any(|stretch| meets(&stretch)) {
                    let size = DVec3::new(0.97 * self.wall, height + 0.5 * self.wall, 0.97 * self.wall);
                    let at = DVec3::new(px, 0.5 * height, pz);
                    item.add(format!("post {i} {k}"), Form::Box(size), at, WALLS[0]);
                }
            }
        }
        self.items.push(item);
    }

    fn slabs(&mut self, x: &[f64], z: &[f64], height: f64) {
        let ends = |lines: &[f64]| (lines[0], lines[lines.len() - 1]);
        let ((x0, x1), (z0, z1)) = (ends(x), ends(z));
        let out = 0.8 * self.wall;
        let slab = |low: [f64; 2], high: [f64; 2], bottom: f64| {
            let size = DVec3::new(high[0] - low[0], self.wall, high[1] - low[1]);
            let at = DVec3::new(0.5 * (low[0] + high[0]), bottom + 0.5 * self.wall, 0.5 * (low[1] + high[1]));
            (Form::Box(size), at)
        };
        let mut floor = Item::new("Floor");
        let (form, at) = slab([x0 - out, z0 - out], [x1 + out, z1 + out], -self.wall);
        floor.add("slab", form, at, FLOOR);
        let mut ceiling = Item::new("Ceiling");
        if self.cells.iter().all(|cell| cell.covered) {
            let (form, at) = slab([x0 - out, z0 - out], [x1 + out, z1 + out], height);
            ceiling.add("slab", form, at, CEILING);
        } else {
            // From the middle of a wall to the middle of the next: the walls reach into the slabs.
            for (index, cell) in self.cells.iter().enumerate().filter(|(_, cell)| cell.covered) {
                let [i, k] = cell.place;
                let (form, at) = slab([x[i], z[k]], [x[i + 1], z[k + 1]], height);
                ceiling.add(format!("slab {}", index + 1), form, at, CEILING);
            }
        }
        self.items.push(floor);
        if !ceiling.parts.is_empty() {
            self.items.push(ceiling);
        }
    }

    /// The rooms that have an opening to the main room.
    pub fn beside_main(&self) -> Vec<usize> {
        let main = self.openings.iter().filter(|opening| opening.rooms.contains(&self.main));
        main.flat_map(|opening| opening.rooms.iter().copied()).filter(|&room| room != self.main).collect()
    }

    /// Corners of a box around all rooms' air [m].
    pub fn extent(&self) -> (DVec3, DVec3) {
        let low = self.cells.iter().map(|cell| cell.low).fold(DVec3::INFINITY, DVec3::min);
        let high = self.cells.iter().map(|cell| cell.high).fold(DVec3::NEG_INFINITY, DVec3::max);
        (low, high)
    }
}

/// Draws a hole: its width as a share of the stretch, its edges as shares of the height.
#[cfg(test)]
mod tests {
    use super::*;

    /// Rays from the middle of each room of closed buildings all hit something.
    #[test]
    fn closed_buildings_are_closed() {
        let mut closed = 0;
        for index in 0..200 {
            let building = Building::draw(&mut Random::new(7, index));
            if building.openness != Openness::Closed {
                continue;
            }
            closed += 1;
            let mut random = Random::new(8, index);
            for cell in &building.cells {
                let from = 0.5 * (cell.low + cell.high);
                for _ in 0..200 {
                    let along = DVec3::from_array([0; 3].map(|_| random.within(-1.0, 1.0))).normalize();
                    let hit = building.items.iter().map(|item| item.hit(from, along)).fold(f64::INFINITY, f64::min);
                    assert!(hit.is_finite(), "room {index}: a ray along {along} leaves");
                }
            }
        }
        assert!(closed > 50, "{closed}");
    }

    #[test]
    fn buildings_are_of_all_kinds() {
        let all: Vec<Building> = (0..300).map(|index| Building::draw(&mut Random::new(3, index))).collect();
        for openness in [Openness::Closed, Openness::Windows, Openness::OpenFront, Openness::OpenTop] {
            assert!(all.iter().filter(|b| b.openness == openness).count() > 20, "{openness:?}");
        }
        for rooms in 1..=4 {
            assert!(all.iter().filter(|b| b.cells.len() == rooms).count() > 20, "{rooms}");
        }
        for building in &all {
            assert!((0.01..=0.3).contains(&building.wall) || building.wall < 0.3, "{}", building.wall);
            let outside = building.openings.iter().any(|opening| opening.rooms.len() == 1);
            let expected = matches!(building.openness, Openness::Windows | Openness::OpenFront);
            assert_eq!(outside, expected, "{:?}", building.openness);
            let inner = building.openings.iter().filter(|opening| opening.rooms.len() == 2).count();
            assert!(inner + 1 >= building.cells.len(), "rooms without a way between them");
        }
    }
}
