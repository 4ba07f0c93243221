//! What a file holds that is changed on import, and what of it is broken.

use crate::assets::AssetError;
use std::path::Path;

/// Remarks on a file, in the order in which they were found.
#[derive(Clone, Debug, Default)]
pub(super) struct Remarks(Vec<Remark>);

#[derive(Clone, Debug)]
struct Remark {
    is_fault: bool,
    text: String,
}

impl Remarks {
    /// Warns of what is valid, and changed or not used.
    pub fn push(&mut self, text: String) {
        self.0.push(Remark { is_fault: false, text });
    }

    /// Warns of several things.
    pub fn extend(&mut self, texts: impl IntoIterator<Item = String>) {
        self.0.extend(texts.into_iter().map(|text| Remark { is_fault: false, text }));
    }

    /// Notes something broken that was mended or left out.
    pub fn fault(&mut self, text: String) {
        self.0.push(Remark { is_fault: true, text });
    }

    /// Takes over the remarks on a part.
    pub fn append(&mut self, others: Self) {
        self.0.extend(others.0);
    }

    /// The result of reading a part; none where it is broken, which is noted. `outcome` says what becomes of it.
    ///
    /// # Errors
    /// What goes beyond the budget of the load: no part's fault.
    pub fn part<T>(&mut self, result: Result<T, AssetError>, outcome: &str) -> Result<Option<T>, AssetError> {
        match result {
            Ok(value) => Ok(Some(value)),
            Err(error @ AssetError::Budget { .. }) => Err(error),
            Err(error) => {
                self.broken(&error, outcome);
                Ok(None)
            }
        }
    }

    /// Notes the fault of a part, and what becomes of it.
    pub fn broken(&mut self, error: &AssetError, outcome: &str) {
        self.fault(format!("{}; {outcome}", without_path(error)));
    }

    /// Notes the fault of something that nothing may use: only if no part has said so.
    pub fn unused(&mut self, error: &AssetError) {
        let text = without_path(error);
        if self.0.len() < MOST && !self.0.iter().any(|remark| remark.text.contains(&text)) {
            self.fault(text);
        }
    }

    /// Logs the remarks, the first ones of many. Returns them, and which of them are faults.
    pub fn finish(self, path: &Path) -> (Vec<String>, Vec<String>) {
        let surplus = self.0.len().saturating_sub(MOST);
        let faults = self.0.iter().filter(|remark| remark.is_fault).map(|remark| remark.text.clone()).collect();
        // Faults come first, so that remarks on valid content do not hide them.
        let (broken, valid): (Vec<_>, Vec<_>) = self.0.into_iter().partition(|remark| remark.is_fault);
        let mut lines: Vec<String> = broken.into_iter().chain(valid).take(MOST).map(|remark| remark.text).collect();
        if surplus > 0 {
            lines.push(format!("and {surplus} more remarks"));
        }
        for line in &lines {
            log::warn!("{}: {line}", path.display());
        }
        (lines, faults)
    }
}

/// Most remarks that are kept.
const MOST: usize = 40;

/// The message of an error without the file, which each remark is shown with.
fn without_path(error: &AssetError) -> String {
    match error {
        AssetError::Format { place, problem, .. } => format!("{place}: {problem}"),
        other => other.to_string(),
    }
}
