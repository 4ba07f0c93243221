//! The error of the picture against the running reference, measured now and then.

use crate::comparison::{Comparison, LiveError};
use anyhow::Result;
use lightwell::scene::SceneView;
use lightwell_runtime::session::Session;
use std::time::{Duration, Instant};

/// Shortest time between two measurements.
const PAUSE: Duration = Duration::from_millis(500);
/// Largest share of all time that is spent on them.
const SHARE: u32 = 4;

/// Measures, and remembers what came of it.
#[derive(Default)]
pub struct Meter {
    /// The last measurement, if it still holds.
    pub error: Option<LiveError>,
    /// What it was made of.
    key: String,
    next: Option<Instant>,
    waits: bool,
}

impl Meter {
    /// Measures the view that was just drawn, if something is new and the last time is long enough ago.
    ///
    /// # Errors
    /// If the device fails.
    pub fn read(&mut self, comparison: &mut Comparison, session: &mut Session, view: &SceneView) -> Result<()> {
        self.waits = false;
        // Two samples at least: one for each half.
        let samples = session.tracing().map(|(samples, _)| samples).filter(|samples| *samples >= 2);
        let Some(samples) = samples.filter(|_| session.compares()) else {
            *self = Self { next: self.next, ..Self::default() };
            return Ok(());
        };
        let (settings, scene) = (session.render_settings(false), session.scene());
        let key = format!("{samples} {settings:?} {:?} {:?} {:?} {view:?}", scene.revisions, scene.vpl, scene.slc);
        if key == self.key {
            return Ok(());
        }
        if self.next.is_some_and(|next| next > Instant::now()) {
            self.waits = true;
            return Ok(());
        }
        let start = Instant::now();
        self.error = Some(comparison.measure(session, view)?);
        self.key = key;
        self.next = Some(Instant::now() + PAUSE.max(SHARE * start.elapsed()));
        Ok(())
    }

    /// When there is something left to measure.
    pub fn due(&self) -> Option<Instant> {
        self.next.filter(|_| self.waits)
    }
}
