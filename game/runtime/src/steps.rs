//! Steps of a game that are due in wall time.

/// Most steps at once: a machine that cannot keep up plays slower, and not in ever longer jumps.
const MOST: u64 = 15;

/// Counts time until it makes whole steps.
#[derive(Clone, Copy, Debug, Default)]
pub struct StepClock {
    /// Time that no step has passed yet \[steps\].
    carried: f64,
}

impl StepClock {
    /// Lets wall time pass \[s\]; gives the number of steps that are due, of so many a second.
    pub fn due(&mut self, elapsed: f64, rate: u32) -> u64 {
        self.carried += elapsed * f64::from(rate);
        let due = (self.carried.floor() as u64).min(MOST);
        self.carried = (self.carried - due as f64).min(1.0);
        due
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_makes_steps_and_long_waits_make_few() {
        let mut clock = StepClock::default();
        let due: Vec<u64> = [0.01, 0.01, 0.02, 100.0, 0.0, 0.0].iter().map(|time| clock.due(*time, 60)).collect();
        assert_eq!(due, [0, 1, 1, 15, 1, 0]);
    }
}
