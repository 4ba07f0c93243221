//! A text file while it is read: parsed values, and the way from a value back to its line and column.

use super::scan::block_comment;
use super::suggest::suggestion;
use super::tree::{Node, Step};
use crate::assets::AssetError;
use crate::files::error::{FileError, FileErrorKind, Place};
use ron::error::{Error as Ron, SpannedError};
use serde::de::DeserializeOwned;
use std::borrow::Cow;
use std::cell::OnceCell;
use std::io::Read;
use std::path::{Path, PathBuf};

/// Version of the format that this program reads and writes.
pub const VERSION: u32 = 1;

/// How all our RON files are read and written: `Some(…)` need not be written, nor the brackets of newtypes.
pub fn ron_options() -> ron::Options {
    crate::world::fields::ron_options()
}

/// Largest text that is read \[bytes\].
const MAX_TEXT: u64 = 256 << 20;

/// The file's content, or its start where it is too large. Devices have no end.
fn read_limited(path: &Path) -> std::io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    std::fs::File::open(path)?.take(MAX_TEXT + 1).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// The text of a file that is there and can be read.
pub fn read_text(path: &Path) -> Option<String> {
    let bytes = path.is_file().then(|| read_limited(path).ok()).flatten()?;
    String::from_utf8(bytes).ok().filter(|text| text.len() as u64 <= MAX_TEXT)
}

/// A text file with the shape of its values.
pub struct Document {
    /// Where it lies.
    pub path: PathBuf,
    /// Its text.
    pub text: String,
    /// Whether a byte order mark stands before it.
    has_mark: bool,
    /// Made when the first place is asked for: it takes more memory than all that a large scene holds.
    tree: OnceCell<Node>,
}

impl Document {
    /// Reads and parses a file.
    pub fn read<T: DeserializeOwned>(path: &Path) -> Result<(Self, T), FileError> {
        let bytes = read_limited(path).map_err(|e| io_error(path, "cannot be read", &e))?;
        if bytes.len() as u64 > MAX_TEXT {
            let message = format!("is larger than {MAX_TEXT} bytes, which is too much for such a file");
            return Err(FileError::new(path, FileErrorKind::Budget, message)
                .with_help("move parts of it into prefabs, or meshes into a model"));
        }
        let text = String::from_utf8(bytes).map_err(|e| {
            let valid = e.utf8_error().valid_up_to();
            let text = String::from_utf8_lossy(e.as_bytes()).into_owned();
            let place = Place::of(&text, valid);
            FileError::new(path, FileErrorKind::Syntax, "not valid UTF-8 text")
                .with_help("such files are text; save this one as UTF-8")
                .at(&text, place)
        })?;
        Self::parse(path, text)
    }

    /// Parses a file's text. A byte order mark at the start is passed over.
    pub fn parse<T: DeserializeOwned>(path: &Path, text: String) -> Result<(Self, T), FileError> {
        let plain = text.strip_prefix('\u{feff}').map(str::to_owned);
        let has_mark = plain.is_some();
        let text = plain.unwrap_or(text);
        check_version(path, &text)?;
        let value = ron_options().from_str(&text).map_err(|e| syntax_error(path, &text, e))?;
        Ok((Self { path: path.to_owned(), text, has_mark, tree: OnceCell::new() }, value))
    }

    /// Stands for a file whose values were made in memory: errors name the file and no place.
    pub fn in_memory(path: &Path) -> Self {
        Self { path: path.to_owned(), text: String::new(), has_mark: false, tree: OnceCell::new() }
    }

    fn tree(&self) -> &Node {
        self.tree.get_or_init(|| Node::parse(&self.text))
    }

    /// An error about the value at the path.
    pub fn error(&self, at: &[Step], kind: FileErrorKind, message: impl Into<String>) -> FileError {
        if self.text.is_empty() {
            return FileError::new(&self.path, kind, message);
        }
        let place = Place::of(&self.text, self.tree().find(at).span.start);
        FileError::new(&self.path, kind, message).at(&self.text, place)
    }

    /// The error of an asset that the value at the path names.
    pub(in crate::files) fn asset_error(&self, at: &[Step], kind: FileErrorKind, fault: &AssetError) -> FileError {
        match fault {
            AssetError::Budget { limit, total, .. } => self
                .error(at, FileErrorKind::Budget, fault.to_string())
                .with_help(format!("if you trust this file, pass `--budget {limit}={total}` or more")),
            _ => self.error(at, kind, fault.to_string()),
        }
    }

    /// An error within the value at the path, which was read by itself.
    pub(in crate::files) fn inner_error(&self, at: &[Step], value: &str, error: SpannedError) -> FileError {
        let inner = syntax_error(&self.path, value, error);
        let start = self.tree().find(at).span.start;
        let is_there = self.text.get(start..).is_some_and(|rest| rest.starts_with(value));
        let mut outer = match inner.place.filter(|_| is_there) {
            Some(place) => {
                let place = Place::of(&self.text, start + byte_of(value, place));
                FileError::new(&self.path, inner.kind, inner.message).at(&self.text, place)
            }
            None => self.error(at, inner.kind, inner.message),
        };
        outer.help = inner.help;
        outer
    }

