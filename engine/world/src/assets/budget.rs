//! Limits of one load: a small file can ask for more than any machine has.

use super::AssetError;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};

/// Limits of one load as a whole: a scene with all that it names, or an edit. What is loaded already and used again
/// counts for nothing. The defaults hold scenes ten times as large as Sponza.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LoadBudget {
    /// Size of all files that are read \[bytes\].
    pub bytes: u64,
    /// Texels of all images, decoded; each takes four bytes.
    pub texels: u64,
    /// Triangles of all meshes; shared ones count once.
    pub triangles: u64,
    /// Entities, nodes of models included.
    pub entities: u64,
    /// Time \[s\]. It is looked at before each entity.
    pub seconds: u64,
}

impl Default for LoadBudget {
    fn default() -> Self {
        Self { bytes: 8 << 30, texels: 2_000_000_000, triangles: 100_000_000, entities: 200_000, seconds: 600 }
    }
}

impl LoadBudget {
    /// Sets a limit by its name, as `texels=4e9`.
    ///
    /// # Errors
    /// When there is no limit of that name, or the value is no whole number above zero.
    pub fn set(&mut self, written: &str) -> Result<(), String> {
        let (name, value) = written.split_once('=').ok_or("write NAME=N, such as texels=4e9")?;
        let limit = match name.trim() {
            "bytes" => &mut self.bytes,
            "texels" => &mut self.texels,
            "triangles" => &mut self.triangles,
            "entities" => &mut self.entities,
            "seconds" => &mut self.seconds,
            other => return Err(format!("no limit `{other}`: bytes, texels, triangles, entities, seconds")),
        };
        let value = f64::from_str(value.trim()).ok().filter(|value| *value >= 1.0 && *value < u64::MAX as f64);
        *limit = value.ok_or_else(|| format!("`{written}`: write a number of 1 or more, such as 4e9"))? as u64;
        Ok(())
    }
}

/// How much of a budget is spent.
#[derive(Debug, Default)]
pub(crate) struct Meter {
    budget: LoadBudget,
    bytes: AtomicU64,
    texels: AtomicU64,
    triangles: AtomicU64,
    /// Files that were asked for, whether they are there or not.
    asked: Mutex<BTreeSet<PathBuf>>,
}

impl Meter {
    pub fn new(budget: &LoadBudget) -> Self {
        Self { budget: budget.clone(), ..Self::default() }
    }

    /// The limits.
    pub fn budget(&self) -> &LoadBudget {
        &self.budget
    }

    /// Notes a file that is looked for.
    pub fn ask(&self, path: &Path) {
        let path = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
        self.asked.lock().unwrap_or_else(PoisonError::into_inner).insert(path);
    }

    /// The files that were looked for, as they were named.
    pub fn asked(&self) -> BTreeSet<PathBuf> {
        self.asked.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Before a file is read.
    pub fn bytes(&self, path: &Path, more: u64) -> Result<(), AssetError> {
        spend(&self.bytes, more, self.budget.bytes, "bytes", path)
    }

    /// Before an image is decoded.
    pub fn texels(&self, path: &Path, [width, height]: [u32; 2]) -> Result<(), AssetError> {
        spend(&self.texels, u64::from(width) * u64::from(height), self.budget.texels, "texels", path)
    }

    /// Before a mesh is made, as far as its size is known by then.
    pub fn triangles(&self, path: &Path, more: u64) -> Result<(), AssetError> {
        spend(&self.triangles, more, self.budget.triangles, "triangles", path)
    }
}

fn spend(spent: &AtomicU64, more: u64, most: u64, limit: &'static str, path: &Path) -> Result<(), AssetError> {
    let before = spent.fetch_update(Ordering::Relaxed, Ordering::Relaxed, |spent| Some(spent.saturating_add(more)));
    let total = before.unwrap_or_else(|spent| spent).saturating_add(more);
    if total <= most { Ok(()) } else { Err(AssetError::Budget { path: path.to_owned(), limit, total, most }) }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn limits_are_set_by_name() {
        let mut budget = LoadBudget::default();
        budget.set("texels=4e9").unwrap();
        budget.set("seconds = 20").unwrap();
        assert_eq!(budget, LoadBudget { texels: 4_000_000_000, seconds: 20, ..LoadBudget::default() });
        for wrong in ["texels", "texels=", "texels=-1", "texels=0", "texels=NaN", "texel=1", "bytes=1e99"] {
            assert!(budget.set(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn what_is_spent_adds_up() {
        let meter = Meter::new(&LoadBudget { texels: 20, ..LoadBudget::default() });
        let path = Path::new("a.png");
        meter.texels(path, [4, 4]).unwrap();
        meter.bytes(path, 1000).unwrap();
        let message = meter.texels(path, [1, 5]).unwrap_err().to_string();
        assert!(message.contains("a.png") && message.contains("21 texels") && message.contains("20"), "{message}");
        assert!(meter.texels(path, [u32::MAX, u32::MAX]).is_err());
    }
}
