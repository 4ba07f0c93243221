//! When an average is good enough.

use super::halves::Estimate;
use crate::cli::{Quality, QualityArgs};
use std::time::Duration;

/// 99 % of the pixels may be so many times as wrong as the mean over all.
const MOST_OVER_MEAN: f64 = 5.0;
/// Shifts at which an image is drawn, unless it is said: more of them would cost more than the noise of so many images is worth.
const EDGES: u32 = 4;

/// When an average ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Goal {
    /// Bound of the estimated error: mean FLIP, 0..1. 99 % of the pixels must be below five times as much.
    pub bound: f64,
    /// Images that are averaged at least, an even number: edges are smooth then.
    pub least: u32,
    /// Images that are averaged at most, an even number.
    pub most: u32,
    /// Shifts of the pixel grid at which each image is drawn, where one of them may gather the light of all.
    pub edges: u32,
    /// Time for an image.
    pub time_limit: Duration,
}

impl Goal {
    /// The goal of a quality, within the time that was given for it.
    pub fn new(args: &QualityArgs, default: Quality) -> Self {
        let (bound, least, most, seconds) = match args.quality.unwrap_or(default) {
            Quality::Fast => (0.04, 4, 64, 10.0),
            Quality::Good => (0.02, 8, 512, 120.0),
            Quality::Best => (0.01, 16, 4096, 1200.0),
        };
        // A longer time than can be told is no limit.
        let limit = Duration::try_from_secs_f64(args.time_limit.unwrap_or(seconds));
        let edges = args.edges.unwrap_or(EDGES);
        Self { bound, least, most, edges, time_limit: limit.unwrap_or(Duration::MAX) }
    }

    /// How far an estimate is from the bound: above 1 it is past it.
    pub fn excess(&self, estimate: Estimate) -> f64 {
        (estimate.mean / self.bound).max(estimate.most / (MOST_OVER_MEAN * self.bound))
    }

    /// How many images the bound will take, by an estimate after some; an even number. FLIP grows as the noise to the power
    /// of 0.7 or so, and noise falls with the root of the number.
    pub fn expected(&self, images: u32, estimate: Estimate) -> u32 {
        let pairs = 0.5 * f64::from(images) * self.excess(estimate).powf(2.0 / 0.7);
        2 * (pairs.ceil() as u32).clamp(self.least / 2, self.most / 2)
    }

    /// After how many images the next estimate is worth its time, by the one after some.
    pub fn next_look(&self, images: u32, estimate: Estimate) -> u32 {
        // The first estimates say little: never more than twice as far.
        self.expected(images, estimate).clamp(images + 2, (2 * images).max(images + 2)).min(self.most)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn better_takes_more() {
        let goal =
            |quality| Goal::new(&QualityArgs { quality: Some(quality), time_limit: None, edges: None }, Quality::Fast);
        let goals = [Quality::Fast, Quality::Good, Quality::Best].map(goal);
        for pair in goals.windows(2) {
            assert!(pair[1].bound < pair[0].bound && pair[1].time_limit > pair[0].time_limit);
            assert!(pair[1].least > pair[0].least && pair[1].most > pair[0].most);
        }
        assert!(goals.iter().all(|goal| goal.least % 2 == 0 && goal.most % 2 == 0));
        let limited = Goal::new(&QualityArgs { quality: None, time_limit: Some(2.5), edges: None }, Quality::Best);
        assert_eq!((limited.bound, limited.time_limit), (goals[2].bound, Duration::from_millis(2500)));
        let endless = Goal::new(&QualityArgs { quality: None, time_limit: Some(1e300), edges: None }, Quality::Best);
        assert_eq!(endless.time_limit, Duration::MAX);
    }

    #[test]
    fn looks_come_nearer_to_what_is_expected() {
        let goal = Goal::new(&QualityArgs::default(), Quality::Good);
        let estimate = |mean, most| Estimate { mean, most };
        assert_eq!(goal.excess(estimate(0.04, 0.04)), 2.0);
        assert_eq!(goal.excess(estimate(0.02, 0.2)), 2.0);
        assert_eq!(goal.expected(20, estimate(0.04, 0.0)), 146);
        assert_eq!(goal.next_look(20, estimate(0.04, 0.0)), 40);
        assert_eq!(goal.next_look(20, estimate(0.0201, 0.0)), 22);
        assert_eq!(goal.next_look(400, estimate(1.0, 1.0)), 512);
    }
}
