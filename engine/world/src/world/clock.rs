//! The clock: an input of the world, never the wall.
//!
//! Time is an integer number of flicks. A flick (Horvath 2018) is 1/705,600,000 s and divides the second into whole
//! parts for all usual frame rates, so that times and the loops of animations are exact.

use bevy_ecs::prelude::*;

/// Flicks in a second.
pub const FLICKS_PER_SECOND: u64 = 705_600_000;

/// World time. Tick n is n / [`SceneSettings::frame_rate`](super::SceneSettings::frame_rate) seconds.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Clock {
    tick: u64,
    rate: u32,
    /// Distance from the tick \[flicks\], for times between two ticks.
    offset: u64,
}

impl Clock {
    /// At a tick of the frame rate [1/s]; a rate of 0 counts as 1.
    pub fn at_tick(tick: u64, rate: u32) -> Self {
        Self { tick, rate, offset: 0 }
    }

    /// At a time \[s\], rounded to a flick; times before the start and NaN count as the start.
    pub fn at_seconds(seconds: f64, rate: u32) -> Self {
        Self::at_flicks(flicks(seconds.max(0.0)), rate.max(1))
    }

    fn at_flicks(flicks: u64, rate: u32) -> Self {
        // Rounding in `flicks_of` may put the tick half a flick past the time.
        let mut tick = saturate(u128::from(flicks) * u128::from(rate) / u128::from(FLICKS_PER_SECOND));
        while tick > 0 && flicks_of(tick, rate) > flicks {
            tick -= 1;
        }
        if flicks_of(tick.saturating_add(1), rate) == flicks {
            tick = tick.saturating_add(1);
        }
        Self { tick, rate, offset: flicks - flicks_of(tick, rate) }
    }

    /// The last tick that has begun.
    pub fn tick(&self) -> u64 {
        self.tick
    }

    /// Time \[flicks\].
    pub fn flicks(&self) -> u64 {
        flicks_of(self.tick, self.rate).saturating_add(self.offset)
    }

    /// Time \[s\].
    pub fn seconds(&self) -> f64 {
        self.flicks() as f64 / FLICKS_PER_SECOND as f64
    }

    /// The same time in ticks of another frame rate [1/s].
    pub fn with_rate(self, rate: u32) -> Self {
        if rate.max(1) == self.rate.max(1) { self } else { Self::at_flicks(self.flicks(), rate.max(1)) }
    }

    /// Some ticks later, by the frame rate that it was set with.
    pub fn advanced(self, ticks: u64) -> Self {
        Self { tick: self.tick.saturating_add(ticks), ..self }
    }
}

/// A duration \[s\] in flicks, rounded; zero for NaN and for negative ones.
pub(super) fn flicks(seconds: f64) -> u64 {
    (seconds * FLICKS_PER_SECOND as f64).round() as u64
}

fn flicks_of(tick: u64, rate: u32) -> u64 {
    let rate = u128::from(rate.max(1));
    saturate((u128::from(tick) * u128::from(FLICKS_PER_SECOND) + rate / 2) / rate)
}

fn saturate(value: u128) -> u64 {
    u64::try_from(value).unwrap_or(u64::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tick_is_the_same_time_however_it_is_reached() {
        for rate in [1, 7, 24, 30, 60, 144, 1001] {
            let jumped = Clock::at_tick(97, rate);
            let stepped = (0..97).fold(Clock::at_tick(0, rate), |c, _| c.advanced(1));
            let seconds = Clock::at_seconds(97.0 / f64::from(rate), rate);
            assert_eq!(jumped.flicks(), stepped.flicks());
            assert_eq!((jumped.flicks(), 97), (seconds.flicks(), seconds.tick()), "rate {rate}");
        }
    }

    #[test]
    fn times_out_of_range_are_clamped() {
        assert_eq!(Clock::at_seconds(-1.0, 30).flicks(), 0);
        assert_eq!(Clock::at_seconds(f64::NAN, 30).flicks(), 0);
        assert_eq!(Clock::at_seconds(f64::INFINITY, 30).flicks(), u64::MAX);
        assert_eq!(Clock::at_tick(u64::MAX, 0).flicks(), u64::MAX);
        assert_eq!(Clock::at_tick(u64::MAX, 30).advanced(1).tick(), u64::MAX);
    }
}
