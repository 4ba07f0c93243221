//! Progress of long work.

use std::io::{self, IsTerminal, Write};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Time between two drawings of a bar on a terminal.
const REDRAW: Duration = Duration::from_millis(50);
/// Time between two lines in a log, in which nothing can be drawn over.
const PAUSE: Duration = Duration::from_secs(60);
/// Length of a bar \[characters\].
const LENGTH: u64 = 32;

/// A bar of so many steps on a terminal, a line a minute elsewhere; hidden for a single step.
pub fn bar(steps: u64, what: &str) -> Bar {
    // The error stream: the output stream may be piped on.
    let place = match (steps, io::stderr().is_terminal()) {
        (0 | 1, _) => Place::Nowhere,
        (_, true) => Place::Terminal,
        (_, false) => Place::Log,
    };
    let now = Instant::now();
    let state = State { place, steps, done: 0, what: what.to_owned(), begin: now, last: now, is_drawn: false };
    let bar = Bar { state: Mutex::new(state) };
    bar.state().redraw();
    bar
}

/// How far long work is. Threads may share it.
pub struct Bar {
    state: Mutex<State>,
}

impl Bar {
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn change(&self, change: impl FnOnce(&mut State)) {
        let mut state = self.state();
        change(&mut state);
        state.tick();
    }

    /// Takes one more step as done.
    pub fn inc(&self, steps: u64) {
        self.change(|state| state.done += steps);
    }

    /// Sets the number of steps that are done.
    pub fn set_position(&self, done: u64) {
        self.change(|state| state.done = done);
    }

    /// Sets the number of steps that there are.
    pub fn set_length(&self, steps: u64) {
        self.change(|state| state.steps = steps);
    }

    /// Says what is being done.
    pub fn set_message(&self, what: impl Into<String>) {
        let what = what.into();
        self.change(|state| state.what = what);
    }

    /// Shows how much time has passed.
    pub fn tick(&self) {
        self.change(|_| ());
    }

    /// The number of steps that are done.
    pub fn position(&self) -> u64 {
        self.state().done
    }

    /// Does something that prints lines: the bar stands below them afterwards.
    pub fn suspend<T>(&self, work: impl FnOnce() -> T) -> T {
        self.state().clear();
        let result = work();
        self.state().redraw();
        result
    }

    /// Ends it, and leaves nothing of it on the terminal.
    pub fn finish_and_clear(&self) {
        let mut state = self.state();
        state.clear();
        state.place = Place::Nowhere;
    }
}

/// Where a bar that ends early, by an error, stood is free again.
impl Drop for Bar {
    fn drop(&mut self) {
        self.finish_and_clear();
    }
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Place {
    Terminal,
    Log,
    Nowhere,
}

struct State {
    place: Place,
    steps: u64,
    done: u64,
    what: String,
    begin: Instant,
    /// When it was drawn last, or when it began.
    last: Instant,
    is_drawn: bool,
}

impl State {
    /// Shows it, unless that was done a short time ago.
    fn tick(&mut self) {
        let pause = match self.place {
            Place::Terminal => REDRAW,
            Place::Log => PAUSE,
            Place::Nowhere => return,
        };
        if self.last.elapsed() < pause {
            return;
        }
        self.last = Instant::now();
        match self.place {
            Place::Terminal => self.redraw(),
            // A log that cannot be written has no reader.
            _ => drop(writeln!(io::stderr(), "{}", self.line(self.begin.elapsed()))),
        }
    }

    /// Draws it over what is there of it.
    fn redraw(&mut self) {
        if self.place == Place::Terminal {
            let _ = write!(io::stderr(), "\r\x1b[2K{}", self.bar(self.begin.elapsed()));
            self.is_drawn = true;
        }
    }

    fn clear(&mut self) {
        if std::mem::take(&mut self.is_drawn) {
            let _ = write!(io::stderr(), "\r\x1b[2K");
        }
    }

    fn bar(&self, elapsed: Duration) -> String {
        let full = (LENGTH * self.done).checked_div(self.steps).map_or(0, |full| full.min(LENGTH) as usize);
        let (whole, head) = if full < LENGTH as usize { (full, ">") } else { (full, "") };
        let bar = format!("{}{head}", "=".repeat(whole));
        let (what, done, steps, length) = (&self.what, self.done, self.steps, LENGTH as usize);
        format!("{what} [{bar:length$}] {done}/{steps}  {} ({} left)", short(elapsed), self.left(elapsed))
    }

    fn line(&self, elapsed: Duration) -> String {
        let (what, done, steps) = (&self.what, self.done, self.steps);
        format!("{what}: {done} of {steps}, {} ({} left)", short(elapsed), self.left(elapsed))
    }

    /// The time that is left if work goes on as it did so far.
    fn left(&self, elapsed: Duration) -> String {
        let rest = self.steps.saturating_sub(self.done);
        let seconds = elapsed.as_secs_f64() * rest as f64 / self.done as f64;
        match Duration::try_from_secs_f64(seconds) {
            Ok(time) if self.done > 0 => format!("about {}", long(time)),
            _ => "some time".to_owned(),
        }
    }
}

/// Units of time with their lengths \[s\], in words and as letters.
const UNITS: [(u64, &str, &str); 4] =
    [(86_400, "day", "d"), (3600, "hour", "h"), (60, "minute", "m"), (1, "second", "s")];

/// A time in the greatest unit of which it has at least one and a half, with the names of the unit.
fn rounded(time: Duration) -> (u64, &'static str, &'static str) {
    let seconds = time.as_secs_f64();
    let unit = UNITS.iter().find(|(length, ..)| seconds >= 1.5 * *length as f64).unwrap_or(&UNITS[3]);
    ((seconds / unit.0 as f64).round() as u64, unit.1, unit.2)
}

fn short(time: Duration) -> String {
    let (count, _, letter) = rounded(time);
    format!("{count}{letter}")
}

fn long(time: Duration) -> String {
    match rounded(time) {
        (1, unit, _) => format!("1 {unit}"),
        (count, unit, _) => format!("{count} {unit}s"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bar_says_how_far_work_is_and_what_is_left() {
        let bar = bar(8, "drawing");
        bar.state().place = Place::Log;
        bar.inc(2);
        let minute = Duration::from_secs(60);
        assert_eq!(bar.state().line(minute), "drawing: 2 of 8, 60s (about 3 minutes left)");
        assert_eq!(
            bar.state().bar(minute),
            "drawing [========>                       ] 2/8  60s (about 3 minutes left)"
        );
        bar.set_position(8);
        bar.set_message("done");
        assert_eq!(bar.state().bar(minute), format!("done [{}] 8/8  60s (about 0 seconds left)", "=".repeat(32)));
        bar.set_position(0);
        assert!(bar.state().line(minute).contains("(some time left)"));
        assert_eq!(bar.suspend(|| 7), 7);
        assert_eq!(bar.position(), 0);
    }

    #[test]
    fn times_are_told_in_their_greatest_unit() {
        let told = |seconds| (short(Duration::from_secs(seconds)), long(Duration::from_secs(seconds)));
        assert_eq!(told(1), ("1s".to_owned(), "1 second".to_owned()));
        assert_eq!(told(89), ("89s".to_owned(), "89 seconds".to_owned()));
        assert_eq!(told(90), ("2m".to_owned(), "2 minutes".to_owned()));
        assert_eq!(told(7200), ("2h".to_owned(), "2 hours".to_owned()));
        assert_eq!(told(3 * 86_400), ("3d".to_owned(), "3 days".to_owned()));
    }
}
