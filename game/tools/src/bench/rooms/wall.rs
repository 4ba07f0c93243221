//! Walls: stretches of grid lines between posts, and the openings in them.

use super::building::Opening;
use super::random::Random;
use super::solid::{Form, Item};
use glam::DVec3;

/// A stretch of a grid line between two of its posts.
pub(super) struct Stretch {
    /// The room on the lower and on the upper side.
    pub(super) sides: [Option<usize>; 2],
    /// Whether its normal is along x, or else along z.
    pub(super) x_normal: bool,
    /// Middle of the wall along its normal [m].
    pub(super) at: f64,
    /// From post to post, without these [m].
    pub(super) span: [f64; 2],
}

/// A hole by what it is along the stretch.
#[derive(Clone, Copy)]
pub(super) struct Hole {
    pub(super) from: f64,
    pub(super) to: f64,
    pub(super) low: f64,
    pub(super) high: f64,
}

/// A hole of random width and height, in shares of the stretch and of the room's height.
pub(super) fn hole(
    random: &mut Random,
    stretch: &Stretch,
    width: [f64; 2],
    low: [f64; 2],
    high: [f64; 2],
    height: f64,
) -> Hole {
    let [from, to] = stretch.span;
    let length = to - from;
    let width = length * random.within(width[0], width[1]);
    let margin = 0.04 * length;
    let from = random.within(from + margin, (to - margin - width).max(from + margin));
    let (low, high) = (height * random.within(low[0], low[1]), height * random.within(high[0], high[1]));
    Hole { from, to: from + width, low, high }
}

impl Stretch {
    pub(super) fn is_outer(&self) -> bool {
        self.sides.iter().any(Option::is_none)
    }

    pub(super) fn touches(&self, cell: usize) -> bool {
        self.sides.contains(&Some(cell))
    }

    pub(super) fn axes(&self) -> (DVec3, DVec3) {
        if self.x_normal { (DVec3::Z, DVec3::X) } else { (DVec3::X, DVec3::Z) }
    }

    pub(super) fn opening(&self, hole: Hole) -> Opening {
        let (along, across) = self.axes();
        let out = if self.sides[0].is_none() { -across } else { across };
        let at = along * (0.5 * (hole.from + hole.to)) + across * self.at + DVec3::Y * (0.5 * (hole.low + hole.high));
        let rooms = self.sides.iter().flatten().copied().collect();
        Opening { at, half_width: 0.5 * (hole.to - hole.from), heights: [hole.low, hole.high], along, out, rooms }
    }

    /// The wall: piers from floor to ceiling beside its hole, and what is above and below that.
    pub(super) fn build(&self, name: String, holes: &[Hole], wall: f64, height: f64, material: &str) -> Item {
        let mut item = Item::new(name);
        let (along, across) = self.axes();
        let mut piece = |name: &str, [from, to]: [f64; 2], [low, high]: [f64; 2], thickness: f64| {
            let size = along * (to - from) + across * thickness + DVec3::Y * (high - low);
            let at = along * (0.5 * (from + to)) + across * self.at + DVec3::Y * (0.5 * (low + high));
            item.add(name, Form::Box(size), at, material);
        };
        // Into the posts, and into floor and ceiling.
        let (start, end) = (self.span[0] - 0.25 * wall, self.span[1] + 0.25 * wall);
        let whole = [-0.3 * wall, height + 0.3 * wall];
        match holes.first() {
            None => piece("whole", [start, end], whole, wall),
            Some(hole) => {
                piece("left", [start, hole.from], whole, wall);
                piece("right", [hole.to, end], whole, wall);
                let into = (0.25 * wall).min(0.5 * (hole.from - start)).min(0.5 * (end - hole.to));
                let across = [hole.from - into, hole.to + into];
                piece("above", across, [hole.high, whole[1]], 0.985 * wall);
                if hole.low > 0.0 {
                    piece("below", across, [whole[0], hole.low], 0.985 * wall);
                }
            }
        }
        item
    }
}
