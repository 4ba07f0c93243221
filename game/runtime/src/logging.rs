//! The program's log on its error stream, and warnings caught while something is tried.

use log::{Level, Log, Metadata, Record};
use std::cell::RefCell;
use std::sync::OnceLock;

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
pub fn start(verbose: u8) {
    let filter = match verbose {
        0 => "warn,wgpu=error,wgpu_hal=error,wgpu_core=error,naga=error,winit=error",
        1 => "info,wgpu=warn,wgpu_hal=error,wgpu_core=warn,naga=warn",
        _ => "debug,wgpu=info,wgpu_hal=warn,wgpu_core=info,naga=info",
    };
    let env = env_logger::Env::default().default_filter_or(filter);
    let logger = env_logger::Builder::from_env(env).format_target(false).build();
    // The window's console shows our own notes too.
    log::set_max_level(logger.filter().max(log::LevelFilter::Info));
    // Fails where a log is running already, which is then as good.
    let _ = log::set_boxed_logger(Box::new(Listener(logger)));
}

/// Runs `work` and gives the warnings that this thread logged meanwhile, which go nowhere else.
pub fn catching<T>(work: impl FnOnce() -> T) -> (T, Vec<String>) {
    CAUGHT.with_borrow_mut(|caught| *caught = Some(Vec::new()));
    let result = work();
    (result, CAUGHT.take().unwrap_or_default())
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
