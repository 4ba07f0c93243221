//! From bytes to JSON. Faults that exporters are known for are mended in the text; all else that is no JSON is refused.

use crate::assets::AssetError;
use crate::assets::gltf::remarks::Remarks;
use gltf::json::Value;
use std::borrow::Cow;
use std::path::Path;

/// A document and its text.
pub(in crate::assets::gltf) struct Parsed<'a> {
    pub value: Value,
    pub text: Cow<'a, [u8]>,
}

/// Reads JSON.
///
/// # Errors
/// What is no JSON, with its line and column.
pub(in crate::assets::gltf) fn parse<'a>(
    path: &Path,
    bytes: &'a [u8],
    remarks: &mut Remarks,
) -> Result<Parsed<'a>, AssetError> {
    let mut text = Cow::Borrowed(trimmed(bytes, remarks));
    let mut result = gltf::json::deserialize::from_slice(&text);
    if result.is_err() {
        let mended = mended(&text);
        if let Ok(value) = gltf::json::deserialize::from_slice::<Value>(&mended) {
            remarks
                .fault("JSON: has texts that are not UTF-8, or NaN or Infinity, which are taken for no number".into());
            (text, result) = (Cow::Owned(mended), Ok(value));
        }
    }
    match result {
        Ok(value @ Value::Object(_)) => Ok(Parsed { value, text }),
        Ok(_) => Err(AssetError::format(path, "JSON", "is no object")),
        Err(e) => {
            let place = format!("JSON, line {}, column {}", e.line(), e.column());
            // Its place is said already.
            let problem = e.to_string();
            let problem = problem.split(" at line ").next().unwrap_or_default().to_owned();
            Err(AssetError::format(path, place, problem))
        }
    }
}

/// The text without a byte order mark and without zeros that fill it up.
fn trimmed<'a>(bytes: &'a [u8], remarks: &mut Remarks) -> &'a [u8] {
    let text = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
    if text.len() < bytes.len() {
        remarks.fault("JSON: begins with a byte order mark; ignored".into());
    }
    let end = text.iter().rposition(|byte| *byte != 0).map_or(0, |last| last + 1);
    if end < text.len() {
        remarks.fault("JSON: ends with zeros in place of spaces; ignored".into());
    }
    &text[..end]
}

/// Valid UTF-8, with `null` for the numbers that JSON does not have.
fn mended(text: &[u8]) -> Vec<u8> {
    let text = String::from_utf8_lossy(text);
    let mut out = String::with_capacity(text.len());
    let (mut rest, mut is_text) = (&*text, false);
    while let Some(next) = rest.chars().next() {
        let word = ["-Infinity", "Infinity", "-NaN", "NaN"].into_iter().find(|word| !is_text && rest.starts_with(word));
        if let Some(word) = word {
            out.push_str("null");
            rest = &rest[word.len()..];
            continue;
        }
        let mut length = next.len_utf8();
        if is_text && next == '\\' {
            length += rest[length..].chars().next().map_or(0, char::len_utf8);
        } else if next == '"' {
            is_text = !is_text;
        }
        out.push_str(&rest[..length]);
        rest = &rest[length..];
    }
    out.into_bytes()
}
