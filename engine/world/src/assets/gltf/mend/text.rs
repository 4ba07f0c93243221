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
            let what = "texts that are not UTF-8 or hold lone backslashes or control characters, NaN or Infinity, or \
                commas before a bracket";
            remarks.fault(format!("JSON: has what JSON does not allow ({what}); mended"));
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

/// JSON in place of what exporters write that is none: texts that are not UTF-8 or hold control characters or lone
/// backslashes, numbers that JSON does not have (`null` stands for them), and a comma before a closing bracket.
fn mended(text: &[u8]) -> Vec<u8> {
    let text = String::from_utf8_lossy(text);
    let mut out = String::with_capacity(text.len());
    let (mut rest, mut is_text) = (&*text, false);
    while let Some(next) = rest.chars().next() {
        let mut length = next.len_utf8();
        match next {
            '"' => {
                is_text = !is_text;
                out.push(next);
            }
            '\\' if is_text => match escape_length(rest) {
                Some(escape) => {
                    length = escape;
                    out.push_str(&rest[..length]);
                }
                None => out.push_str("\\\\"),
            },
            control if is_text && control < ' ' => out.push_str(&format!("\\u{:04x}", u32::from(control))),
            ',' if !is_text && rest[1..].trim_start().starts_with([']', '}']) => {}
            _ => match no_number(rest).filter(|_| !is_text) {
                Some(word) => {
                    length = word;
                    out.push_str("null");
                }
                None => out.push(next),
            },
        }
        rest = &rest[length..];
    }
    out.into_bytes()
}

/// Length of the escape that a text begins with; `None` if the backslash stands for itself, as in a path.
fn escape_length(text: &str) -> Option<usize> {
    match text.as_bytes().get(1)? {
        b'"' | b'\\' | b'/' | b'b' | b'f' | b'n' | b'r' | b't' => Some(2),
        b'u' => text.as_bytes().get(2..6)?.iter().all(u8::is_ascii_hexdigit).then_some(6),
        _ => None,
    }
}

/// Length of the infinity or "not a number" that a text begins with, as JavaScript, Python and the C libraries write it.
fn no_number(text: &str) -> Option<usize> {
    let unsigned = text.strip_prefix('-').unwrap_or(text);
    let is_one = |word: &&str| unsigned.get(..word.len()).is_some_and(|start| start.eq_ignore_ascii_case(word));
    let word = ["infinity", "inf", "nan", "1.#inf", "1.#ind", "1.#qnan", "1.#snan"].into_iter().find(is_one)?;
    let tail = unsigned[word.len()..].find(|c: char| !(c.is_ascii_alphanumeric() || c == '(' || c == ')'));
    Some(text.len() - unsigned.len() + tail.map_or(unsigned.len(), |tail| word.len() + tail))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn json_of_exporters_is_mended() {
        for (written, meant) in [
            ("[1,]", "[1]"),
            ("{\"a\":1 ,\n }", "{\"a\":1 \n }"),
            ("[NaN,-Infinity,nan,-nan(ind),inf,1.#QNAN0,-1.#IND]", "[null,null,null,null,null,null,null]"),
            ("\"NaN,]\"", "\"NaN,]\""),
            (r#""C:\Models\a.png""#, r#""C:\\Models\\a.png""#),
            (r#""a\"b\\c\u00e9""#, r#""a\"b\\c\u00e9""#),
            ("\"a\tb\"", "\"a\\u0009b\""),
            ("[true,null,-1e3]", "[true,null,-1e3]"),
        ] {
            assert_eq!(String::from_utf8_lossy(&mended(written.as_bytes())), meant);
        }
    }
}
