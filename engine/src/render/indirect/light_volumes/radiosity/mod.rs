//! Radiosity of patches: light of all bounces, gathered along links that rays find. In come surfels and their patches, the
//! lights and the scene as rays meet it; out goes the irradiance of each patch, for the final gather and what the sweep sends
//! out.
//!
//! ```text
//! surfels ── links (rays, where things moved) ─┬─ first bounce (shadow rays) ── solve ─┬─ light of patches ── gather
//!                                               └──────── further bounces ──────┘      └─ light of surfels ── sweep
//! ```
//! A surfel's links are Monte Carlo form factors: its irradiance is the mean of what the patches at their ends send back. The
//! weights of the links are at most one together, so that no bounce gains light, without any calibration; and where only
//! lights change the links stay as they are, so that all bounces are sums over what is known.

mod change;
mod first_bounce;
mod links;
mod solve;

#[cfg(test)]
pub(crate) use self::{first_bounce::FirstBounceUniform, links::LinksUniform};

use crate::graph::{Buffer, Graph, Handle};
use crate::render::frame::{Frame, Kept};
use crate::render::indirect::light_volumes::sweep::haze_cells::HazeCells;
use crate::world::{Bounces, Clpv, Quality};
use glam::Vec3;

/// Light of all bounces at the scene's surfaces.
#[derive(Clone, Copy)]
pub(super) struct Radiosity {
    /// Irradiance of the patches [W/m²], a vector each.
    pub patches: Handle<Buffer>,
    /// The same of the surfels.
    pub surfels: Handle<Buffer>,
    /// How that of the patches changed since the frame before, where frames are averaged.
    pub change: Option<Handle<Buffer>>,
}

/// Largest share of the light that bounces beyond those computed may have, where a series stands for them.
const REST: f32 = 0.05;
/// Most bounces of light that converges; the series takes over from there.
const MOST_BOUNCES: u32 = 16;

/// Bytes of a storage binding that every device has.
const LARGEST_BINDING: u64 = 128 << 20;

/// How many bounces are computed, and whether a series stands for the rest.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct BounceCount {
    computed: u32,
    has_rest: bool,
}

impl BounceCount {
    /// Light that visible surfaces reflect has arrived there by one bounce already: what arrives at the surfaces that they
    /// see has one less.
    fn new(settings: &Clpv, mean_albedo: Vec3) -> Self {
        match settings.bounces {
            Bounces::Count(count) => {
                Self { computed: count.saturating_sub(1).min(super::MAX_BOUNCES), has_rest: false }
            }
            Bounces::Converged => {
                let albedo = mean_albedo.max_element().clamp(0.01, 0.99);
                let bounces = (REST.ln() / albedo.ln()).ceil() as u32;
                Self { computed: bounces.clamp(3, MOST_BOUNCES), has_rest: true }
            }
        }
    }
}

/// Name of the pass that finds the links.
const LINKS: &str = "surfel links";
/// Name of the pass that computes the first bounce.
const FIRST_BOUNCE: &str = "first bounce";
/// Name of the pass that computes the others.
const RADIOSITY: &str = "radiosity";

/// Parts that the rays of a surfel are cast in, in turns where objects move.
const PARTS: u32 = 4;
/// Of the random numbers of rays.
const SEED: u32 = 0x7f4a_7c15;

/// Rays of the surfels in a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Rays {
    /// Of a surfel: a power of two, so that their directions are evenly spread.
    count: u32,
    /// The part of them that is cast in this frame, where the others are known; none: all.
    part: Option<u32>,
    /// Of their random numbers.
    seed: u32,
}

/// The surfels that cast rays in a frame: every so manieth, from one on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Turn {
    part: u32,
    parts: u32,
}

impl Turn {
    /// All of them.
    const ALL: Self = Self { part: 0, parts: 1 };

    /// As the settings have it, where the frame before left the light of all of them and nothing changes by much.
    fn new(frame: &Frame, settings: &Clpv) -> Self {
        let parts = frame.settings.update.frames();
        let has_all = !is_thinned(frame) && frame.kept == Some(links_of(frame, count(frame, settings)));
        let is_slow = frame.history.is_changing() && !frame.history.has_light_jumped(frame.bounds.size().length());
        match frame.number().filter(|_| parts > 1 && has_all && is_slow) {
            Some(number) => Self { part: number % parts, parts },
            None => Self::ALL,
        }
    }

    fn is_all(self) -> bool {
        self.parts == 1
    }

