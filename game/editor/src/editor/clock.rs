//! The clock of interactive play: wall time in, ticks of the scene's fixed clock out.

use lightwell::world::SceneSettings;

/// Longest step of wall time that is followed \[s\]: after a pause of the machine the scene does not jump.
const LONGEST_STEP: f64 = 0.5;
/// Slowest and fastest speed, as powers of two.
const SPEEDS: std::ops::RangeInclusive<i32> = -4..=4;

/// Where play is.
#[derive(Clone, Debug)]
pub struct PlayClock {
    /// Whether time passes.
    pub playing: bool,
    /// Position \[ticks\].
    position: f64,
    /// Speed as a power of two.
    speed: i32,
    /// Ticks a second.
    rate: f64,
    /// Length of a loop \[ticks\]; none: no loop.
    length: Option<f64>,
}

impl PlayClock {
    /// At the start, playing.
    pub fn new(settings: &SceneSettings) -> Self {
        let mut clock = Self { playing: true, position: 0.0, speed: 0, rate: 1.0, length: None };
        clock.follow(settings);
        clock
    }

    /// Takes over rate and loop of a scene that was reloaded, and keeps the time.
    pub fn follow(&mut self, settings: &SceneSettings) {
        let rate = f64::from(settings.frame_rate.max(1));
        self.position *= rate / self.rate;
        self.rate = rate;
        self.length = settings.duration.map(|d| (f64::from(d) * rate).round()).filter(|length| *length >= 1.0);
        self.wrap();
    }

    /// Lets wall time pass \[s\].
    pub fn advance(&mut self, elapsed: f64) {
        if self.playing {
            self.position += elapsed.clamp(0.0, LONGEST_STEP) * self.speed() * self.rate;
            self.wrap();
        }
    }

    /// Pauses and moves on by one tick.
    pub fn step(&mut self) {
        self.playing = false;
        self.position = self.position.floor() + 1.0;
        self.wrap();
    }

    /// Goes to a time \[s\].
    pub fn seek(&mut self, seconds: f64) {
        // Up to rounding, times are those of whole ticks.
        self.position = (seconds.max(0.0) * self.rate + 1e-6).floor();
        if self.length.is_none_or(|length| self.position > length) {
            self.wrap();
        }
    }

    /// Length of the loop \[s\]; none if there is no loop.
    pub fn length_seconds(&self) -> Option<f64> {
        self.length.map(|length| length / self.rate)
    }

    /// Doubles (1) or halves (−1) the speed.
    pub fn change_speed(&mut self, by: i32) {
        self.speed = (self.speed + by).clamp(*SPEEDS.start(), *SPEEDS.end());
    }

    /// Speed; 1 is real time.
    pub fn speed(&self) -> f64 {
        2f64.powi(self.speed)
    }

    /// The tick to show.
    pub fn ticks(&self) -> u64 {
        self.position as u64
    }

    /// Time of the tick to show \[s\].
    pub fn seconds(&self) -> f64 {
        self.position.floor() / self.rate
    }

    fn wrap(&mut self) {
        if let Some(length) = self.length {
            self.position %= length;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn clock(duration: Option<f32>) -> PlayClock {
        PlayClock::new(&SceneSettings { frame_rate: 30, duration, ..SceneSettings::default() })
    }

    #[test]
    fn time_passes_and_wraps() {
        let mut clock = clock(Some(2.0));
        clock.advance(0.25);
        assert_eq!(clock.ticks(), 7);
        (0..7).for_each(|_| clock.advance(0.25));
        assert_eq!(clock.ticks(), 0);
        clock.advance(1000.0);
        assert_eq!(clock.ticks(), 15);
    }

    #[test]
    fn steps_pause_and_speed_scales() {
        let mut clock = clock(None);
        clock.step();
        clock.advance(0.4);
        assert_eq!((clock.playing, clock.ticks()), (false, 1));
        clock.playing = true;
        clock.change_speed(1);
        clock.advance(0.5);
        assert_eq!(clock.ticks(), 31);
        (0..20).for_each(|_| clock.change_speed(-1));
        assert_eq!(clock.speed(), 1.0 / 16.0);
    }

    #[test]
    fn any_time_can_be_gone_to() {
        let mut clock = clock(Some(2.0));
        clock.seek(0.1);
        assert_eq!((clock.ticks(), clock.length_seconds()), (3, Some(2.0)));
        clock.seek(-1.0);
        assert_eq!(clock.ticks(), 0);
    }

    #[test]
    fn a_new_rate_keeps_the_time() {
        let mut clock = clock(None);
        clock.advance(0.5);
        clock.follow(&SceneSettings { frame_rate: 60, ..SceneSettings::default() });
        assert_eq!((clock.ticks(), clock.seconds()), (30, 0.5));
    }
}
