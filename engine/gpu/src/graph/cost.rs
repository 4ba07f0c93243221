//! How much work goes into one submit, by the times that earlier frames took.

use std::collections::HashMap;

/// Longest time of one submit \[ms\]: an interface and other programs wait no longer for the device, and drivers do not
/// take it for hung.
pub(super) const SUBMIT_MS: f64 = 50.0;

/// How much more work than on a software driver a submit holds on hardware whose speed is not known yet.
const UNMEASURED: u64 = 16;

/// How fast the assumed speed may grow from frame to frame: the next one may see something harder.
const MOST_GROWTH: f64 = 4.0;

/// Costs of passes, by their names. They decide where a frame is cut into submits, which changes no bit of the results.
#[derive(Debug, Default)]
pub(super) struct Costs {
    passes: HashMap<String, Cost>,
}

#[derive(Debug, Default)]
struct Cost {
    /// Work of the last frame in which it ran, in units of its own.
    units: u64,
    /// Time on the device, as last measured \[ms\].
    ms: Option<f64>,
    /// Units a millisecond.
    rate: Option<f64>,
}

impl Costs {
    /// Time that a pass took when it was last measured, none if it never was \[ms\].
    pub fn ms(&self, pass: &str) -> Option<f64> {
        self.passes.get(pass)?.ms
    }

    /// Units of its work that one submit of the pass holds; `on_software` is how many it holds on a software driver.
    pub fn units_a_submit(&self, pass: &str, is_software: bool, on_software: u64) -> u64 {
        match self.passes.get(pass).and_then(|cost| cost.rate) {
            _ if is_software => on_software,
            Some(rate) => ((rate * SUBMIT_MS) as u64).max(1),
            None => on_software.saturating_mul(UNMEASURED),
        }
    }

    /// Notes how much work the pass has recorded in this frame.
    pub fn record(&mut self, pass: &str, units: u64) {
        self.passes.entry(pass.to_owned()).or_default().units = units;
    }

    /// Takes in a time of the pass \[ms\].
    pub fn measure(&mut self, pass: &str, ms: f64) {
        let cost = self.passes.entry(pass.to_owned()).or_default();
        cost.ms = Some(ms);
        if cost.units > 0 {
            let rate = cost.units as f64 / ms.max(1e-3);
            cost.rate = Some(cost.rate.map_or(rate, |before| rate.min(MOST_GROWTH * before)));
        }
    }

    /// Whether a submit of at most that time is full before something is added to it, all as times \[ms\].
    pub fn is_full(spent: f64, more: f64, most: f64) -> bool {
        spent > 0.0 && spent + more > most
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn submits_follow_the_measured_time() {
        let mut costs = Costs::default();
        assert_eq!(costs.units_a_submit("gather", true, 100), 100);
        assert_eq!(costs.units_a_submit("gather", false, 100), 1600, "nothing is known yet");
        costs.record("gather", 1_000_000);
        costs.measure("gather", 10.0);
        assert_eq!(costs.units_a_submit("gather", false, 100), 5_000_000, "100,000 a millisecond");
        assert_eq!(costs.units_a_submit("gather", true, 100), 100, "software drivers keep their pieces");
        costs.measure("gather", 1.0);
        assert_eq!(costs.units_a_submit("gather", false, 100), 20_000_000, "slowly up");
        costs.measure("gather", 1000.0);
        assert_eq!(costs.units_a_submit("gather", false, 100), 50_000, "quickly down");
        costs.measure("gather", 0.0);
        assert!(costs.units_a_submit("gather", false, 100) > 0);
    }

    #[test]
    fn a_submit_takes_passes_until_it_is_full() {
        assert!(!Costs::is_full(0.0, 400.0, SUBMIT_MS), "what is longer by itself begins a submit");
        assert!(!Costs::is_full(20.0, 20.0, SUBMIT_MS));
        assert!(Costs::is_full(40.0, 20.0, SUBMIT_MS));
        let mut costs = Costs::default();
        assert_eq!(costs.ms("gather"), None, "it never ran");
        costs.measure("gather", 3.0);
        assert_eq!(costs.ms("gather"), Some(3.0));
    }
}
