//! Pieces that stand in rooms: pillars, stairs, shelves, furniture with clutter, curved and thin things.
//!
//! A piece stands on y = 0 around the origin and has its back towards −z.

use super::building::Cell;
use super::random::Random;
use super::solid::{Form, Item, turn};
use glam::{DQuat, DVec3};

/// A box of these edges.
pub(super) fn boxed(x: f64, y: f64, z: f64) -> Form {
    Form::Box(DVec3::new(x, y, z))
}

/// Small things on a board from `low` to `high` at the height of `low`.
fn clutter(
    random: &mut Random,
    item: &mut Item,
    scale: f64,
    low: DVec3,
    high: DVec3,
    count: usize,
    materials: &[String],
) {
    let air = high - low;
    for _ in 0..count {
        let edge = scale * random.log_within(0.02, 0.2);
        let edge = edge.min(0.9 * air.y).min(0.4 * air.x).min(0.8 * air.z);
        let (form, turned) = match random.weighted(&[0.5, 0.25, 0.25]) {
            0 => (boxed(edge * random.within(0.2, 1.0), edge, edge * random.within(0.3, 1.0)), true),
            1 => (Form::Sphere(0.5 * edge), false),
            _ => (Form::Cylinder(edge * random.within(0.2, 0.5), edge), false),
        };
        let half = form.half();
        let spread = DVec3::new(0.5 * air.x - half.x, 0.0, 0.5 * air.z - half.z).max(DVec3::ZERO);
        let at = 0.5 * (low + high) + DVec3::new(random.within(-1.0, 1.0), 0.0, random.within(-1.0, 1.0)) * spread;
        let at = DVec3::new(at.x, low.y + half.y, at.z);
        let turn = if turned { turn(DVec3::Y, random.within(-0.2, 0.2)) } else { DQuat::IDENTITY };
        let name = format!("thing {}", item.parts.len() + 1);
        item.add_turned(name, form, at, turn, &materials[random.below(materials.len())]);
    }
}

fn legs(random: &mut Random, item: &mut Item, half: [f64; 2], height: f64, thick: f64, material: &str) {
    let round = random.chance(0.4);
    for (number, (x, z)) in [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)].into_iter().enumerate() {
        let form = if round { Form::Cylinder(0.5 * thick, height) } else { boxed(thick, height, thick) };
        let at = DVec3::new(x * (half[0] - 0.6 * thick), 0.5 * height, z * (half[1] - 0.6 * thick));
        item.add(format!("leg {}", number + 1), form, at, material);
    }
}

pub(super) fn table(random: &mut Random, scale: f64, material: &str, leg: &str, materials: &[String]) -> Item {
    let mut item = Item::new("Table");
    let (w, d) = (scale * random.within(0.7, 2.0), scale * random.within(0.5, 1.0));
    let (h, thick) = (scale * random.within(0.4, 0.8), scale * random.within(0.015, 0.05));
    item.add("top", boxed(w, thick, d), DVec3::new(0.0, h - 0.5 * thick, 0.0), material);
    let leg_thick = scale * random.within(0.03, 0.08);
    legs(random, &mut item, [0.5 * w, 0.5 * d], h - thick, leg_thick, leg);
    let count = random.whole(0, 5);
    let (low, high) = (DVec3::new(-0.5 * w, h, -0.5 * d), DVec3::new(0.5 * w, h + 0.4 * scale, 0.5 * d));
    clutter(random, &mut item, scale, low, high, count, materials);
    item
}

pub(super) fn chair(random: &mut Random, scale: f64, material: &str) -> Item {
    let mut item = Item::new("Chair");
    let (w, h) = (scale * random.within(0.38, 0.55), scale * random.within(0.4, 0.5));
    let thick = scale * random.within(0.015, 0.05);
    item.add("seat", boxed(w, thick, w), DVec3::new(0.0, h - 0.5 * thick, 0.0), material);
    let back = scale * random.within(0.3, 0.6);
    item.add("back", boxed(w, back, thick), DVec3::new(0.0, h + 0.5 * back, 0.5 * (thick - w)), material);
    legs(random, &mut item, [0.5 * w; 2], h - thick, 0.9 * thick.max(0.02 * scale), material);
    item
}

