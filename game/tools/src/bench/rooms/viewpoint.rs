//! Where the camera stands: inside a room, clear of all, with a fair part of the room before it.

use super::building::Building;
use super::random::Random;
use super::solid::Item;
use glam::DVec3;

/// Fields of view [degrees] with the tangents of their halves.
const FIELDS: [(f64, f64); 4] =
    [(50.0, 0.466_307_658), (60.0, 0.577_350_269), (70.0, 0.700_207_538), (85.0, 0.916_331_174)];
/// Places that are looked at before one is taken.
const TRIES: usize = 160;
/// Good places of which the best is taken: always the very best would be the same corner each time.
const GOOD: usize = 6;
/// Rays along each edge of the image.
const RAYS: usize = 11;

/// A camera.
#[derive(Clone, Debug, PartialEq)]
pub struct Viewpoint {
    /// Where it is [m].
    pub from: DVec3,
    /// The point that it looks at [m].
    pub to: DVec3,
    /// Vertical field of view [degrees].
    pub field: f64,
    /// Near plane [m].
    pub near: f64,
}

/// The view of a camera.
struct Sight {
    /// Share of rays that end nearer than a tenth of the room's diagonal.
    near: f64,
    /// Share of rays that hit nothing.
    nothing: f64,
    /// Mean distance over the room's diagonal, each at most 1.
    mean: f64,
    /// Different items hit.
    items: usize,
}

impl Viewpoint {
    /// Finds a camera in the main room.
    pub fn find(random: &mut Random, building: &Building, furniture: &[Item]) -> Self {
        let cell = &building.cells[building.main];
        let air = cell.high - cell.low;
        let (diagonal, least) = (air.length(), air.min_element());
        let (field, tangent) = FIELDS[random.below(FIELDS.len())];
        let items: Vec<&Item> = building.items.iter().chain(furniture).collect();
        let mut best: Option<(f64, Self)> = None;
        let mut good = 0;
        for _ in 0..TRIES {
            let mut point = |low: [f64; 3], high: [f64; 3]| {
                let share = DVec3::from_array([0, 1, 2].map(|axis| random.within(low[axis], high[axis])));
                cell.low + share * air
            };
            let from = point([0.06, 0.25, 0.06], [0.94, 0.8, 0.94]);
            let to = point([0.1, 0.1, 0.1], [0.9, 0.7, 0.9]);
            if (to - from).length() < 0.3 * diagonal || items.iter().any(|item| item.distance(from) < 0.05 * least) {
                continue;
            }
            let sight = look(&items, from, to, tangent, diagonal);
            let is_good = sight.near < 0.12 && sight.nothing < 0.35;
            let score = sight.mean + 0.025 * sight.items.min(14) as f64
                - 2.0 * (sight.near - 0.05).max(0.0)
                - (sight.nothing - 0.2).max(0.0)
                + f64::from(u8::from(is_good));
            if best.as_ref().is_none_or(|(known, _)| score > *known) {
                best = Some((score, Self { from, to, field, near: 0.01 * least }));
            }
            good += usize::from(is_good);
            if good == GOOD {
                break;
            }
        }
        let middle = Self {
            from: cell.low + air * DVec3::new(0.5, 0.6, 0.9),
            to: cell.low + air * DVec3::new(0.5, 0.4, 0.1),
            field,
            near: 0.01 * least,
        };
        best.map_or(middle, |(_, viewpoint)| viewpoint)
    }
}

fn look(items: &[&Item], from: DVec3, to: DVec3, tangent: f64, diagonal: f64) -> Sight {
    let ahead = (to - from).normalize();
    let right = ahead.cross(DVec3::Y).normalize();
    let up = right.cross(ahead);
    let mut sight = Sight { near: 0.0, nothing: 0.0, mean: 0.0, items: 0 };
    let (mut seen, share) = (vec![false; items.len()], 1.0 / (RAYS * RAYS) as f64);
    for ray in 0..RAYS * RAYS {
        let [x, y] = [ray % RAYS, ray / RAYS].map(|i| tangent * (2.0 * (i as f64 + 0.5) / RAYS as f64 - 1.0));
        let along = (ahead + right * x + up * y).normalize();
        let (mut distance, mut first) = (f64::INFINITY, None);
        for (index, item) in items.iter().enumerate() {
            let hit = item.hit(from, along);
            if hit < distance {
                (distance, first) = (hit, Some(index));
            }
        }
        match first {
            Some(index) => seen[index] = true,
            None => sight.nothing += share,
        }
        sight.near += if distance < 0.1 * diagonal { share } else { 0.0 };
        sight.mean += share * (distance / diagonal).min(1.0);
    }
    sight.items = seen.iter().filter(|seen| **seen).count();
    sight
}
