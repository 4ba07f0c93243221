//! The results of a run: `results.json`.

mod figures;
pub mod finite;
mod store;

pub use figures::*;
pub use store::{Store, write_whole};

use super::growth::{Growth, Pair};
use anyhow::{Context, Result, bail};
use serde::de::DeserializeOwned;
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

    /// The beginning of a report in Markdown, after its title: where, by what command and in what settings it was measured.
    pub fn in_words(&self) -> String {
        let commit = self.commit.as_deref().unwrap_or("unknown");
        format!(
            "{}, {} ({}); {}; commit {commit}, {}.\n\n```sh\n{}\n```\n\n{}.\n\n",
            self.adapter, self.driver, self.device_type, self.system, self.date, self.command, self.settings
        )
    }
}

/// The results of an interrupted run, to be continued under a new header that keeps their date. None: there are none, or a
/// `fresh` run is wanted.
///
/// # Errors
/// If the file holds no such results, or those of another adapter, driver or program.
pub fn take_up<R: DeserializeOwned>(
    file: &Path,
    header: &Header,
    fresh: bool,
    header_of: impl Fn(&mut R) -> &mut Header,
) -> Result<Option<R>> {
    let text = match std::fs::read_to_string(file) {
        Ok(text) if !fresh => text,
        _ => return Ok(None),
    };
    let mut old: R = serde_json::from_str(&text)
        .with_context(|| format!("{} holds no results; add --fresh to replace it", file.display()))?;
    let before = header_of(&mut old);
    before.check_same_source(header, file)?;
    *before = Header { date: before.date.clone(), ..header.clone() };
    Ok(Some(old))
}
