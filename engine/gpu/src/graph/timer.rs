//! When the times of passes are read back.

use crate::gpu::{Gpu, TimestampQueries};
use std::collections::{HashMap, VecDeque};

/// Room for the passes of a frame.
const CAPACITY: u32 = 1024;

/// Frames whose times may be on their way at once; those beyond are not timed.
const MOST_FLYING: usize = 4;

/// When a report tells how long passes took on the device.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Timing {
    /// Never: passes are not timed.
    Off,
    /// At once. The frame waits for the device at its end.
    #[default]
    Exact,
    /// Two or three frames later: a report tells the latest time that is known of each pass that ran. No frame waits.
    Late,
}

/// The time of a pass by its name \[ms\], none where the device cannot tell.
pub(super) type Times = Vec<(String, Option<f64>)>;

/// Times the passes of frames.
#[derive(Default)]
pub(super) struct PassTimer {
    pub timing: Timing,
    free: Vec<TimestampQueries>,
    flying: VecDeque<TimestampQueries>,
    latest: HashMap<String, Option<f64>>,
}

impl PassTimer {
    /// The queries of a frame; none if it is not to be timed.
    pub fn begin(&mut self, gpu: &Gpu, passes: usize) -> Option<TimestampQueries> {
        if self.timing == Timing::Off || passes == 0 || self.flying.len() >= MOST_FLYING {
            return None;
        }
        let mut queries = self.free.pop().unwrap_or_else(|| TimestampQueries::new(gpu, CAPACITY));
        queries.reset();
        Some(queries)
    }

    /// Takes back the queries of a frame that was submitted, and gives the times that are known.
    pub fn end(&mut self, gpu: &Gpu, queries: Option<TimestampQueries>) -> Times {
        match (self.timing, queries) {
            (Timing::Late, queries) => self.end_late(gpu, queries),
            (_, Some(mut queries)) => {
                let times = queries.read(gpu);
                self.free.push(queries);
                times
            }
            _ => Times::new(),
        }
    }

    fn end_late(&mut self, gpu: &Gpu, queries: Option<TimestampQueries>) -> Times {
        if let Some(mut queries) = queries {
            queries.request();
            self.flying.push_back(queries);
        }
        while let Some(queries) = self.flying.front_mut() {
            let Some(times) = queries.take(gpu, false) else { break };
            self.latest.extend(times);
            self.free.extend(self.flying.pop_front());
        }
        self.latest.iter().map(|(name, ms)| (name.clone(), *ms)).collect()
    }
}
