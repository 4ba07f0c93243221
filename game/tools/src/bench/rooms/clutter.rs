//! What models from elsewhere have and furniture has not: piles of hundreds of small things, full shelves, slats and bars
//! before windows, and walls with boards close before them. Its parts may reach into each other.

use super::building::{Building, Cell, Opening};
use super::pieces::boxed;
use super::random::Random;
use super::solid::{Form, Item};
use glam::{DQuat, DVec3};

/// Of so many rooms one is cluttered.
const EVERY: u64 = 4;
/// Room numbers are given to other streams than those of the rooms themselves, which stay as they are without it.
const STREAM: u64 = 0x636c_7574;

/// The clutter of a room, if it is one that has some.
pub fn draw(seed: u64, index: u64, building: &Building, materials: &[String]) -> Vec<Item> {
    if index % EVERY != EVERY - 1 {
        return Vec::new();
    }
    let random = &mut Random::new(seed ^ STREAM, index);
    let cell = &building.cells[building.main];
    let mut items: Vec<Item> = (0..random.whole(1, 3)).map(|number| pile(random, cell, materials, number)).collect();
    if random.chance(0.6) {
        items.push(books(random, cell, materials));
    }
    if random.chance(0.5) {
        items.push(boards(random, cell, building.wall, materials));
    }
    let outer = building.openings.iter().filter(|opening| opening.rooms.len() == 1);
    for (number, opening) in outer.enumerate() {
        let name = format!("Window {}", number + 1);
        match random.below(3) {
            0 => items.push(frame(random, name, opening, building.wall, materials)),
            1 => items.push(slats(random, name, opening, building.wall, materials)),
            _ => {}
        }
    }
    items
}

fn any<'a>(random: &mut Random, materials: &'a [String]) -> &'a str {
    &materials[random.below(materials.len())]
}

/// A rotation about an axis of any direction. Of numbers that IEEE 754 rounds exactly.
fn tumbled(random: &mut Random) -> DQuat {
    let parts = [0; 4].map(|_| random.within(-1.0, 1.0));
    let turn = DQuat::from_array(parts);
    if turn.length_squared() < 0.01 { DQuat::IDENTITY } else { turn.normalize() }
}

/// Things that lie on each other in a part of the room.
fn pile(random: &mut Random, cell: &Cell, materials: &[String], number: usize) -> Item {
    let mut item = Item::new(format!("Pile {}", number + 1));
    let air = cell.high - cell.low;
    let size = air * DVec3::new(random.within(0.2, 0.5), random.within(0.1, 0.35), random.within(0.2, 0.5));
    let low = cell.low + (air - size) * DVec3::new(random.unit(), 0.0, random.unit());
    let unit = air.min_element();
    for number in 0..random.whole(60, 300) {
        let edges = [0; 3].map(|_| unit * random.log_within(0.006, 0.08));
        let form = match random.below(4) {
            0 => Form::Cylinder(0.5 * edges[0], edges[1]),
            1 => Form::Sphere(0.5 * edges[0]),
            _ => boxed(edges[0], edges[1], edges[2]),
        };
        let reach = DVec3::splat(form.half().length()).min(0.4 * size);
        let share = DVec3::from_array([0; 3].map(|_| random.unit()));
        let at = low + reach + (size - 2.0 * reach) * share * DVec3::new(1.0, share.y, 1.0);
        item.add_turned(format!("thing {}", number + 1), form, at, tumbled(random), any(random, materials));
    }
    item
}

