//! Runs many scene tests side by side, each worker with its own device.

use super::discover::TestCase;
use super::run::{Options, Outcome, Report, run};
use std::num::NonZeroUsize;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc;
use std::time::Duration;
use sysinfo::{MemoryRefreshKind, RefreshKind, System};

/// Memory that a worker is reckoned with \[bytes\]: its device with all pipelines takes a third of it on a software
/// driver; the rest is for textures of large scenes.
const BYTES_A_WORKER: u64 = 1 << 30;

/// Number of workers that the cores and the free memory are enough for.
pub fn default_workers() -> usize {
    let cores = std::thread::available_parallelism().map_or(1, NonZeroUsize::get);
    let kind = RefreshKind::nothing().with_memory(MemoryRefreshKind::nothing().with_ram());
    let free = System::new_with_specifics(kind).map_or(0, |system| system.available_memory());
    // Where the system does not tell, the cores decide.
    let fit = if free > 0 { usize::try_from(free / BYTES_A_WORKER).unwrap_or(cores) } else { cores };
    cores.min(fit).max(1)
}

/// Runs all tests with so many workers; `done` is told of each as it ends. The reports are in the order of the tests.
pub fn run_all(
    cases: &[TestCase],
    options: &Options,
    workers: usize,
    done: &mut dyn FnMut(&TestCase, &Report),
) -> Vec<Report> {
    let next = AtomicUsize::new(0);
    let (sender, receiver) = mpsc::channel();
    let mut reports: Vec<Option<Report>> = vec![None; cases.len()];
    std::thread::scope(|scope| {
        for _ in 0..workers.min(cases.len()) {
            let (sender, next) = (sender.clone(), &next);
            scope.spawn(move || {
                let mut device = None;
                while let Some((index, case)) = take(cases, next) {
                    let report = catch_unwind(AssertUnwindSafe(|| run(case, options, &mut device)));
                    let report = report.unwrap_or_else(|_| panicked());
                    if sender.send((index, report)).is_err() {
                        return;
                    }
                }
            });
        }
        drop(sender);
        for (index, report) in receiver {
            done(&cases[index], &report);
            reports[index] = Some(report);
        }
    });
    reports.into_iter().flatten().collect()
}

/// The next test that nobody has taken.
fn take<'a>(cases: &'a [TestCase], next: &AtomicUsize) -> Option<(usize, &'a TestCase)> {
    let index = next.fetch_add(1, Ordering::Relaxed);
    cases.get(index).map(|case| (index, case))
}

fn panicked() -> Report {
    let what = "the program panicked: this is a defect of Lightwell; the message is above".to_owned();
    Report { outcome: Outcome::Failed(vec![what]), blessed: Vec::new(), elapsed: Duration::ZERO }
}
