//! A random room: a scene as a function of seed and index.

use super::building::{Building, CEILING, FLOOR, Openness, WALLS};
use super::clutter;
use super::furniture::Furnisher;
use super::lights::Lighting;
use super::pieces::SHEET;
use super::random::Random;
use super::solid::Item;
use super::surfaces::{self, Surface};
use super::viewpoint::Viewpoint;
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// How a room stands against the axes of the world, and with it against the cells of the light volumes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Orientation {
    /// Along the axes.
    Aligned,
    /// Turned about the vertical.
    OneTurn,
    /// Turned about the vertical and about a horizontal axis.
    TwoTurns,
}

/// A room in words and numbers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RoomFacts {
    /// Number of the room in its seed.
    pub index: u64,
    /// The room in one line.
    pub description: String,
    /// Edges of the air of the room that is seen [m].
    pub size: [f64; 3],
    /// Rooms of the building.
    pub rooms: usize,
    /// Thickness of the walls [m].
    pub wall: f64,
    /// `closed`, `windows`, `open front` or `open top`.
    pub openness: String,
    /// How it is turned.
    pub orientation: Orientation,
    /// Solids.
    pub solids: usize,
    /// Whether hundreds of small things lie there, see `clutter`.
    #[serde(default)]
    pub cluttered: bool,
    /// Lights in words.
    pub lights: String,
    /// Whether something glows.
    pub glows: bool,
    /// Whether a material is glossy.
    pub glossy: bool,
}

/// A random room.
#[derive(Clone, Debug)]
pub struct Room {
    /// Properties of the room.
    pub facts: RoomFacts,
    /// Materials.
    pub materials: Vec<Surface>,
    /// Building and furniture.
    pub items: Vec<Item>,
    /// All light.
    pub lighting: Lighting,
    /// The camera.
    pub viewpoint: Viewpoint,
    /// Angles about x, y and z [degrees], as scene files have them.
    pub rotation: [f64; 3],
    /// Where its origin stands in the world [m].
    pub origin: DVec3,
}

impl Openness {
    /// In words.
    pub fn in_words(self) -> &'static str {
        match self {
            Self::Closed => "closed",
            Self::Windows => "windows",
            Self::OpenFront => "open front",
            Self::OpenTop => "open top",
        }
    }
}

impl Orientation {
    /// In words.
    pub fn in_words(self) -> &'static str {
        match self {
            Self::Aligned => "aligned",
            Self::OneTurn => "one turn",
            Self::TwoTurns => "two turns",
        }
    }
}

impl Room {
    /// The room of that number.
    pub fn draw(seed: u64, index: u64) -> Self {
        let random = &mut Random::new(seed, index);
        let building = Building::draw(random);
        let (orientation, rotation) = turned(random, index);
        let (mut materials, names) = palette(random);
        let mut furnisher = Furnisher::new(&building, &names);
        for cell in &building.cells {
            furnisher.furnish(random, cell);
        }
        let clutter = clutter::draw(seed, index, &building, &names);
        let cluttered = !clutter.is_empty();
        furnisher.items.extend(clutter);
        let lighting = Lighting::draw(random, &building, &mut furnisher);
        let furniture = furnisher.items;
        let viewpoint = Viewpoint::find(random, &building, &furniture);
        materials.extend(lighting.glow.iter().cloned());
        let items: Vec<Item> = building.items.iter().chain(&furniture).cloned().collect();
        let used =
            |surface: &Surface| items.iter().flat_map(|item| &item.parts).any(|part| part.material == surface.name);
        materials.retain(used);
        let cell = &building.cells[building.main];
        let size = (cell.high - cell.low).to_array();
        let solids = items.iter().map(|item| item.parts.len()).sum();
        let mut facts = RoomFacts {
            index,
            description: String::new(),
            size,
            rooms: building.cells.len(),
            wall: building.wall,
            openness: building.openness.in_words().to_owned(),
            orientation,
            solids,
            cluttered,
            lights: lighting.in_words(),
            glows: !lighting.glow.is_empty(),
            glossy: materials.iter().any(Surface::is_glossy),
        };
        facts.description = describe(&facts, furniture.len());
        let (low, high) = building.extent();
        let origin = (high - low) * DVec3::from_array([0; 3].map(|_| random.within(-0.5, 0.5)));
        Self { facts, materials, items, lighting, viewpoint, rotation, origin }
    }
}

/// Each third of the rooms stands otherwise: by turns, so that few rooms have all kinds too.
fn turned(random: &mut Random, index: u64) -> (Orientation, [f64; 3]) {
    let mut heading = || random.within(4.0, 86.0) + 90.0 * random.below(4) as f64;
    match index % 3 {
        0 => (Orientation::Aligned, [0.0; 3]),
        1 => (Orientation::OneTurn, [0.0, heading(), 0.0]),
        _ => {
            let heading = heading();
            (Orientation::TwoTurns, [random.sign() * random.within(8.0, 60.0), heading, 0.0])
        }
    }
}

/// The materials, and the names of those that furniture takes.
fn palette(random: &mut Random) -> (Vec<Surface>, Vec<String>) {
    let mut materials = Vec::new();
    for name in WALLS.iter().chain([&CEILING]) {
        materials.push(surfaces::diffuse(random, name));
    }
    materials.push(match random.chance(0.6) {
        true => surfaces::diffuse(random, FLOOR),
        false => surfaces::any(random, FLOOR),
    });
    materials.push(Surface { double_sided: true, ..surfaces::diffuse(random, SHEET) });
    let names: Vec<String> = (1..=6).map(|number| format!("material {number}")).collect();
    materials.extend(names.iter().map(|name| surfaces::any(random, name)));
    (materials, names)
}

fn describe(facts: &RoomFacts, pieces: usize) -> String {
    let [x, y, z] = facts.size;
    let number = |count: usize, what: &str| format!("{count} {what}{}", if count == 1 { "" } else { "s" });
    format!(
        "{x:.1} × {y:.1} × {z:.1} m, {}, walls {:.0} cm, {}, {}, {} of furniture, {} in all, {}{}{}",
        number(facts.rooms, "room"),
        100.0 * facts.wall,
        facts.openness,
        facts.orientation.in_words(),
        number(pieces, "piece"),
        number(facts.solids, "solid"),
        facts.lights,
        if facts.glossy { ", glossy" } else { "" },
        if facts.cluttered { ", cluttered" } else { "" },
    )
}
