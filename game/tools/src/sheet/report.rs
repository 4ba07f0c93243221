//! The figures of all cells as text.

use super::cell::Cell;
use super::subject::Subject;
use anyhow::{Context, Result};
use std::fmt::Write;
use std::path::Path;

/// Writes the report; gives its summary.
///
/// # Errors
/// If the file cannot be written.
pub fn write(path: &Path, subjects: &[Subject], cells: &[Cell]) -> Result<String> {
    let summary = summary(cells);
    let text = format!("{summary}\n\n{}", lines(subjects, cells));
    std::fs::write(path, text).with_context(|| format!("cannot write {}", path.display()))?;
    Ok(summary)
}

fn summary(cells: &[Cell]) -> String {
    let failed = cells.iter().filter(|cell| cell.error.is_some()).count();
    let warned = cells.iter().filter(|cell| cell.error.is_none() && !cell.warnings.is_empty()).count();
    format!("{} files: {} drawn ({warned} with warnings), {failed} with errors", cells.len(), cells.len() - failed)
}

fn lines(subjects: &[Subject], cells: &[Cell]) -> String {
    let width = subjects.iter().map(|subject| subject.name.chars().count()).max().unwrap_or(4);
    let mut text = format!("{:width$}  result  triangles  primitives  load [ms]  first frame [ms]\n", "name");
    for (subject, cell) in subjects.iter().zip(cells) {
        let result = match (&cell.error, cell.warnings.len()) {
            (Some(_), _) => "error",
            (None, 0) => "ok",
            (None, _) => "warned",
        };
        let ms = |time: std::time::Duration| 1e3 * time.as_secs_f64();
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "{:width$}  {result:6}  {:9}  {:10}  {:9.1}  {:16.1}",
            subject.name,
            cell.triangles,
            cell.primitives,
            ms(cell.loading),
            ms(cell.drawing)
        );
        for message in cell.error.iter().map(|m| ("error", m)).chain(cell.warnings.iter().map(|m| ("warning", m))) {
            let _ = writeln!(text, "    {}: {}", message.0, message.1.replace('\n', "\n        "));
        }
    }
    text
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn every_cell_has_its_line() {
        let subject = |name: &str| Subject { name: name.into(), path: name.into() };
        let bad = Cell { error: Some("no such buffer".into()), ..Cell::default() };
        let warned = Cell { warnings: vec!["odd".into()], triangles: 12, ..Cell::default() };
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.txt");
        let summary =
            write(&path, &[subject("a"), subject("b"), subject("c")], &[bad, warned, Cell::default()]).unwrap();
        assert_eq!(summary, "3 files: 2 drawn (1 with warnings), 1 with errors");
        let text = std::fs::read_to_string(path).unwrap();
        assert!(text.contains("    error: no such buffer\n") && text.contains("    warning: odd\n"), "{text}");
        assert_eq!(text.lines().count(), 3 + 3 + 2, "{text}");
    }
}
