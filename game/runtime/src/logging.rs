//! The program's log on its error stream, and warnings caught while something is tried.

use log::{Level, Log, Metadata, Record};
use std::cell::RefCell;
use std::io::{self, Write};
use std::sync::OnceLock;
use std::time::{SystemTime, UNIX_EPOCH};

thread_local! {
    /// Warnings of this thread that are caught; none: they go to the log.
    static CAUGHT: RefCell<Option<Vec<String>>> = const { RefCell::new(None) };
}

/// What else hears every message, and whether it is printed.
type Hook = fn(&Record, bool);

static HOOK: OnceLock<Hook> = OnceLock::new();

/// Has a function called with each message that is logged from now on, and whether it is printed too. There is one such
/// function: those after the first are passed over.
pub fn also_tell(hook: Hook) {
    let _ = HOOK.set(hook);
}

/// Starts the log: warnings always, more with `-v`; RUST_LOG overrides. What the graphics libraries say is a level quieter.
///
/// Call it before there are other threads.
pub fn start(verbose: u8) {
    silence_device_selection();
    let filter = match verbose {
        0 => "warn,wgpu=error,wgpu_hal=error,wgpu_core=error,naga=error,winit=error",
        1 => "info,wgpu=warn,wgpu_hal=error,wgpu_core=warn,naga=warn",
        _ => "debug,wgpu=info,wgpu_hal=warn,wgpu_core=info,naga=info",
    };
    let env = env_logger::Env::default().default_filter_or(filter);
    let logger = env_logger::Builder::from_env(env).format(write_line).build();
    // The window's console shows our own notes too.
    log::set_max_level(logger.filter().max(log::LevelFilter::Info));
    // Fails where a log is running already, which is then as good.
    let _ = log::set_boxed_logger(Box::new(Listener(logger)));
}

/// Mesa's Vulkan layer for choosing a device asks for a desktop's runtime folder, and complains twice where there is none. It
/// chooses nothing then, and so it is left out.
fn silence_device_selection() {
    if cfg!(target_os = "linux") && std::env::var_os("XDG_RUNTIME_DIR").is_none() {
        // Sound while no other thread reads the environment: this is called first of all.
        #[allow(unsafe_code)]
        unsafe {
            std::env::set_var("NODEVICE_SELECT", "1");
        }
    }
}

/// Runs `work` and gives the warnings that this thread logged meanwhile, which go nowhere else.
pub fn catching<T>(work: impl FnOnce() -> T) -> (T, Vec<String>) {
    CAUGHT.with_borrow_mut(|caught| *caught = Some(Vec::new()));
    let result = work();
    (result, CAUGHT.take().unwrap_or_default())
}

/// Writes a message as a line with its time and level; further lines of it stand a little to the right.
fn write_line(out: &mut env_logger::fmt::Formatter, record: &Record) -> io::Result<()> {
    let style = out.default_level_style(record.level());
    let text = record.args().to_string().replace('\n', "\n    ");
    writeln!(out, "[{} {style}{:<5}{style:#}] {text}", in_utc(SystemTime::now()), record.level())
}

/// A time as `YYYY-MM-DDThh:mm:ssZ`. The date is found as H. Hinnant does, "chrono-Compatible Low-Level Date Algorithms",
/// 2014: years begin in March, so that the day that leap years add is their last one.
fn in_utc(time: SystemTime) -> String {
    const DAYS_IN_400_YEARS: u64 = 146_097;
    let seconds = time.duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs());
    // From the first of March of the year 0 on.
    let days = seconds / 86_400 + 719_468;
    let (era, day) = (days / DAYS_IN_400_YEARS, days % DAYS_IN_400_YEARS);
    let year = (day - day / 1460 + day / 36_524 - day / (DAYS_IN_400_YEARS - 1)) / 365;
    let day = day - (365 * year + year / 4 - year / 100);
    let month = (5 * day + 2) / 153;
    let day = day - (153 * month + 2) / 5 + 1;
    let month = if month < 10 { month + 3 } else { month - 9 };
    let year = year + 400 * era + u64::from(month <= 2);
    let [hour, minute, second] = [seconds / 3600 % 24, seconds / 60 % 60, seconds % 60];
    format!("{year:04}-{month:02}-{day:02}T{hour:02}:{minute:02}:{second:02}Z")
}

struct Listener(env_logger::Logger);

impl Listener {
    fn print(&self, record: &Record, printed: bool) {
        if let Some(hook) = HOOK.get() {
            hook(record, printed);
        }
        self.0.log(record);
    }
}

impl Log for Listener {
    fn enabled(&self, metadata: &Metadata) -> bool {
        self.0.enabled(metadata) || metadata.target().starts_with("lightwell")
    }

    fn log(&self, record: &Record) {
        let printed = self.0.matches(record);
        if record.level() != Level::Warn || !printed {
            return self.print(record, printed);
        }
        let is_caught = CAUGHT.with_borrow_mut(|caught| {
            let Some(caught) = caught else { return false };
            caught.push(record.args().to_string());
            true
        });
        if !is_caught {
            self.print(record, printed);
        }
    }

    fn flush(&self) {
        self.0.flush();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    #[test]
    fn times_are_dates() {
        let told = |seconds| in_utc(UNIX_EPOCH + Duration::from_secs(seconds));
        assert_eq!(told(0), "1970-01-01T00:00:00Z");
        assert_eq!(told(951_782_400), "2000-02-29T00:00:00Z");
        assert_eq!(told(1_795_528_776), "2026-11-24T13:59:36Z");
    }
}
