//! Outcomes of averages, in words.

use super::goal::Goal;
use super::halves::Estimate;
use std::fmt;
use std::time::Duration;

/// Why an average ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// The estimated error is below the bound.
    Bound,
    /// The time was up.
    Time,
    /// There were as many images as are averaged at most.
    Most,
}

/// The outcome of an average.
#[derive(Clone, Copy, Debug)]
pub struct Outcome {
    /// Images that were averaged.
    pub images: u32,
    /// The estimated error.
    pub estimate: Estimate,
    /// Its goal.
    pub goal: Goal,
    /// How long it took.
    pub time: Duration,
    /// Why it ended.
    pub end: End,
}

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { images, estimate, goal, time, end } = self;
        let (mean, most, bound) = (estimate.mean, estimate.most, goal.bound);
        write!(
            f,
            "{images} images averaged in {:.1} s; estimated error {mean:.4} (mean FLIP; 99 % of the pixels below \
             {most:.3}), bound {bound}",
            time.as_secs_f64()
        )?;
        match end {
            End::Bound => Ok(()),
            End::Time => {
                let limit = goal.time_limit.as_secs_f64();
                let expected = goal.expected(*images, *estimate);
                write!(
                    f,
                    ": the time limit of {limit} s ended it first; about {expected} images would reach the bound: give a \
                     longer --time-limit"
                )
            }
            End::Most => write!(f, ": this quality averages no more images"),
        }
    }
}

/// The outcomes of several averages.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    outcomes: u32,
    images: u32,
    /// The one farthest from its bound.
    worst: Option<Outcome>,
    /// How many were ended by their time or number.
    unfinished: u32,
}

impl Tally {
    /// Counts one more.
    pub fn add(&mut self, outcome: Outcome) {
        self.outcomes += 1;
        self.images += outcome.images;
        self.unfinished += u32::from(outcome.end != End::Bound);
        let excess = |outcome: &Outcome| outcome.goal.excess(outcome.estimate);
        if self.worst.as_ref().is_none_or(|worst| excess(worst) < excess(&outcome)) {
            self.worst = Some(outcome);
        }
    }

    /// A sentence on all of them; none if nothing was averaged.
    pub fn sentence(&self) -> Option<String> {
        let worst = self.worst?;
        if self.outcomes == 1 {
            return Some(worst.to_string());
        }
        let mean = f64::from(self.images) / f64::from(self.outcomes);
        let rest = match self.unfinished {
            0 => "all are within their bound".to_owned(),
            some => format!("{some} were ended before they reached their bound"),
        };
        Some(format!("{mean:.1} images averaged for each of {} frames; {rest}; the worst: {worst}", self.outcomes))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::cli::{Quality, QualityArgs};

    fn outcome(mean: f64, end: End) -> Outcome {
        let goal = Goal::new(&QualityArgs { quality: None, time_limit: Some(2.0), edges: None }, Quality::Good);
        let estimate = Estimate { mean, most: 0.05 };
        Outcome { images: 16, estimate, goal, time: Duration::from_millis(1500), end }
    }

    #[test]
    fn an_average_that_was_ended_early_says_what_is_left() {
        let mut tally = Tally::default();
        assert_eq!(tally.sentence(), None);
        tally.add(outcome(0.01, End::Bound));
        let within = tally.sentence().unwrap();
        assert!(within.starts_with("16 images averaged in 1.5 s; estimated error 0.0100"), "{within}");
        assert!(within.ends_with("bound 0.02"), "{within}");
        tally.add(outcome(0.03, End::Time));
        let both = tally.sentence().unwrap();
        assert!(both.starts_with("16.0 images averaged for each of 2 frames; 1 were ended"), "{both}");
        assert!(both.contains("0.0300") && both.contains("time limit of 2 s") && both.contains("about 52"), "{both}");
    }
}