pub(super) fn shelf(random: &mut Random, scale: f64, material: &str, materials: &[String]) -> Item {
    let mut item = Item::new("Shelf");
    let (w, h, d) =
        (scale * random.within(0.6, 1.8), scale * random.within(0.7, 2.1), scale * random.within(0.2, 0.45));
    let thick = scale * random.within(0.012, 0.035);
    for (name, sign) in [("left", -1.0), ("right", 1.0)] {
        item.add(name, boxed(thick, h, d), DVec3::new(sign * 0.5 * (w - thick), 0.5 * h, 0.0), material);
    }
    if random.chance(0.5) {
        let size = boxed(w - 2.0 * thick, h, 0.4 * thick);
        item.add("back", size, DVec3::new(0.0, 0.5 * h, 0.2 * thick - 0.5 * d), material);
    }
    let boards = random.whole(2, 6);
    let step = (h - thick) / boards as f64;
    for number in 0..=boards {
        let y = 0.5 * thick + step * number as f64;
        let (depth, at) = (d - 0.8 * thick, DVec3::new(0.0, y, 0.4 * thick));
        item.add(format!("board {}", number + 1), boxed(w - 2.0 * thick, thick, depth), at, material);
        if number < boards {
            let low = DVec3::new(-0.5 * w + thick, y + 0.5 * thick, -0.5 * d + thick);
            let high = DVec3::new(0.5 * w - thick, y + step - 0.6 * thick, 0.5 * d);
            let count = random.whole(0, 4);
            clutter(random, &mut item, scale, low, high, count, materials);
        }
    }
    item
}

pub(super) fn cupboard(random: &mut Random, scale: f64, material: &str) -> Item {
    let mut item = Item::new("Cupboard");
    let (w, h, d) =
        (scale * random.within(0.5, 1.8), scale * random.within(0.6, 2.1), scale * random.within(0.35, 0.7));
    item.add("body", boxed(w, h, d), DVec3::new(0.0, 0.5 * h, 0.0), material);
    if random.chance(0.5) {
        let (over, thick) = (1.04, scale * random.within(0.01, 0.04));
        item.add("top", boxed(over * w, thick, over * d), DVec3::new(0.0, h + 0.5 * thick, 0.0), material);
    }
    item
}

pub(super) fn sofa(random: &mut Random, scale: f64, material: &str, cushion: &str) -> Item {
    let mut item = Item::new("Sofa");
    let (w, d) = (scale * random.within(0.8, 2.2), scale * random.within(0.7, 1.0));
    let (seat, back, arm) = (scale * random.within(0.3, 0.45), scale * random.within(0.6, 0.95), 0.15 * scale);
    item.add("seat", boxed(w - 2.0 * arm, seat, d), DVec3::new(0.0, 0.5 * seat, 0.0), material);
    item.add(
        "back",
        boxed(w - 2.0 * arm, back - seat, arm),
        DVec3::new(0.0, 0.5 * (seat + back), 0.5 * (arm - d)),
        material,
    );
    for (name, sign) in [("left arm", -1.0), ("right arm", 1.0)] {
        let size = boxed(arm, seat + 0.2 * scale, d);
        item.add(name, size, DVec3::new(sign * 0.5 * (w - arm), 0.5 * seat + 0.1 * scale, 0.0), material);
    }
    if random.chance(0.6) {
        let radius = 0.09 * scale;
        let form = Form::Capsule(radius, 0.25 * scale);
        let at = DVec3::new(w * random.within(-0.2, 0.2), seat + radius, 0.1 * d);
        item.add_turned("cushion", form, at, turn(DVec3::Z, 1.0), cushion);
    }
    item
}

pub(super) fn pillar(random: &mut Random, scale: f64, cell: &Cell, wall: f64, material: &str) -> Item {
    let mut item = Item::new("Pillar");
    let air = cell.high - cell.low;
    let radius = random.log_within(0.05 * scale, 0.06 * air.x.min(air.z) + 0.051 * scale);
    let (low, high) = (-0.3 * wall, if cell.covered { air.y + 0.3 * wall } else { 0.9 * air.y });
    let form = if random.chance(0.5) {
        Form::Cylinder(radius, high - low)
    } else {
        boxed(2.0 * radius, high - low, 2.0 * radius)
    };
    item.add("shaft", form, DVec3::new(0.0, 0.5 * (low + high), 0.0), material);
    if random.chance(0.4) {
        let foot = radius * random.within(0.2, 0.8);
        item.add("foot", boxed(2.6 * radius, foot, 2.6 * radius), DVec3::new(0.0, 0.5 * foot, 0.0), material);
    }
    item
}