    /// How many of so many surfels.
    fn count(self, all: u32) -> u32 {
        (all + self.parts - 1).saturating_sub(self.part) / self.parts
    }
}

/// Whether surfels have fewer links in a frame: where they are others than in the frame before, and so are the links. The mean
/// over frames makes up for it.
fn is_thinned(frame: &Frame) -> bool {
    frame.number().is_some_and(|number| number > 0) && frame.surfels.is_replaced()
}

/// The links that a frame leaves, if the next one may go on with them.
pub(in crate::render) fn kept(frame: &Frame) -> Option<Kept> {
    let clpv = frame.scene.clpv.as_ref().filter(|_| !is_thinned(frame))?;
    Some(links_of(frame, count(frame, &clpv.settings)))
}

fn links_of(frame: &Frame, count: u32) -> Kept {
    Kept { passes: &[LINKS, FIRST_BOUNCE, RADIOSITY], state: [frame.surfels.layout(), u64::from(count)] }
}

/// Links of a surfel: a power of two of them, as many as the quality asks for, and as fit a storage binding.
fn count(frame: &Frame, settings: &Clpv) -> u32 {
    let wanted: u32 = match settings.quality {
        Quality::Low => 8,
        Quality::Medium | Quality::High | Quality::Ultra => 16,
    };
    let fits = |links: u32| links::bytes_of_surfel(links) * u64::from(frame.surfels.count()) <= LARGEST_BINDING;
    let halves = std::iter::successors(Some(wanted), |links| Some(links / 2));
    halves.take_while(|links| *links > 0).find(|links| fits(*links)).unwrap_or(1)
}

impl Rays {
    /// While objects move and frames are averaged, a quarter of all is cast again in each frame, in the same directions as
    /// before: where nothing moves nothing changes. See also [`is_thinned`].
    fn new(frame: &Frame, settings: &Clpv, turn: Turn) -> Self {
        let count = count(frame, settings);
        if let Some(number) = frame.number().filter(|_| is_thinned(frame)) {
            return Self { count: (count / PARTS).max(1), part: None, seed: number.wrapping_mul(0x85eb_ca6b) };
        }
        let has_others = frame.kept == Some(links_of(frame, count));
        let number = frame.number().filter(|_| frame.surfels.is_moving() && has_others && count >= PARTS);
        Self { count, part: number.map(|number| number / turn.parts % PARTS), seed: SEED }
    }

    /// Rays that a thread casts one after the other, those of a part: lavapipe ends all loops of a thread after 65,535 turns
    /// together, without a word, and a ray takes some thousand of them in a large scene.
    fn at_once(self) -> u32 {
        (self.count / PARTS).max(1)
    }

    /// Parts that there are.
    fn parts(self) -> u32 {
        self.count / self.at_once()
    }

    /// Those that are cast in this frame.
    fn cast(self) -> std::ops::Range<u32> {
        match self.part {
            Some(part) => part * self.at_once()..(part + 1) * self.at_once(),
            None => 0..self.count,
        }
    }
}

/// Declares all passes. None if there is but one bounce, or the scene is not ready for rays: the reason is in the report then.
/// `surfels` are those in world space, `lamps` light straight from the lights where media scatter it.
pub(super) fn declare<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    settings: &Clpv,
    surfels: Handle<Buffer>,
    lamps: Option<HazeCells>,
) -> Option<Radiosity> {
    let bounces = BounceCount::new(settings, frame.surfels.mean_albedo());
    if let Some(why) = frame.refused_rays {
        graph.skip("radiosity", why);
        return None;
    }
    if bounces.computed == 0 {
        graph.skip("radiosity", "one bounce is asked for");
        return None;
    }
    let turn = Turn::new(frame, settings);
    if !turn.is_all() {
        let why = format!("1 of {} surfels has its turn: light is brought up to date over as many frames", turn.parts);
        graph.skip("first bounce, other surfels", why);
    }
    let rays = Rays::new(frame, settings, turn);
    // Where bounces are counted each link is one.
    let near = if bounces.has_rest { frame.surfels.patch_size() } else { 0.0 };
    let links = links::declare(graph, frame, surfels, (rays, turn), near);
    let reflected = first_bounce::declare(graph, frame, links, (rays, turn), lamps);
    let solved = solve::declare(graph, frame, solve::Subject { surfels, links, reflected, rays, turn, bounces });
    let change = change::declare(graph, frame, surfels, solved.patches);
    Some(Radiosity { change, ..solved })
}
