//! How a frame shares the device with others while it is made, and how far it is.

use crate::gpu::Gpu;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::Duration;

/// How often the device is asked whether it is done.
const GLANCE: Duration = Duration::from_micros(500);

/// Shared by the thread that makes frames and those that watch: whether others get their turn in between, how far the
/// frame is, and whether it is still wanted.
///
/// A device works off what was submitted in its order. A gentle frame submits each pass by itself and waits for it, so
/// that an interface whose frames come between waits for a pass and not for the frame.
#[derive(Debug, Default)]
pub struct Pace {
    gentle: AtomicBool,
    unwanted: AtomicBool,
    done: AtomicUsize,
    count: AtomicUsize,
}

impl Pace {
    /// Whether work of others gets its turn between the passes. It costs little where passes take long.
    pub fn set_gentle(&self, gentle: bool) {
        self.gentle.store(gentle, Ordering::Relaxed);
    }

    /// Ends the frame that is being made, and all that follow, after the pass that runs.
    pub fn stop(&self) {
        self.unwanted.store(true, Ordering::Relaxed);
    }

    /// Passes of the frame that are done, and all that run.
    pub fn progress(&self) -> (usize, usize) {
        (self.done.load(Ordering::Relaxed), self.count.load(Ordering::Relaxed))
    }

    /// Another frame begins, and how many passes run is not known yet: zero.
    pub fn restart(&self) {
        self.begin(0);
    }

    pub(super) fn begin(&self, count: usize) {
        self.done.store(0, Ordering::Relaxed);
        self.count.store(count, Ordering::Relaxed);
    }

    pub(super) fn step(&self) {
        self.done.fetch_add(1, Ordering::Relaxed);
    }

    pub(super) fn is_gentle(&self) -> bool {
        self.gentle.load(Ordering::Relaxed)
    }

    pub(super) fn is_stopped(&self) -> bool {
        self.unwanted.load(Ordering::Relaxed)
    }
}

/// Waits for all that was submitted, without holding the device: others submit meanwhile.
pub(super) fn wait_gently(gpu: &Gpu) {
    let done = Arc::new(AtomicBool::new(false));
    let told = Arc::clone(&done);
    gpu.queue.on_submitted_work_done(move || told.store(true, Ordering::Release));
    while !done.load(Ordering::Acquire) {
        if gpu.device.poll(wgpu::PollType::Poll).is_err() || gpu.device_lost().is_some() {
            return;
        }
        std::thread::sleep(GLANCE);
    }
}
