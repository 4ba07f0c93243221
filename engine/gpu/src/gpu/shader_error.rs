//! Errors of shaders, with their place.

use wgpu::naga;

/// A shader that does not compile. Shows file, line, column and an excerpt.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{text}")]
pub struct ShaderError {
    /// The WGSL file that is at fault, relative to the shader folder: the shader itself or one that it imports.
    pub file: String,
    /// Line, from 1; 0 where no place is known.
    pub line: u32,
    /// Column, from 1; 0 where no place is known.
    pub column: u32,
    /// The whole message with its excerpt.
    pub text: String,
}

impl ShaderError {
    /// An error without a place in the file.
    pub(super) fn of_file(file: &str, what: impl std::fmt::Display) -> Self {
        Self { file: file.into(), line: 0, column: 0, text: format!("shader {file}: {what}") }
    }

    /// From the composer's error: its report names file, line and column as `┌─ FILE:LINE:COLUMN`.
    pub(super) fn of_report(shader: &str, report: &str) -> Self {
        let place = report.lines().find_map(|line| line.split_once("┌─ ")).map(|(_, place)| place.trim());
        let mut parts = place.unwrap_or_default().rsplitn(3, ':');
        let mut number = || parts.next().and_then(|n| n.parse().ok()).unwrap_or(0);
        let (column, line) = (number(), number());
        let (line, column) = first_shown(report, line).unwrap_or((line, column));
        let file = parts.next().unwrap_or(shader).to_string();
        let text = if line == 0 {
            format!("shader {shader}: {report}")
        } else if file == shader {
            format!("shader {shader}:{line}:{column}: {report}")
        } else {
            format!("shader {shader} imports {file}:{line}:{column}: {report}")
        };
        Self { file, line, column, text }
    }

    /// From the validator, on a module that was already put together.
    pub(super) fn of_validation(shader: &str, error: &naga::WithSpan<naga::valid::ValidationError>) -> Self {
        use std::error::Error;
        let mut text = error.as_inner().to_string();
        let mut source = error.as_inner().source();
        while let Some(inner) = source {
            text = format!("{text}: {inner}");
            source = inner.source();
        }
        Self::of_file(shader, text)
    }
}

/// Where the excerpt's first line with text is, if the named line shows as blank: the compiler names the start of the
/// file for what stands nowhere (a type that was inferred), and shows the real place further down.
fn first_shown(report: &str, named: u32) -> Option<(u32, u32)> {
    let numbered = |line: &str| {
        let (number, text) = line.split_once(" │ ")?;
        Some((number.trim().parse::<u32>().ok()?, text.to_string()))
    };
    let shown: Vec<(u32, String)> = report.lines().filter_map(numbered).collect();
    if shown.iter().any(|(number, text)| *number == named && !text.trim().is_empty()) {
        return None;
    }
    let (number, text) = shown.into_iter().find(|(_, text)| !text.trim().is_empty())?;
    let indent = text.chars().take_while(|c| c.is_whitespace()).count();
    Some((number, indent as u32 + 1))
}
