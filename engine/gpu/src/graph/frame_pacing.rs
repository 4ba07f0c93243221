//! How a frame shares the device with others while it is made, and how far it is.

use super::report::FrameReport;
use crate::gpu::Gpu;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::Duration;

/// How often the device is asked whether it is done.
const GLANCE: Duration = Duration::from_micros(500);

/// Passes that take longer than this on the device make an interface wait for too long \[ms\].
pub(super) const LONG_PASS: f64 = 10.0;

/// Shared by the thread that makes frames and those that watch: whether others get their turn in between, how far the
/// frame is, and whether it is still wanted.
///
/// A device works off what was submitted in its order. An interruptible frame submits few passes at once: so many as took 10 ms
/// together in the frame before, and has two such submits under way at most, so that an interface whose frames come between
/// waits for those and not for the frame. Only software drivers are paced:
/// a graphics card is through with a frame before the waits alone would be.
#[derive(Debug, Default)]
pub struct FramePacing {
    is_software: bool,
    interruptible: AtomicBool,
    unwanted: AtomicBool,
    dropped: AtomicBool,
    done: AtomicUsize,
    count: AtomicUsize,
}

impl FramePacing {
    /// The frame pacing of that adapter. It begins interruptible where the driver is software, whose first frame is long.
    pub fn new(adapter: &wgpu::AdapterInfo) -> Self {
        let pacing = Self { is_software: adapter.device_type == wgpu::DeviceType::Cpu, ..Self::default() };
        pacing.set_interruptible(true);
        pacing
    }

    /// Sets whether work of others gets its turn between the passes. Without a software driver it never does.
    pub fn set_interruptible(&self, interruptible: bool) {
        self.interruptible.store(interruptible && self.is_software, Ordering::Relaxed);
    }

    /// Chooses the pacing of the next frame by the longest pass of the last one on the device. The time of the whole frame
    /// would not do: it holds the compiling of pipelines, and the waits of the interruptible pacing itself. Where the device
    /// cannot tell times, the pacing stays.
    pub fn adapt(&self, report: &FrameReport) {
        let times = report.passes.iter().filter_map(|pass| pass.gpu_ms);
        if let Some(longest) = times.max_by(f64::total_cmp) {
            self.set_interruptible(longest > LONG_PASS);
        }
    }

    /// Ends the frame that is being made, and all that follow, after the pass that runs.
    pub fn stop(&self) {
        self.unwanted.store(true, Ordering::Relaxed);
    }

    /// Ends the frame that is being made after the pass that runs; the next one is wanted again.
    pub fn drop_frame(&self) {
        self.dropped.store(true, Ordering::Relaxed);
    }

    /// Passes of the frame that are done, and all that run.
    pub fn progress(&self) -> (usize, usize) {
        (self.done.load(Ordering::Relaxed), self.count.load(Ordering::Relaxed))
    }

    /// Another frame begins, and how many passes run is not known yet: zero.
    pub fn restart(&self) {
        self.dropped.store(false, Ordering::Relaxed);
        self.begin(0);
    }

    pub(super) fn begin(&self, count: usize) {
        self.done.store(0, Ordering::Relaxed);
        self.count.store(count, Ordering::Relaxed);
    }

    pub(super) fn step(&self) {
        self.done.fetch_add(1, Ordering::Relaxed);
    }

    /// Whether work of others gets its turn between the passes.
    pub fn is_interruptible(&self) -> bool {
        self.interruptible.load(Ordering::Relaxed)
    }

    pub(super) fn is_stopped(&self) -> bool {
        self.unwanted.load(Ordering::Relaxed) || self.dropped.load(Ordering::Relaxed)
    }
}

/// Tells that work is done when it is dropped. `wgpu` waits for all work before it configures a surface, and drops the calls
/// for that work unmade where more was submitted meanwhile.
struct Told(Arc<AtomicBool>);

impl Drop for Told {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Release);
    }
}

/// All that was submitted up to a moment.
pub(super) struct Submitted(Arc<AtomicBool>);

impl Submitted {
    /// All that was submitted until now.
    pub fn note(gpu: &Gpu) -> Self {
        let done = Arc::new(AtomicBool::new(false));
        let told = Told(Arc::clone(&done));
        gpu.queue.on_submitted_work_done(move || drop(told));
        Self(done)
    }

    /// Waits until it is done, without holding the device: others submit meanwhile.
    pub fn wait(self, gpu: &Gpu) {
        gpu.count(|counts| counts.waits += 1);
        while !self.0.load(Ordering::Acquire) {
            if gpu.device.poll(wgpu::PollType::Poll).is_err() || gpu.device_lost().is_some() {
                return;
            }
            std::thread::sleep(GLANCE);
        }
    }
}
