//! The results of a run: `results.json`.

mod figures;
pub mod finite;
mod store;

pub use figures::*;
pub use store::{Store, write_whole};

use super::growth::{Growth, Pair};
use anyhow::{Result, bail};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Everything that a run found. Every finished measurement is written at once, so that a run can be taken up again.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Results {
    /// Where and with what it was measured.
    pub header: Header,
    /// The variants.
    pub variants: Vec<VariantFigures>,
    /// The scenes.
    pub scenes: Vec<SceneFigures>,
    /// Times, counts and memory.
    pub timings: Vec<Timing>,
    /// Errors against the reference.
    pub errors: Vec<ErrorFigures>,
    /// Frame-to-frame change beyond the reference's own.
    pub flicker: Vec<Flicker>,
    /// Path tracing on the device against the host.
    pub throughput: Vec<ThroughputFigures>,
    /// How cost grows with what a scene holds.
    #[serde(default)]
    pub growth: Vec<Growth>,
    /// Pairs of scenes whose ratio is bounded.
    #[serde(default)]
    pub pairs: Vec<Pair>,
    /// Notes for the reader.
    pub notes: Vec<String>,
}

/// Where and with what a run was measured.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Header {
    /// The graphics adapter.
    pub adapter: String,
    /// Its kind: `DiscreteGpu`, `Cpu`, …
    pub device_type: String,
    /// Its driver and the driver's version.
    pub driver: String,
    /// The graphics interface.
    pub backend: String,
    /// Operating system, processor kind and number of threads.
    pub system: String,
    /// Version of the program.
    pub version: String,
    /// Commit of the source tree, with `-dirty` where files differ from it.
    pub commit: Option<String>,
    /// Hash of the program and its shaders.
    pub program: String,
    /// When the run began (UTC).
    pub date: String,
    /// The settings of the last run, in words.
    pub settings: String,
    /// The last run's command line.
    #[serde(default)]
    pub command: String,
}

impl Header {
    /// Checks that results may be added to those that `path` holds under this header.
    ///
    /// # Errors
    /// If they come of another adapter, driver or program.
    pub fn check_same_source(&self, now: &Self, path: &Path) -> Result<()> {
        for (what, then, now) in [
            ("adapter", &self.adapter, &now.adapter),
            ("driver", &self.driver, &now.driver),
            ("build of the program or its shaders", &self.program, &now.program),
        ] {
            if then != now {
                bail!(
                    "{} holds results of another {what} ({then}, now {now}); add --fresh to replace them, or give another \
                     folder",
                    path.display()
                );
            }
        }
        Ok(())
    }
}
