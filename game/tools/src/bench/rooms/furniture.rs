//! Places the pieces of `pieces` in rooms.

use super::building::{Building, Cell};
use super::pieces::{body, boxed, chair, cupboard, heap, partition, pillar, pole, sheet, shelf, sofa, stairs, table};
use super::random::Random;
use super::solid::{Item, turn};
use glam::{DQuat, DVec3};

/// Most solids of a room.
const MOST_PARTS: usize = 350;
/// Tries to find a place for a piece.
const TRIES: usize = 16;

/// Puts pieces into rooms.
pub struct Furnisher<'a> {
    building: &'a Building,
    /// Names of the materials to choose from.
    materials: &'a [String],
    /// The placed pieces.
    pub items: Vec<Item>,
    /// Boxes that stay free, or are taken.
    taken: Vec<(DVec3, DVec3)>,
    parts: usize,
}

/// How a piece finds its place.
#[derive(Clone, Copy)]
enum Stand {
    /// Anywhere on the floor, turned by any angle.
    Free,
    /// With its back to a wall.
    Wall,
}

impl<'a> Furnisher<'a> {
    /// Nothing stands anywhere yet; before doors and windows there will stay nothing.
    pub fn new(building: &'a Building, materials: &'a [String]) -> Self {
        let keep_free = |opening: &super::building::Opening| {
            let reach = 0.6 * opening.half_width + building.wall;
            let half = opening.along * opening.half_width + opening.out.abs() * reach + DVec3::Y * opening.at.y;
            (opening.at - half, opening.at + half)
        };
        let doors = building.openings.iter().filter(|opening| opening.heights[0] == 0.0 && opening.rooms.len() == 2);
        Self { building, materials, items: Vec::new(), taken: doors.map(keep_free).collect(), parts: 0 }
    }

    /// Furnishes a room.
    pub fn furnish(&mut self, random: &mut Random, cell: &Cell) {
        let pieces = match random.weighted(&[0.1, 0.25, 0.4, 0.25]) {
            0 => random.whole(0, 1),
            1 => random.whole(2, 4),
            2 => random.whole(5, 9),
            _ => random.whole(10, 18),
        };
        for _ in 0..pieces {
            if self.parts >= MOST_PARTS {
                return;
            }
            self.piece(random, cell);
        }
    }

    fn material(&self, random: &mut Random) -> String {
        self.materials[random.below(self.materials.len())].clone()
    }

    /// Size of furniture in a room against that in a house [1]: less in a box, and now and then more in a hall.
    fn scale(&self, random: &mut Random, cell: &Cell) -> f64 {
        let size = cell.high - cell.low;
        let fits = (size.y / 2.5).min(size.x.min(size.z) / 3.0);
        let scale = if fits > 1.5 && random.chance(0.5) { random.within(1.0, fits) } else { fits.min(1.0) };
        scale * random.within(0.7, 1.1)
    }

    fn piece(&mut self, random: &mut Random, cell: &Cell) {
        let scale = self.scale(random, cell);
        let material = self.material(random);
        let other = self.material(random);
        let (piece, stand) = match random.weighted(&[1.2, 1.0, 1.2, 0.8, 0.8, 1.0, 1.2, 0.7, 0.8, 0.7, 0.7, 0.7, 0.6]) {
            0 => (table(random, scale, &material, &other, self.materials), Stand::Free),
            1 => (chair(random, scale, &material), Stand::Free),
            2 => (shelf(random, scale, &material, self.materials), Stand::Wall),
            3 => (cupboard(random, scale, &material), Stand::Wall),
            4 => (sofa(random, scale, &material, &other), Stand::Wall),
            5 => (pillar(random, scale, cell, self.building.wall, &material), Stand::Free),
            6 => (body(random, scale, &material), Stand::Free),
            7 => (stairs(random, scale, cell, &material), Stand::Wall),
            8 => (sheet(random, scale, cell, &material), Stand::Free),
            9 => (pole(random, scale, cell, self.building.wall, &material), Stand::Free),
            10 => (heap(random, scale, self.materials), Stand::Free),
            11 => (partition(random, cell, &material), Stand::Free),
            _ => {
                self.beam(random, cell, &material);
                return;
            }
        };
        self.place(random, cell, piece, stand);
    }

