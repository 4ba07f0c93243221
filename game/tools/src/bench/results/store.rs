//! The file of the results, written after each measurement.

use super::{Header, Results};
use anyhow::{Context, Result};
use lightwell::files::replace_file;
use std::path::{Path, PathBuf};

/// The results in their file.
pub struct Store {
    path: PathBuf,
    /// The results.
    pub results: Results,
}

impl Store {
    /// Takes up the results of a folder, or begins new ones.
    ///
    /// # Errors
    /// If the folder holds results of another adapter or program, or cannot be read.
    pub fn open(folder: &Path, header: Header, fresh: bool) -> Result<Self> {
        std::fs::create_dir_all(folder).with_context(|| format!("cannot make the folder {}", folder.display()))?;
        let path = folder.join("results.json");
        let old = if fresh { None } else { read(&path)? };
        let results = match old {
            None => Results { header, ..Results::default() },
            Some(old) => {
                old.header.check_same_source(&header, &path)?;
                Results { header: Header { date: old.header.date.clone(), ..header }, ..old }
            }
        };
        Ok(Self { path, results })
    }

    /// Writes the results in one step.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn save(&self) -> Result<()> {
        let text = serde_json::to_string_pretty(&self.results)?;
        write_whole(&self.path, text.as_bytes())
    }

    /// Adds a note once.
    pub fn note(&mut self, note: String) {
        if !self.results.notes.contains(&note) {
            self.results.notes.push(note);
        }
    }
}

fn read(path: &Path) -> Result<Option<Results>> {
    let text = match std::fs::read_to_string(path) {
        Ok(text) => text,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
        Err(error) => return Err(error).with_context(|| format!("cannot read {}", path.display())),
    };
    let read = serde_json::from_str(&text);
    read.map(Some).with_context(|| format!("{} holds no results; add --fresh to replace it", path.display()))
}

/// Writes a file so that at every moment there is either the old or the whole new one.
///
/// # Errors
/// If it cannot be written.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<()> {
    replace_file(path, bytes).with_context(|| format!("cannot write {}", path.display()))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::bench::results::Flicker;

    #[test]
    fn results_survive_their_file_infinity_included() {
        let dir = tempfile::tempdir().unwrap();
        let mut store = Store::open(dir.path(), Header::default(), false).unwrap();
        store.results.flicker.push(Flicker {
            key: "k".into(),
            scene: "s".into(),
            variant: "v".into(),
            frames: 2,
            change: f64::INFINITY,
            reference: 0.5,
            tremble: Some(0.25),
            smooth: Some(0.125),
            ..Flicker::default()
        });
        store.save().unwrap();
        let again = Store::open(dir.path(), Header::default(), false).unwrap();
        assert_eq!(again.results, store.results);
        assert!(Store::open(dir.path(), Header::default(), true).unwrap().results.flicker.is_empty());
    }

    #[test]
    fn results_of_another_device_or_build_are_not_mixed() {
        let dir = tempfile::tempdir().unwrap();
        Store::open(dir.path(), Header::default(), false).unwrap().save().unwrap();
        for header in [
            Header { adapter: "other".into(), ..Header::default() },
            Header { program: "other".into(), ..Header::default() },
        ] {
            let message = Store::open(dir.path(), header, false).err().unwrap().to_string();
            assert!(message.contains("--fresh"), "{message}");
        }
        std::fs::write(dir.path().join("results.json"), "{").unwrap();
        assert!(Store::open(dir.path(), Header::default(), false).is_err());
    }
}
