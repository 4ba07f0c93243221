//! Quiet images: frames with other random numbers and shifted pixel grids, averaged until what their mean is still off by
//! is estimated to be below a bound.

mod goal;
mod halves;
mod outcome;
#[cfg(test)]
mod tests;

pub use goal::Goal;
pub use halves::Estimate;
pub use outcome::{End, Outcome, Tally};

use crate::{capture, jitter};
use anyhow::Result;
use halves::Halves;
use lightwell::measure::Image;
use lightwell::render::RenderSettings;
use lightwell_runtime::session::Session;
use std::time::{Duration, Instant};

/// Each image is filtered for a mean of this many times the images that exist with it. The filter narrows with the number of
/// images, so the mean gets sharper as it gets less noisy. Later images outweigh earlier ones, whose filter was wider.
const FILTER_AHEAD: u32 = 2;

/// How far an average is.
#[derive(Clone, Copy, Debug)]
pub struct Progress {
    /// Images that are done.
    pub images: u32,
    /// Images that it will take, as far as is known.
    pub expected: u32,
    /// The last estimate of the error, if there is one yet.
    pub estimate: Option<Estimate>,
}

/// Draws the scene as it stands until the goal is reached. The image is the light that a screen would send out, linear
/// and 0..1. `told` hears of every pair of frames.
///
/// # Errors
/// If there is no camera, or the scene cannot be drawn.
pub fn average(
    session: &mut Session,
    size: [u32; 2],
    settings: &RenderSettings,
    goal: Goal,
    told: &mut dyn FnMut(Progress),
) -> Result<(Image, Outcome)> {
    let start = Instant::now();
    // Shifted images are smooth at their edges, and are averaged anyway, each by itself.
    let mut settings = RenderSettings { display: true, mlaa: false, average: false, ..settings.clone() };
    let edges = if session.shares_light(&settings) { goal.edges } else { 1 };
    let mut halves = Halves::new(size);
    let (mut look, mut estimate) = (goal.least, None);
    loop {
        settings.images = FILTER_AHEAD * (halves.images() + 2);
        let (pair, frame_time) = draw_pair(session, size, &settings, (halves.images() / 2, edges))?;
        halves.add(&pair);
        let images = halves.images();
        let is_late = start.elapsed() + 2 * frame_time > goal.time_limit;
        if images >= look || is_late {
            let now = halves.estimate()?;
            let end = match () {
                () if goal.excess(now) <= 1.0 && images >= goal.least => Some(End::Bound),
                () if images >= goal.most => Some(End::Most),
                () if is_late => Some(End::Time),
                () => None,
            };
            if let Some(end) = end {
                let outcome = Outcome { images, estimate: now, goal, time: start.elapsed(), end };
                return Ok((halves.mean()?, outcome));
            }
            look = goal.next_look(images, now);
            estimate = Some((images, now));
        }
        let expected = estimate.map_or(goal.least, |(then, estimate)| goal.expected(then, estimate));
        told(Progress { images, expected: expected.max(images), estimate: estimate.map(|(_, estimate)| estimate) });
    }
}

/// An image for each half, of so many frames each, and how long the second took: the very first frame also compiles shaders.
fn draw_pair(
    session: &mut Session,
    size: [u32; 2],
    settings: &RenderSettings,
    (pair, edges): (u32, u32),
) -> Result<([Image; 2], Duration)> {
    let shifts: Vec<_> = (0..edges).map(|edge| jitter::pair(pair * edges + edge)).collect();
    let mut draw = |half: usize| {
        let shifts: Vec<_> = shifts.iter().map(|pair| pair[half]).collect();
        capture::take_at(session, size, &shifts, settings)
    };
    let first = draw(0)?;
    let start = Instant::now();
    let second = draw(1)?;
    Ok(([first, second], start.elapsed()))
}