    /// Finds a place in a room; a piece that finds none is left out.
    pub(super) fn place_free(&mut self, random: &mut Random, cell: &Cell, piece: Item) -> bool {
        self.place(random, cell, piece, Stand::Free)
    }

    fn place(&mut self, random: &mut Random, cell: &Cell, mut piece: Item, stand: Stand) -> bool {
        let air = cell.high - cell.low;
        for _ in 0..TRIES {
            piece.turn = match stand {
                Stand::Free if random.chance(0.3) => quarter(random.below(4)),
                Stand::Free => quarter(random.below(4)) * turn(DVec3::Y, random.within(-0.4, 0.4)),
                Stand::Wall => quarter(random.below(4)),
            };
            piece.at = DVec3::ZERO;
            let (low, high) = piece.bounds();
            let gap = 0.01 * air.min_element();
            let room = [
                (cell.low.x + gap - low.x, cell.high.x - gap - high.x),
                (cell.low.z + gap - low.z, cell.high.z - gap - high.z),
            ];
            if room.iter().any(|(from, to)| from > to) {
                continue;
            }
            let [mut x, mut z] = room.map(|(from, to)| random.within(from, to));
            if let Stand::Wall = stand {
                // The back faces the wall that −z points to.
                let back = piece.turn * DVec3::NEG_Z;
                let close = random.within(0.0, 1.5) * gap;
                match [back.x > 0.5, back.x < -0.5, back.z > 0.5] {
                    [true, ..] => x = room[0].1 - close.min(room[0].1 - room[0].0),
                    [_, true, _] => x = room[0].0 + close.min(room[0].1 - room[0].0),
                    [.., true] => z = room[1].1 - close.min(room[1].1 - room[1].0),
                    _ => z = room[1].0 + close.min(room[1].1 - room[1].0),
                }
            }
            piece.at = DVec3::new(x, 0.0, z);
            let (low, high) = piece.bounds();
            let free = |(l, h): &(DVec3, DVec3)| low.cmpge(*h).any() || high.cmple(*l).any();
            if self.taken.iter().all(free) {
                self.taken.push((low, high));
                self.keep(piece);
                return true;
            }
        }
        false
    }

    /// Adds an item where it is, under a name with a number.
    pub(super) fn keep(&mut self, mut item: Item) {
        let number = 1 + self.items.iter().filter(|other| other.name.starts_with(&item.name)).count();
        item.name = format!("{} {number}", item.name);
        self.parts += item.parts.len();
        self.items.push(item);
    }

    /// A beam below the ceiling from wall to wall.
    fn beam(&mut self, random: &mut Random, cell: &Cell, material: &str) {
        let air = cell.high - cell.low;
        let (height, width) = (air.y * random.within(0.03, 0.12), air.min_element() * random.within(0.03, 0.12));
        let mut item = Item::new("Beam");
        let into = 0.3 * self.building.wall;
        let middle = 0.5 * (cell.low + cell.high);
        let lift = if cell.covered { into } else { -height };
        let y = cell.high.y + lift - 0.5 * height;
        if random.chance(0.5) {
            let z = random.within(cell.low.z + width, cell.high.z - width);
            item.add("beam", boxed(air.x + 2.0 * into, height, width), DVec3::new(middle.x, y, z), material);
        } else {
            let x = random.within(cell.low.x + width, cell.high.x - width);
            item.add("beam", boxed(width, height, air.z + 2.0 * into), DVec3::new(x, y, middle.z), material);
        }
        let (low, high) = item.bounds();
        if self.taken.iter().all(|(l, h)| low.cmpge(*h).any() || high.cmple(*l).any()) {
            self.taken.push((low, high));
            self.keep(item);
        }
    }
}

/// So many quarter turns about y.
pub fn quarter(number: usize) -> DQuat {
    let half = 0.5f64.sqrt();
    let [y, w] = [[0.0, 1.0], [half, half], [1.0, 0.0], [half, -half]][number % 4];
    DQuat::from_xyzw(0.0, y, 0.0, w)
}
