//! Bytes of a glTF asset: the GLB container, data URIs, and files beside it.

use super::remarks::Remarks;
use crate::assets::{AssetError, Meter, read_file};
use std::borrow::Cow;
use std::path::{Component, Path, PathBuf};

const CHUNK_JSON: u32 = 0x4E4F_534A;
const CHUNK_BIN: u32 = 0x004E_4942;

/// JSON text and binary chunk of a file.
pub(super) struct Container<'a> {
    pub json: &'a [u8],
    pub bin: Option<&'a [u8]>,
}

fn word(bytes: &[u8], at: usize) -> Option<u32> {
    Some(u32::from_le_bytes(bytes.get(at..at.checked_add(4)?)?.try_into().ok()?))
}

/// Splits a file into JSON and binary chunk (glTF 2.0, section 4.4). A file without the GLB magic is all JSON.
pub(super) fn split<'a>(path: &Path, bytes: &'a [u8], remarks: &mut Remarks) -> Result<Container<'a>, AssetError> {
    let glb = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("glb"));
    if !bytes.starts_with(b"glTF") {
        if glb {
            return Err(AssetError::format(
                path,
                "GLB header",
                "the file does not begin with \"glTF\": it is no GLB file",
            ));
        }
        return Ok(Container { json: bytes, bin: None });
    }
    split_glb(path, bytes, remarks)
}

fn split_glb<'a>(path: &Path, bytes: &'a [u8], remarks: &mut Remarks) -> Result<Container<'a>, AssetError> {
    let fail = |place: String, problem: &str| Err(AssetError::format(path, place, problem));
    let header = || "GLB header".to_string();
    let (Some(version), Some(length)) = (word(bytes, 4), word(bytes, 8)) else {
        return fail(header(), "the file ends within the header");
    };
    if version != 2 {
        return fail(header(), &format!("version {version} is not supported, only 2"));
    }
    let length = length as usize;
    if length > bytes.len() {
        return fail(header(), &format!("length {length} is beyond the end of the file ({} bytes)", bytes.len()));
    }
    if length < 20 {
        return fail(header(), &format!("length {length} leaves no room for a JSON chunk"));
    }
    let body = &bytes[..length];
    let (mut json, mut bin, mut at, mut index) = (None, None, 12, 0);
    while at < length {
        let place = || format!("GLB chunk {index}");
        let (Some(size), Some(kind)) = (word(body, at), word(body, at + 4)) else {
            return fail(place(), "the file ends within the chunk's header");
        };
        if size % 4 != 0 {
            remarks.fault(format!("{}: length {size} is not a multiple of 4", place()));
        }
        let Some(data) = (at + 8).checked_add(size as usize).and_then(|end| body.get(at + 8..end)) else {
            return fail(place(), &format!("length {size} is beyond the end of the file"));
        };
        match (index, kind) {
            (0, CHUNK_JSON) if data.is_empty() => return fail(place(), "the JSON chunk is empty"),
            (0, CHUNK_JSON) => json = Some(data),
            (0, _) => return fail(place(), "the first chunk must be the JSON chunk"),
            (1, CHUNK_BIN) => bin = Some(data),
            (_, CHUNK_BIN) => {
                return fail(place(), "the binary chunk must be the second and only one");
            }
            (_, CHUNK_JSON) => return fail(place(), "a second JSON chunk"),
            _ => {}
        }
        at += 8 + size as usize;
        index += 1;
    }
    let surplus = bytes.len() - length;
    if surplus > 0 {
        remarks.push(format!("{surplus} bytes after the end of the GLB content are ignored"));
    }
    match json {
        Some(json) => Ok(Container { json, bin }),
        None => fail(header(), "there is no JSON chunk"),
    }
}

/// Where a URI leads.
pub(super) enum Target<'a> {
    /// Content within the URI.
    Data(Cow<'a, [u8]>),
    /// A file beside the asset or below its folder.
    File(PathBuf),
}

/// Resolves a URI of the asset. Only data URIs and relative paths within the asset's folder are followed.
pub(super) fn resolve(asset: &Path, place: &str, uri: &str) -> Result<Target<'static>, AssetError> {
    let fail = |problem: String| Err(AssetError::format(asset, place, problem));
    if let Some(rest) = uri.strip_prefix("data:") {
        let Some((_, data)) = rest.split_once(";base64,").filter(|(kind, _)| !kind.ends_with(';')) else {
            return fail("the data URI is not base64-encoded, or its media type is malformed".into());
        };
        return match base64(data.as_bytes()) {
            Some(bytes) => Ok(Target::Data(Cow::Owned(bytes))),
            None => fail("the data URI holds invalid base64".into()),
        };
    }
    let shown: String = uri.chars().take(80).collect();
    let colon = uri.find(':').unwrap_or(usize::MAX);
    if colon < uri.find('/').unwrap_or(usize::MAX) {
        return fail(format!("URI \"{shown}\" has a scheme; only data URIs and relative paths are read"));
    }
    let Some(decoded) = percent_decode(uri) else {
        return fail(format!("URI \"{shown}\" has a broken percent escape"));
    };
    if decoded.contains(['\\', '\0']) || !stays_inside(Path::new(&decoded)) {
        return fail(format!("URI \"{shown}\" leads out of the asset's folder"));
    }
    let folder = asset.parent().unwrap_or(Path::new(""));
    Ok(Target::File(folder.join(decoded)))
}

