//! Progress of long work.

use indicatif::{HumanDuration, ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle, TermLike};
use std::fmt;
use std::io::{self, IsTerminal, Write};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// A bar of so many steps on a terminal, a line now and then elsewhere; hidden for a single step.
pub fn bar(steps: u64, what: &str) -> ProgressBar {
    if steps < 2 {
        return ProgressBar::hidden();
    }
    // The error stream: the output stream may be piped on.
    let (target, shape) = if io::stderr().is_terminal() {
        (ProgressDrawTarget::stderr(), "{msg} [{bar:32}] {pos}/{len}  {elapsed} ({left} left)")
    } else {
        let lines = ProgressDrawTarget::term_like_with_hz(Box::new(Lines::default()), 1);
        (lines, "{msg}: {pos} of {len}, {elapsed} ({left} left)")
    };
    let bar = ProgressBar::with_draw_target(Some(steps), target);
    if let Ok(style) = ProgressStyle::with_template(shape) {
        bar.set_style(style.progress_chars("=> ").with_key("left", left));
    }
    bar.set_message(what.to_owned());
    bar
}

/// The time that is left if work goes on as it did so far. The bar's own estimate follows the speed of the last moments,
/// which says nothing where steps take from milliseconds to minutes.
fn left(state: &ProgressState, text: &mut dyn fmt::Write) {
    let rest = state.len().unwrap_or(0).saturating_sub(state.pos());
    let seconds = state.elapsed().as_secs_f64() * rest as f64 / state.pos() as f64;
    // A bar cannot fail; what cannot be written is not there.
    let _ = match Duration::try_from_secs_f64(seconds) {
        Ok(time) if state.pos() > 0 => write!(text, "about {}", HumanDuration(time)),
        _ => text.write_str("some time"),
    };
}

/// Time between two lines in a log.
const PAUSE: Duration = Duration::from_secs(60);

/// A log in a file or a pipe, in which nothing can be drawn over: a line a minute.
#[derive(Debug)]
struct Lines {
    state: Mutex<(Instant, String)>,
}

impl Default for Lines {
    fn default() -> Self {
        Self { state: Mutex::new((Instant::now(), String::new())) }
    }
}

impl Lines {
    fn with<T>(&self, work: impl FnOnce(&mut (Instant, String)) -> T) -> T {
        work(&mut self.state.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

impl TermLike for Lines {
    fn width(&self) -> u16 {
        120
    }

    fn move_cursor_up(&self, _: usize) -> io::Result<()> {
        Ok(())
    }

    fn move_cursor_down(&self, _: usize) -> io::Result<()> {
        Ok(())
    }

    fn move_cursor_right(&self, _: usize) -> io::Result<()> {
        Ok(())
    }

    fn move_cursor_left(&self, _: usize) -> io::Result<()> {
        Ok(())
    }

    fn write_line(&self, text: &str) -> io::Result<()> {
        self.write_str(text)
    }

    fn write_str(&self, text: &str) -> io::Result<()> {
        self.with(|(_, line)| line.push_str(text));
        Ok(())
    }

    fn clear_line(&self) -> io::Result<()> {
        self.with(|(_, line)| line.clear());
        Ok(())
    }

    fn flush(&self) -> io::Result<()> {
        self.with(|(last, line)| {
            let line = std::mem::take(line);
            let text = line.trim();
            if text.is_empty() || last.elapsed() < PAUSE {
                return Ok(());
            }
            *last = Instant::now();
            writeln!(io::stderr(), "{text}")
        })
    }
}
