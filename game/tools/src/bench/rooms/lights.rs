//! Lights of a room: points, spots, the sun, the sky and panels that glow.

use super::building::{Building, Cell, Opening, Openness};
use super::furniture::{Furnisher, quarter};
use super::random::Random;
use super::solid::{Form, Item};
use super::surfaces::{self, Surface};
use glam::DVec3;

/// Tries to find a place for a light.
const TRIES: usize = 200;

/// Kind of a light, as scene files have it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// Intensity [W/sr].
    Point,
    /// Half angles of full intensity and of none [degrees]; intensity [W/sr].
    Spot(f64, f64),
    /// Intensity is irradiance [W/m²].
    Sun,
}

/// A light.
#[derive(Clone, Debug, PartialEq)]
pub struct PlacedLight {
    /// Kind.
    pub kind: Kind,
    /// Colour, linear RGB.
    pub color: [f64; 3],
    /// Intensity; unit by kind.
    pub intensity: f64,
    /// Where it is [m].
    pub from: DVec3,
    /// Where it shines to [m].
    pub to: DVec3,
}

/// All light of a room.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Lighting {
    /// One to three lights.
    pub lights: Vec<PlacedLight>,
    /// Radiance of the sky [W/(m² sr)].
    pub sky: [f64; 3],
    /// Materials of panels that glow.
    pub glow: Vec<Surface>,
}

impl Lighting {
    /// Draws all light; panels are added to what stands in the rooms.
    pub fn draw(random: &mut Random, building: &Building, furnisher: &mut Furnisher) -> Self {
        let mut lighting = Self::default();
        let open = building.openness != Openness::Closed;
        if random.chance(0.3) {
            for number in 0..random.whole(1, 3) {
                lighting.panel(random, building, furnisher, number);
            }
        }
        let sun = open && random.chance(0.65);
        if open && random.chance(0.75) {
            let radiance = random.log_within(0.05, 0.6);
            lighting.sky = surfaces::light_color(random).map(|channel| radiance * channel);
        }
        let inside = match (open, sun) {
            (true, true) => random.below(2),
            (true, false) => 1 + random.below(2),
            (false, _) => 1 + random.weighted(&[0.5, 0.3, 0.2]),
        };
        for number in 0..inside {
            // The first one lights the main room, or one beside it.
            let beside = building.beside_main();
            let cell = match number {
                0 if beside.is_empty() || random.chance(0.75) => building.main,
                0 => beside[random.below(beside.len())],
                _ => random.below(building.cells.len()),
            };
            lighting.inside(random, &building.cells[cell], furnisher);
        }
        if sun || lighting.lights.is_empty() {
            lighting.sun(random, building);
        }
        lighting
    }

    /// A point or spot light in a room, clear of all that stands there.
    fn inside(&mut self, random: &mut Random, cell: &Cell, furnisher: &Furnisher) {
        let air = cell.high - cell.low;
        let clear = 0.04 * air.min_element();
        for _ in 0..TRIES {
            let share = DVec3::new(random.within(0.1, 0.9), random.within(0.5, 0.93), random.within(0.1, 0.9));
            let from = cell.low + share * air;
            if furnisher.items.iter().any(|item| item.distance(from) < clear) {
                continue;
            }
            let floor = DVec3::new(random.within(0.0, 1.0), random.within(0.0, 0.4), random.within(0.0, 1.0));
            let kind = match random.chance(0.5) {
                true => Kind::Point,
                false => {
                    let outer = random.within(15.0, 75.0);
                    Kind::Spot(outer * random.within(0.3, 0.95), outer)
                }
            };
            // An irradiance of 1 W/m² or so at half the room's length.
            let reach = 0.5 * air.x.max(air.z).max(air.y);
            let intensity = reach * reach * random.log_within(0.5, 3.0) * if kind == Kind::Point { 1.0 } else { 2.0 };
            let color = surfaces::light_color(random);
            self.lights.push(PlacedLight { kind, color, intensity, from, to: cell.low + floor * air });
            return;
        }
    }