/// Rows of upright things on boards, a few millimetres from each other, along a wall.
fn books(random: &mut Random, cell: &Cell, materials: &[String]) -> Item {
    let mut item = Item::new("Books");
    let air = cell.high - cell.low;
    let unit = air.y / 2.5;
    let (deep, thick) = (unit * random.within(0.2, 0.35), unit * random.within(0.015, 0.03));
    let rows = random.whole(2, 5);
    let step = 0.85 * air.y / rows as f64;
    let (from, to) = (cell.low.z + 0.1 * air.z, cell.high.z - 0.1 * air.z);
    let to = to.min(from + 4.0 * unit);
    let board = any(random, materials);
    for row in 0..rows {
        let y = 0.05 * air.y + step * row as f64;
        let middle = DVec3::new(cell.low.x + 0.5 * deep, y, 0.5 * (from + to));
        item.add(format!("board {}", row + 1), boxed(deep, thick, to - from), middle, board);
        let (mut z, mut number) = (from, 0);
        while z < to - 0.06 * unit && number < 80 {
            let (wide, high) = (unit * random.within(0.012, 0.06), (step - 2.0 * thick) * random.within(0.5, 0.95));
            let into = deep * random.within(0.6, 0.95);
            let at = DVec3::new(cell.low.x + 0.5 * into, y + 0.5 * (thick + high), z + 0.5 * wide);
            item.add(format!("book {} {number}", row + 1), boxed(into, high, wide), at, any(random, materials));
            z += wide + unit * random.log_within(0.001, 0.03);
            number += 1;
        }
    }
    item
}

/// Boards close before a wall, with gaps between them: most of what lies behind sees no light.
fn boards(random: &mut Random, cell: &Cell, wall: f64, materials: &[String]) -> Item {
    let mut item = Item::new("Boards");
    let air = cell.high - cell.low;
    let (gap, thick) = (wall * random.log_within(0.05, 0.5), air.y * random.within(0.003, 0.01));
    let count = random.whole(3, 12);
    let wide = 0.9 * air.x / count as f64;
    let material = any(random, materials);
    for number in 0..count {
        let x = cell.low.x + 0.05 * air.x + wide * (number as f64 + 0.5);
        let at = DVec3::new(x, 0.4 * air.y, cell.high.z - gap - 0.5 * thick);
        item.add(format!("board {}", number + 1), boxed(wide * 0.96, 0.7 * air.y, thick), at, material);
    }
    item
}

/// Bars in an opening.
fn frame(random: &mut Random, name: String, opening: &Opening, wall: f64, materials: &[String]) -> Item {
    let mut item = Item::new(name);
    let high = opening.heights[1] - opening.heights[0];
    let thick = (0.5 * wall).min(0.04 * high);
    let across = opening.out.abs() * thick;
    let material = any(random, materials);
    let bars = random.whole(0, 3);
    for bar in 0..=bars + 1 {
        let share = 2.0 * bar as f64 / (bars + 1) as f64 - 1.0;
        let size = opening.along * thick + DVec3::Y * high + across;
        let at = opening.at + opening.along * (share * (opening.half_width - 0.5 * thick));
        item.add(format!("upright {}", bar + 1), Form::Box(size), at, material);
    }
    for (bar, share) in [-1.0, 1.0, random.within(-0.5, 0.5)].into_iter().enumerate() {
        let size = opening.along * (2.0 * opening.half_width) + DVec3::Y * thick + 0.9 * across;
        let at = opening.at + DVec3::Y * (share * 0.5 * (high - thick));
        item.add(format!("crossbar {}", bar + 1), Form::Box(size), at, material);
    }
    item
}

/// Inclined slats before an opening, inside.
fn slats(random: &mut Random, name: String, opening: &Opening, wall: f64, materials: &[String]) -> Item {
    let mut item = Item::new(name);
    let high = opening.heights[1] - opening.heights[0];
    let count = random.whole(8, 40);
    let step = high / count as f64;
    let tilt = random.within(0.1, 0.9) * random.sign();
    // A turn about the direction along the wall by the half angle tangent, of square roots alone.
    let turn = DQuat::from_vec4((opening.along * tilt).extend(1.0)).normalize();
    let inside = opening.at - opening.out * (0.5 * wall + 0.7 * step);
    let material = any(random, materials);
    for number in 0..count {
        let size =
            opening.along * (2.0 * opening.half_width) + DVec3::Y * (0.04 * step) + opening.out.abs() * (0.9 * step);
        let at = inside + DVec3::Y * (step * (number as f64 + 0.5) - 0.5 * high);
        item.add_turned(format!("slat {}", number + 1), Form::Box(size), at, turn, material);
    }
    item
}