pub(super) fn pole(random: &mut Random, scale: f64, cell: &Cell, wall: f64, material: &str) -> Item {
    let mut item = Item::new("Poles");
    let air = cell.high - cell.low;
    let radius = scale * random.log_within(0.005, 0.04);
    let high = if cell.covered { air.y + 0.3 * wall } else { 0.9 * air.y };
    for number in 0..random.whole(1, 6) {
        let at = DVec3::new(number as f64 * 6.0 * radius.max(0.02 * scale), 0.5 * high, 0.0);
        item.add(format!("pole {}", number + 1), Form::Cylinder(radius, high), at, material);
    }
    item
}

/// A single curved or angular body.
pub(super) fn body(random: &mut Random, scale: f64, material: &str) -> Item {
    let mut item = Item::new("Body");
    let r = scale * random.log_within(0.04, 0.5);
    let form = match random.below(7) {
        0 | 1 => Form::Sphere(r),
        2 => Form::Cylinder(r, r * random.within(0.5, 3.0)),
        3 => Form::Cone(r, r * random.within(1.0, 3.0)),
        4 => Form::Torus(r, r * random.within(0.15, 0.45)),
        5 => Form::Capsule(0.6 * r, r * random.within(0.3, 2.0)),
        _ => boxed(r * random.within(0.5, 2.0), r * random.within(0.5, 2.0), r * random.within(0.5, 2.0)),
    };
    item.add("body", form, DVec3::new(0.0, form.half().y, 0.0), material);
    item
}

pub(super) fn stairs(random: &mut Random, scale: f64, cell: &Cell, material: &str) -> Item {
    let mut item = Item::new("Stairs");
    let steps = random.whole(3, 10);
    let (tread, rise, w) =
        (scale * random.within(0.2, 0.32), scale * random.within(0.12, 0.2), scale * random.within(0.5, 1.2));
    let rise = rise.min(0.8 * (cell.high.y - cell.low.y) / steps as f64);
    let open = random.chance(0.35);
    for number in 0..steps {
        let (z, top) = (tread * (0.5 + number as f64), rise * (steps - number) as f64);
        let thick = if open { 0.25 * rise } else { top };
        item.add(
            format!("step {}", number + 1),
            boxed(w, thick, tread),
            DVec3::new(0.0, top - 0.5 * thick, z),
            material,
        );
    }
    item
}

/// A sheet, a few millimetres thick or none at all, that stands, leans or hangs.
pub(super) fn sheet(random: &mut Random, scale: f64, cell: &Cell, material: &str) -> Item {
    let mut item = Item::new("Sheet");
    let (w, h) = (scale * random.within(0.3, 1.8), scale * random.within(0.4, 1.6));
    let thick = random.log_within(0.001, 0.01);
    let lift = if random.chance(0.3) { (cell.high.y - h) * random.within(0.3, 0.95) } else { 0.01 * scale };
    let lean = turn(DVec3::X, if random.chance(0.3) { random.within(-0.3, 0.3) } else { 0.0 });
    let (form, material) = match random.chance(0.35) {
        true => (Form::Sheet(w, h), SHEET),
        false => (boxed(w, h, thick), material),
    };
    item.add_turned("sheet", form, DVec3::new(0.0, lift.max(0.01 * scale) + 0.5 * h, 0.0), lean, material);
    item
}

/// The material of sheets without thickness, which has two sides.
pub const SHEET: &str = "sheet";

/// A heap of small boxes and balls.
pub(super) fn heap(random: &mut Random, scale: f64, materials: &[String]) -> Item {
    let mut item = Item::new("Heap");
    let half = scale * random.within(0.2, 0.6);
    let count = random.whole(5, 20);
    let (low, high) = (DVec3::new(-half, 0.0, -half), DVec3::new(half, scale, half));
    clutter(random, &mut item, scale, low, high, count, materials);
    item
}

/// A low or half wall within a room.
pub(super) fn partition(random: &mut Random, cell: &Cell, material: &str) -> Item {
    let mut item = Item::new("Partition");
    let air = cell.high - cell.low;
    let (w, h) = (air.x.min(air.z) * random.within(0.15, 0.6), air.y * random.within(0.3, 0.95));
    let thick = random.log_within(0.01, 0.15).min(0.1 * air.min_element());
    item.add("wall", boxed(w, h, thick), DVec3::new(0.0, 0.5 * h, 0.0), material);
    item
}