    /// The sun. It shines through an opening of the room that is seen, of another, or where there is none through the
    /// open ceiling.
    fn sun(&mut self, random: &mut Random, building: &Building) {
        let main = &building.cells[building.main];
        let outer: Vec<&Opening> = building.openings.iter().filter(|opening| opening.rooms.len() == 1).collect();
        let near: Vec<&Opening> = outer.iter().copied().filter(|o| o.rooms.contains(&building.main)).collect();
        let among = if near.is_empty() { outer } else { near };
        let (size, middle) = (main.high - main.low, 0.5 * (main.low + main.high));
        let (to, out) = match among.is_empty() {
            true => (DVec3::new(middle.x, main.high.y, middle.z), None),
            false => {
                let opening = among[random.below(among.len())];
                (opening.at, Some((opening.out, opening.along)))
            }
        };
        let towards = match out {
            None => DVec3::new(random.sign() * random.within(0.1, 0.8), 1.0, random.within(-0.8, 0.8)),
            Some((out, along)) => out + along * random.within(-0.8, 0.8) + DVec3::Y * random.within(0.15, 1.2),
        };
        let from = to + towards.normalize() * 2.0 * size.max_element();
        let (color, intensity) = (surfaces::light_color(random), random.log_within(1.5, 8.0));
        self.lights.push(PlacedLight { kind: Kind::Sun, color, intensity, from, to });
    }

    /// A panel below a ceiling, on a wall, or a ball on a pole.
    fn panel(&mut self, random: &mut Random, building: &Building, furnisher: &mut Furnisher, number: usize) {
        let cell = &building.cells[if random.chance(0.6) { building.main } else { random.below(building.cells.len()) }];
        let air = cell.high - cell.low;
        let name = format!("glow {}", number + 1);
        let mut item = Item::new("Glow");
        let area = match random.below(3) {
            0 if cell.covered => {
                let [w, d] = [air.x, air.z].map(|edge| edge * random.log_within(0.05, 0.5));
                let thick = (0.02 * air.y).min(0.05);
                let [x, z] = [(air.x, w), (air.z, d)].map(|(edge, own)| random.within(0.0, edge - own) + 0.5 * own);
                // A third of it is in the ceiling.
                let at = DVec3::new(cell.low.x + x, cell.high.y - thick * 0.17, cell.low.z + z);
                item.add("panel", Form::Box(DVec3::new(w, thick, d)), at, &name);
                furnisher.keep(item);
                w * d
            }
            1 => {
                let radius = air.min_element() * random.log_within(0.02, 0.08);
                let height = air.y * random.within(0.2, 0.7);
                item.add("ball", Form::Sphere(radius), DVec3::Y * (height + 0.9 * radius), &name);
                item.add(
                    "pole",
                    Form::Cylinder(0.15 * radius, height),
                    DVec3::Y * (0.5 * height),
                    super::building::WALLS[1],
                );
                if !furnisher.place_free(random, cell, item) {
                    return;
                }
                4.0 * std::f64::consts::PI * radius * radius
            }
            _ => {
                let side = random.below(4);
                let (length, depth) = if side.is_multiple_of(2) { (air.x, air.z) } else { (air.z, air.x) };
                let (w, h) = (length * random.log_within(0.04, 0.4), air.y * random.log_within(0.04, 0.4));
                let thick = (0.01 * air.min_element()).min(0.05);
                let shift = random.within(-0.5, 0.5) * (length - w);
                let y = random.within(0.55 * h, air.y - 0.55 * h);
                item.turn = quarter(side);
                let middle = 0.5 * (cell.low + cell.high);
                item.at = DVec3::new(middle.x, 0.0, middle.z);
                // Before its turn the wall lies towards −z.
                let at = DVec3::new(shift, y, 0.33 * thick - 0.5 * depth);
                item.add("panel", Form::Box(DVec3::new(w, h, thick)), at, &name);
                let blocked =
                    building.openings.iter().any(|o| item.distance(o.at) < o.half_width + o.heights[1] - o.at.y);
                if blocked {
                    return;
                }
                furnisher.keep(item);
                w * h
            }
        };
        // As much flux as a light, or a tenth of it.
        let reach = 0.5 * air.max_element();
        let radiance = 4.0 * reach * reach / area * random.log_within(0.1, 1.0);
        let color = surfaces::light_color(random).map(|channel| channel * radiance);
        let base = surfaces::diffuse(random, &name);
        self.glow.push(Surface { emissive: color, ..base });
    }

    /// The lights in words.
    pub fn in_words(&self) -> String {
        let count = |what: fn(&Kind) -> bool| self.lights.iter().filter(|light| what(&light.kind)).count();
        let mut words = Vec::new();
        for (number, word) in [
            (count(|kind| *kind == Kind::Point), "point"),
            (count(|kind| matches!(kind, Kind::Spot(..))), "spot"),
            (count(|kind| *kind == Kind::Sun), "sun"),
            (self.glow.len(), "glowing"),
            (usize::from(self.sky != [0.0; 3]), "sky"),
        ] {
            match (number, word) {
                (0, _) => {}
                (1, "sun" | "sky") => words.push(word.to_owned()),
                (number, word) => words.push(format!("{number} {word}")),
            }
        }
        words.join(" + ")
    }
}
