//! Time of a game: steps of equal length, and what lies between frames.

use crate::files::SceneData;
use bevy_ecs::prelude::Resource;

/// The time that systems see.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
pub struct Time {
    /// Steps since the game began, the present one included.
    pub step: u64,
    /// Steps a second.
    pub rate: u32,
    /// In [`FixedUpdate`](super::FixedUpdate) the length of a step, in [`Update`](super::Update) the time since the
    /// frame before \[s\].
    pub delta: f32,
    /// Since the game began, by its steps \[s\].
    pub elapsed: f64,
}

impl Time {
    /// The beginning, with so many steps a second (at least one).
    pub fn new(rate: u32) -> Self {
        let rate = rate.max(1);
        Self { step: 0, rate, delta: 1.0 / rate as f32, elapsed: 0.0 }
    }

    /// At a step.
    pub(super) fn at(self, step: u64) -> Self {
        Self { step, delta: 1.0 / self.rate as f32, elapsed: step as f64 / f64::from(self.rate), ..self }
    }
}

/// Counts time down, once or again and again. A field of a component, or a [`Local`](bevy_ecs::prelude::Local).
///
/// ```
/// # extern crate lightwell_world as lightwell;
/// use lightwell::game::Timer;
///
/// let mut timer = Timer::repeating(0.5);
/// assert_eq!(timer.tick(0.4), 0);
/// assert_eq!(timer.tick(1.2), 3, "at 0.5, 1.0 and 1.5 seconds");
/// ```
#[derive(SceneData, Clone, Copy, Debug, Default, PartialEq)]
pub struct Timer {
    /// Length \[s\].
    pub length: f32,
    /// Whether it restarts when it is over.
    pub repeats: bool,
    /// Since it was started \[s\].
    pub elapsed: f32,
}

impl Timer {
    /// One that is over once, after so many seconds.
    pub fn once(length: f32) -> Self {
        Self { length, repeats: false, elapsed: 0.0 }
    }

    /// One that is over every so many seconds.
    pub fn repeating(length: f32) -> Self {
        Self { length, repeats: true, elapsed: 0.0 }
    }

    /// Lets time pass \[s\]; says how often it came to its end. A repeating one without length ends once a tick.
    pub fn tick(&mut self, delta: f32) -> u32 {
        let was_over = self.is_over();
        self.elapsed += delta.max(0.0);
        if self.elapsed < self.length {
            return 0;
        }
        if !self.repeats {
            return u32::from(!was_over);
        }
        if self.length <= 0.0 {
            self.elapsed = 0.0;
            return 1;
        }
        let times = (self.elapsed / self.length).floor();
        self.elapsed -= times * self.length;
        times as u32
    }

    /// Whether one that does not repeat is over.
    pub fn is_over(&self) -> bool {
        !self.repeats && self.elapsed >= self.length
    }

    /// Remaining time \[s\].
    pub fn left(&self) -> f32 {
        (self.length - self.elapsed).max(0.0)
    }

    /// Restarts.
    pub fn restart(&mut self) {
        self.elapsed = 0.0;
    }
}
