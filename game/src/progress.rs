//! Progress of long work.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// A bar of so many steps on a terminal; hidden elsewhere, and for a single step.
pub fn bar(steps: u64, what: &str) -> ProgressBar {
    if steps < 2 {
        return ProgressBar::hidden();
    }
    // The error stream: the output stream may be piped on. indicatif hides the bar where that is no terminal.
    let bar = ProgressBar::with_draw_target(Some(steps), ProgressDrawTarget::stderr());
    if let Ok(style) = ProgressStyle::with_template("{msg} [{bar:32}] {pos}/{len}  {elapsed} (about {eta} left)") {
        bar.set_style(style.progress_chars("=> "));
    }
    bar.set_message(what.to_owned());
    bar
}