    /// The comments and blank lines before the first value.
    pub fn header(&self) -> &str {
        let mut at = 0;
        loop {
            let rest = &self.text[at..];
            let blank = rest.len() - rest.trim_start().len();
            let rest = &rest[blank..];
            if rest.starts_with("//") {
                at += blank + rest.find('\n').map_or(rest.len(), |i| i + 1);
            } else if rest.starts_with("/*") {
                at += blank + block_comment(rest);
            } else {
                return self.text[..at].trim_end();
            }
        }
    }

    /// Its text as it is on disk, with its byte order mark.
    pub fn whole_text(&self) -> Cow<'_, str> {
        match self.has_mark {
            true => Cow::Owned(format!("\u{feff}{}", self.text)),
            false => Cow::Borrowed(&self.text),
        }
    }

    /// The folder that relative paths in the file start from.
    pub fn folder(&self) -> &Path {
        folder_of(&self.path)
    }
}

/// Refuses to replace a file of a later version of the format, which this program cannot have read.
pub fn check_replaced(path: &Path) -> Result<(), FileError> {
    read_text(path).map_or(Ok(()), |text| check_version(path, &text))
}

/// Refuses files of a later version of the format: what they say may mean something else there.
fn check_version(path: &Path, text: &str) -> Result<(), FileError> {
    if !text.contains("version") {
        return Ok(());
    }
    let root = Node::parse(text);
    let version = root.group.as_ref().and_then(|group| group.get(&Some("version".to_owned())));
    match version.and_then(|version| Some((version, version.head.parse::<u64>().ok()?))) {
        Some((node, version)) if version > u64::from(VERSION) => {
            let message = format!("is of version {version} of the format, and this program knows up to {VERSION}");
            let error = FileError::new(path, FileErrorKind::NewerVersion, message);
            Err(error.with_help("use a newer Lightwell").at(text, Place::of(text, node.span.start)))
        }
        _ => Ok(()),
    }
}

/// The folder of a file; `.` for a bare name.
pub fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

/// An error of the file system, as missing file where it is that.
pub fn io_error(path: &Path, what: &str, error: &std::io::Error) -> FileError {
    if error.kind() == std::io::ErrorKind::NotFound {
        let missing = FileError::new(path, FileErrorKind::MissingFile, "there is no such file");
        return match similar_file(path) {
            Some(name) => missing.with_help(format!("did you mean `{name}`?")),
            None => missing,
        };
    }
    FileError::new(path, FileErrorKind::Io, format!("{what}: {error}"))
}

