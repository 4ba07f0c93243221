//! The report: tables, plots and words, all made from `results.json` alone.

mod charts;
mod facts;
mod flicker;
mod growth;
pub(super) mod markdown;
mod sections;
mod sweeps;
mod tables;
mod words;

use super::results::{Results, write_whole};
use anyhow::Result;
use std::path::{Path, PathBuf};

/// A part of the report; none where there is nothing to say.
type Section = fn(&Results) -> Option<String>;

/// The parts in their order. A new one is a line here.
const SECTIONS: &[Section] = &[
    sections::head,
    words::verdict,
    charts::time_error_section,
    tables::errors,
    tables::traced,
    tables::scenes,
    tables::times,
    tables::counts,
    tables::memory,
    sweeps::section,
    flicker::section,
    sections::throughput,
    growth::section,
    growth::pairs,
    sections::pictures,
    sections::method,
];

/// Writes the plots and the report into the folder; gives the report's path.
///
/// # Errors
/// If a file cannot be written.
pub fn write(folder: &Path, results: &Results) -> Result<PathBuf> {
    charts::draw(folder, results)?;
    sweeps::draw(folder, results)?;
    growth::draw(folder, results)?;
    let path = folder.join("report.md");
    write_whole(&path, text(results).as_bytes())?;
    Ok(path)
}

/// The text of the report.
pub fn text(results: &Results) -> String {
    let parts: Vec<String> = SECTIONS.iter().filter_map(|section| section(results)).collect();
    parts.join("\n")
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::bench::results::Results;

    fn fixture() -> Results {
        serde_json::from_str(include_str!("fixture.json")).unwrap()
    }

    /// A run with LIGHTWELL_BLESS set rewrites the golden text: look at it before it is committed.
    #[test]
    fn the_report_is_the_golden_one() {
        let text = text(&fixture());
        let golden = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/bench/report/golden.md");
        if std::env::var_os("LIGHTWELL_BLESS").is_some() {
            std::fs::write(&golden, &text).unwrap();
        }
        let expected = std::fs::read_to_string(&golden).unwrap();
        for (line, (found, expected)) in text.lines().zip(expected.lines()).enumerate() {
            assert_eq!(found, expected, "line {}", line + 1);
        }
        assert_eq!(text.lines().count(), expected.lines().count());
    }

    #[test]
    fn every_picture_that_the_report_names_by_itself_is_drawn() {
        let dir = tempfile::tempdir().unwrap();
        let report = write(dir.path(), &fixture()).unwrap();
        let text = std::fs::read_to_string(report).unwrap();
        let plots: Vec<&str> = text.split("](").skip(1).filter_map(|rest| rest.split(')').next()).collect();
        let plots: Vec<&str> =
            plots.into_iter().filter(|file| file.starts_with("plots/") && !file.ends_with("_row.png")).collect();
        assert!(plots.len() >= 5, "{plots:?}");
        plots.iter().for_each(|file| assert!(dir.path().join(file).is_file(), "{file}"));
    }

    #[test]
    fn nothing_measured_is_a_report_too() {
        assert!(text(&Results::default()).starts_with("# Time against error"));
    }
}
