//! Images one after the other: while one is drawn, that before it comes back from the device, and those before that
//! are written.

use crate::shot::{Shot, Taken};
use crate::still::Tally;
use anyhow::Result;
use lightwell::graph::Timing;
use lightwell_runtime::session::Session;
use lightwell_runtime::writer::Writer;
use std::path::PathBuf;

/// Images on their way into files.
pub struct Sequence {
    writer: Writer,
    last: Option<(PathBuf, Taken)>,
    tally: Tally,
}

impl Sequence {
    /// Nothing yet. The session measures no times of passes from now on: it would wait for the device to read them.
    ///
    /// # Errors
    /// If the system gives no thread to write with.
    pub fn start(session: &mut Session) -> Result<Self> {
        session.rendering.renderer.set_timing(Timing::Off);
        Ok(Self { writer: Writer::start()?, last: None, tally: Tally::default() })
    }

    /// Draws the scene as it stands, for a file.
    ///
    /// # Errors
    /// If the scene cannot be drawn, or an earlier image cannot be read back or written.
    pub fn take(&mut self, path: PathBuf, shot: &Shot, session: &mut Session) -> Result<()> {
        let (taken, outcome) = shot.begin(session, &mut |_| ())?;
        if let Some(outcome) = outcome {
            self.tally.add(outcome);
        }
        match self.last.replace((path, taken)) {
            Some((path, before)) => self.writer.write(path, before.finish(&session.gpu)?),
            None => Ok(()),
        }
    }

    /// Waits until all are written, and says what became of those that were averaged.
    ///
    /// # Errors
    /// If one cannot be read back or written.
    pub fn finish(mut self, session: &Session) -> Result<Tally> {
        if let Some((path, last)) = self.last.take() {
            self.writer.write(path, last.finish(&session.gpu)?)?;
        }
        self.writer.finish()?;
        Ok(self.tally)
    }
}
