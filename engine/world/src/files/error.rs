//! Errors of files, with their place and help.

use std::fmt;
use std::path::{Path, PathBuf};

/// A place in a text file, both counted from 1; columns in characters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    /// Line.
    pub line: usize,
    /// Column.
    pub column: usize,
}

impl Place {
    /// The place of a byte of the text.
    pub fn of(text: &str, byte: usize) -> Self {
        let mut byte = byte.min(text.len());
        while !text.is_char_boundary(byte) {
            byte -= 1;
        }
        let before = &text[..byte];
        let line_start = before.rfind('\n').map_or(0, |i| i + 1);
        Self { line: before.matches('\n').count() + 1, column: before[line_start..].chars().count() + 1 }
    }
}

/// Kind of a [`FileError`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileErrorKind {
    /// The text is not RON.
    Syntax,
    /// A file of a later version of the format.
    NewerVersion,
    /// A field that the structure does not have.
    UnknownField,
    /// A variant that the choice does not have.
    UnknownVariant,
    /// A field that must be there is not.
    MissingField,
    /// A value of another type, or of another number of elements.
    WrongType,
    /// A value out of its range.
    BadValue,
    /// Two siblings, fields or keys of the same name.
    DuplicateName,
    /// A name (material, path in a prefab, node of a model) that nothing bears.
    UnknownName,
    /// A file that is not there.
    MissingFile,
    /// A third-party model that is not there: the file says where to get it.
    MissingModel,
    /// A file outside of the project and of all that the user trusts.
    Untrusted,
    /// A prefab that contains itself.
    PrefabCycle,
    /// More than a load may take, see [`LoadBudget`](crate::assets::LoadBudget).
    Budget,
    /// A mesh, model or image that could not be loaded.
    Asset,
    /// The file system refused.
    Io,
    /// The world holds something that has no form in a file.
    Unsavable,
}

/// A scene, prefab or model file that cannot be read or written: where, what, and what to do.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub struct FileError {
    /// The file.
    pub file: PathBuf,
    /// Place in the file, where there is one.
    pub place: Option<Place>,
    /// Kind.
    pub kind: FileErrorKind,
    /// The fault.
    pub message: String,
    /// Help.
    pub help: Option<String>,
    /// The line of the file.
    excerpt: Option<Box<str>>,
}

impl FileError {
    /// An error of the whole file.
    pub fn new(file: &Path, kind: FileErrorKind, message: impl Into<String>) -> Self {
        Self { file: file.to_owned(), place: None, kind, message: message.into(), help: None, excerpt: None }
    }

    /// The same with what to do about it.
    pub fn with_help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }

    /// The same at a place of the file's text, with the line quoted.
    pub fn at(mut self, text: &str, place: Place) -> Self {
        self.place = Some(place);
        self.excerpt = text.lines().nth(place.line - 1).map(Into::into);
        self
    }
}

impl fmt::Display for FileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.file.display())?;
        if let Some(Place { line, column }) = self.place {
            write!(f, ":{line}:{column}")?;
        }
        write!(f, ": {}", self.message)?;
        if let (Some(Place { line, column }), Some(excerpt)) = (self.place, &self.excerpt) {
            // A long line is shown around the place only.
            let skip = column.saturating_sub(80);
            let shown: String = excerpt.chars().skip(skip).take(120).map(|c| if c == '\t' { ' ' } else { c }).collect();
            write!(f, "\n{line:>5} | {shown}\n      | {}^", " ".repeat(column - 1 - skip))?;
        }
        if let Some(help) = &self.help {
            write!(f, "\n  help: {help}")?;
        }
        Ok(())
    }
}