/// The files beside an asset, and what reading them may take.
pub(super) struct Beside<'a> {
    /// Those that were read.
    pub files: Vec<PathBuf>,
    /// The amounts that the load takes.
    pub meter: &'a Meter,
}

/// Reads what a URI refers to; files are noted.
pub(super) fn fetch(asset: &Path, place: &str, uri: &str, beside: &mut Beside) -> Result<Vec<u8>, AssetError> {
    match resolve(asset, place, uri)? {
        Target::Data(bytes) => Ok(bytes.into_owned()),
        Target::File(file) => {
            check_location(asset, place, &file)?;
            let bytes = read_file(&file, beside.meter).map_err(|e| match e {
                AssetError::Io { path, source } => {
                    AssetError::format(asset, place, format!("{}: cannot be read: {source}", path.display()))
                }
                other => other,
            })?;
            beside.files.push(file);
            Ok(bytes)
        }
    }
}

/// Links must not lead out of the asset's folder either.
pub(super) fn check_location(asset: &Path, place: &str, file: &Path) -> Result<(), AssetError> {
    let folder = asset.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let (Ok(folder), Ok(real)) = (folder.canonicalize(), file.canonicalize()) else {
        return Ok(()); // it is not there: reading it says so
    };
    if real.starts_with(&folder) {
        return Ok(());
    }
    Err(AssetError::format(asset, place, format!("{} is a link that leads out of the asset's folder", file.display())))
}

fn stays_inside(path: &Path) -> bool {
    let mut depth = 0i64;
    !path.as_os_str().is_empty()
        && path.components().all(|c| {
            depth += match c {
                Component::Normal(_) => 1,
                Component::CurDir => 0,
                Component::ParentDir => -1,
                Component::RootDir | Component::Prefix(_) => return false,
            };
            depth >= 0
        })
}

fn percent_decode(text: &str) -> Option<String> {
    let mut out = Vec::with_capacity(text.len());
    let mut bytes = text.bytes();
    while let Some(b) = bytes.next() {
        if b != b'%' {
            out.push(b);
            continue;
        }
        let digit = |b: u8| char::from(b).to_digit(16);
        let value = digit(bytes.next()?)? * 16 + digit(bytes.next()?)?;
        out.push(u8::try_from(value).ok()?);
    }
    String::from_utf8(out).ok()
}

/// Decodes standard base64 (RFC 4648); padding may be left out.
fn base64(text: &[u8]) -> Option<Vec<u8>> {
    let padding = text.iter().rev().take_while(|b| **b == b'=').count();
    let text = &text[..text.len() - padding];
    if padding > 2 || text.len() % 4 == 1 {
        return None;
    }
    let mut out = Vec::with_capacity(text.len() * 3 / 4);
    for group in text.chunks(4) {
        let mut value = 0u32;
        for b in group {
            let digit = match b {
                b'A'..=b'Z' => b - b'A',
                b'a'..=b'z' => b - b'a' + 26,
                b'0'..=b'9' => b - b'0' + 52,
                b'+' => 62,
                b'/' => 63,
                _ => return None,
            };
            value = value << 6 | u32::from(digit);
        }
        value <<= 6 * (4 - group.len());
        out.extend_from_slice(&value.to_be_bytes()[1..group.len()]);
    }
    Some(out)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn base64_follows_the_rfc() {
        for (text, bytes) in
            [("", ""), ("Zg==", "f"), ("Zm8=", "fo"), ("Zm9v", "foo"), ("Zm9vYmFy", "foobar"), ("Zm8", "fo")]
        {
            assert_eq!(base64(text.as_bytes()).unwrap(), bytes.as_bytes());
        }
        for bad in ["Z", "Zm9v!", "Zm 9v", "Zg===", "=Zm9"] {
            assert!(base64(bad.as_bytes()).is_none(), "{bad}");
        }
    }

    #[test]
    fn uris_stay_in_the_folder() {
        let asset = Path::new("models/a.gltf");
        for bad in [
            "http://a/b.bin",
            "file:///etc/passwd",
            "/etc/passwd",
            "../x.bin",
            "a/../../x",
            "%2e%2e/x",
            "a\\b",
            "",
            "a%zz",
            "C:x",
        ] {
            assert!(resolve(asset, "buffer 0", bad).is_err(), "{bad}");
        }
        for good in ["x.bin", "a/../x.bin", "./x%20y.bin"] {
            assert!(matches!(resolve(asset, "buffer 0", good), Ok(Target::File(_))), "{good}");
        }
    }
}