/// A file in the same folder with a similar name.
fn similar_file(path: &Path) -> Option<String> {
    let wanted = path.file_name()?.to_string_lossy().into_owned();
    let entries = std::fs::read_dir(folder_of(path)).ok()?;
    let mut names: Vec<String> =
        entries.flatten().take(10_000).map(|e| e.file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    // Only the stems are compared: all scenes end alike.
    let stem = |name: &str| name.split('.').next().unwrap_or_default().to_owned();
    let stems: Vec<String> = names.iter().map(|n| stem(n)).collect();
    let near = super::suggest::nearest(&stem(&wanted), stems.iter().map(String::as_str))?;
    let same_kind = |name: &&String| stem(name) == near && Path::new(name).extension() == path.extension();
    let name = names.iter().find(same_kind).or(names.iter().find(|name| stem(name) == near))?;
    Some(path.with_file_name(name).display().to_string())
}

fn syntax_error(path: &Path, text: &str, error: SpannedError) -> FileError {
    let (kind, message, help) = describe(&error.code);
    let start = error.span.start;
    let mut place = Place { line: start.line.max(1), column: start.col.max(1) };
    if matches!(kind, FileErrorKind::WrongType | FileErrorKind::BadValue) {
        place = place_of_value(text, place);
    }
    // ron points behind the offending name; the name itself is what is to be seen.
    if let Some(name) = offending_name(&error.code) {
        place =
            place_of_name(text, Place { line: error.span.end.line, column: error.span.end.col }, name).unwrap_or(place);
    }
    let error = FileError::new(path, kind, message).at(text, place);
    match help {
        Some(help) => error.with_help(help),
        None => error,
    }
}

fn offending_name(error: &Ron) -> Option<&str> {
    match error {
        Ron::NoSuchEnumVariant { found, .. } | Ron::NoSuchStructField { found, .. } => Some(found),
        Ron::DuplicateStructField { field, .. } => Some(field),
        Ron::ExpectedDifferentStructName { found, .. } => Some(found),
        _ => None,
    }
}

/// Byte of a place.
fn byte_of(text: &str, place: Place) -> usize {
    let line_start: usize = text.split_inclusive('\n').take(place.line.saturating_sub(1)).map(str::len).sum();
    let line = &text[line_start..];
    line_start + line.char_indices().nth(place.column.saturating_sub(1)).map_or(line.len(), |(i, _)| i)
}

/// ron points before the blanks in front of a value or behind its sign: the place of the value itself.
fn place_of_value(text: &str, place: Place) -> Place {
    let mut byte = byte_of(text, place);
    if text[..byte].ends_with(['-', '+']) {
        byte -= 1;
    }
    let rest = &text[byte..];
    let blank = rest.len() - rest.trim_start().len();
    if blank < rest.len() { Place::of(text, byte + blank) } else { place }
}

/// The last occurrence of the name that starts not after `until`.
fn place_of_name(text: &str, until: Place, name: &str) -> Option<Place> {
    let end = byte_of(text, until);
    let mut window = end;
    loop {
        let found = text.get(..window)?.rfind(name)?;
        let word = |c: char| c.is_alphanumeric() || c == '_';
        let clear_before = !text[..found].ends_with(word);
        let clear_after = !text[found + name.len()..].starts_with(word);
        if clear_before && clear_after {
            return Some(Place::of(text, found));
        }
        window = found + name.len() - name.chars().last().map_or(1, char::len_utf8);
    }
}

fn within(outer: Option<&String>) -> String {
    outer.map(|o| format!(" of {o}")).unwrap_or_default()
}

fn describe(error: &Ron) -> (FileErrorKind, String, Option<String>) {
    use FileErrorKind as Kind;
    match error {
        Ron::NoSuchStructField { expected, found, outer } => (
            Kind::UnknownField,
            format!("unknown field `{found}`{}", within(outer.as_ref())),
            suggestion(found, expected.iter().copied()),
        ),
        Ron::NoSuchEnumVariant { expected, found, outer } => (
            Kind::UnknownVariant,
            format!("unknown variant `{found}`{}", within(outer.as_ref())),
            suggestion(found, expected.iter().copied()),
        ),
        Ron::MissingStructField { field, outer } => (
            Kind::MissingField,
            format!("field `{field}`{} is missing before here", within(outer.as_ref())),
            Some(format!("add `{field}: …`")),
        ),
        Ron::DuplicateStructField { field, outer } => (
            Kind::DuplicateName,
            format!("field `{field}`{} is given twice", within(outer.as_ref())),
            Some("keep one of them".into()),
        ),
        Ron::InvalidValueForType { expected, found } => {
            (Kind::WrongType, format!("expected {expected}, found {found}"), None)
        }
        Ron::ExpectedDifferentLength { expected, found } => {
            (Kind::WrongType, format!("expected {expected}, found {found} elements"), None)
        }
        Ron::ExpectedDifferentStructName { expected, found } => {
            (Kind::WrongType, format!("expected `{expected}(…)`, found `{found}(…)`"), suggestion(found, [*expected]))
        }
        Ron::ExceededRecursionLimit => {
            (Kind::Syntax, "nested too deep".into(), Some("move inner entities into a prefab".into()))
        }
        Ron::Message(message) => (Kind::WrongType, message.clone(), None),
        other => describe_syntax(other),
    }
}

fn describe_syntax(error: &Ron) -> (FileErrorKind, String, Option<String>) {
    use FileErrorKind as Kind;
    let (kind, help) = match error {
        Ron::ExpectedFloat => (Kind::WrongType, "write a number here, such as 1.5"),
        Ron::ExpectedInteger | Ron::InvalidIntegerDigit { .. } => (Kind::WrongType, "write a whole number here"),
        Ron::IntegerOutOfBounds => (Kind::BadValue, "the number is too large or negative"),
        Ron::ExpectedString => (Kind::WrongType, "write text in double quotes here"),
        Ron::ExpectedBoolean => (Kind::WrongType, "write true or false here"),
        Ron::ExpectedArray => (Kind::WrongType, "write a list here: [ … ]; tuples take ( … )"),
        Ron::ExpectedMap => (Kind::WrongType, "write a map here: { \"name\": … }"),
        Ron::ExpectedStructLike | Ron::ExpectedNamedStructLike(_) => (Kind::WrongType, "write ( … ) here"),
        Ron::ExpectedComma => (Kind::Syntax, "a comma is missing before here"),
        Ron::ExpectedMapColon => (Kind::Syntax, "write `name: value`"),
        Ron::Eof | Ron::ExpectedStructLikeEnd | Ron::ExpectedArrayEnd | Ron::ExpectedMapEnd => {
            (Kind::Syntax, "a bracket that was opened before is not closed, or a comma is missing")
        }
        Ron::TrailingCharacters => (Kind::Syntax, "the file holds one value, such as Scene(…), and nothing after it"),
        _ => (Kind::Syntax, ""),
    };
    let text = error.to_string();
    let mut chars = text.chars();
    let message: String = chars.next().into_iter().flat_map(char::to_lowercase).chain(chars).collect();
    (kind, message, (!help.is_empty()).then(|| help.to_owned()))
}
