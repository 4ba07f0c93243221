//! URIs of buffers and images: content within the URI, or a file beside the asset.

use crate::assets::AssetError;
use std::path::{Component, Path, PathBuf};

/// Where a URI leads.
pub(super) enum Target {
    /// Content within the URI.
    Data(Vec<u8>),
    /// A file beside the asset or below its folder.
    File(PathBuf),
}

/// Resolves a URI of the asset. Only data URIs and relative paths within the asset's folder are followed.
pub(super) fn resolve(asset: &Path, place: &str, uri: &str) -> Result<Target, AssetError> {
    let fail = |problem: String| Err(AssetError::format(asset, place, problem));
    if let Some(rest) = uri.trim_start().split_at_checked(5).filter(|(scheme, _)| scheme.eq_ignore_ascii_case("data:"))
    {
        return match data(rest.1) {
            Ok(bytes) => Ok(Target::Data(bytes)),
            Err(problem) => fail(problem.into()),
        };
    }
    let shown = shown(uri);
    let colon = uri.find(':').unwrap_or(usize::MAX);
    if colon < uri.find('/').unwrap_or(usize::MAX) {
        return fail(format!("URI \"{shown}\" has a scheme; only data URIs and relative paths are read"));
    }
    let Some(decoded) = percent_decode(uri).and_then(|bytes| String::from_utf8(bytes).ok()) else {
        return fail(format!("URI \"{shown}\" has a broken percent escape"));
    };
    if decoded.contains(['\\', '\0']) || !stays_inside(Path::new(&decoded)) {
        return fail(format!("URI \"{shown}\" leads out of the asset's folder"));
    }
    Ok(Target::File(folder_of(asset).join(decoded)))
}

/// The beginning of a URI, for messages.
pub(super) fn shown(uri: &str) -> String {
    uri.chars().take(80).collect()
}

fn folder_of(asset: &Path) -> &Path {
    asset.parent().unwrap_or(Path::new(""))
}

/// The file that an exporter most likely meant by a URI that does not lead to one: a path of Windows, one of the machine that
/// the file was made on, or one in another case. It is looked for below the asset's folder alone, first by the whole path, and
/// then without more and more of its folders.
pub(super) fn guess(asset: &Path, uri: &str) -> Option<PathBuf> {
    let decoded = percent_decode(uri).and_then(|bytes| String::from_utf8(bytes).ok());
    let spellings = decoded.into_iter().chain([uri.to_owned()]);
    spellings.flat_map(|text| [text.split(['?', '#']).next().unwrap_or_default().to_owned(), text]).find_map(|text| {
        let names = names(&text)?;
        (0..names.len()).find_map(|first| find(folder_of(asset), &names[first..]))
    })
}

/// The folders and the file of a path, as far as they can lie below the asset's folder.
fn names(path: &str) -> Option<Vec<&str>> {
    let path = match path.get(..7) {
        Some(scheme) if scheme.eq_ignore_ascii_case("file://") => &path[7..],
        _ => path,
    };
    if path.contains("://") || path.contains('\0') {
        return None;
    }
    let is_drive = |name: &str| name.len() == 2 && name.ends_with(':');
    let mut names = Vec::new();
    for name in path.split(['/', '\\']) {
        match name {
            "" | "." => {}
            ".." => names.clear(),
            drive if is_drive(drive) => names.clear(),
            name => names.push(name),
        }
    }
    // The first ones are those of a machine; this bounds how often folders are searched.
    let surplus = names.len().saturating_sub(MAX_NAMES);
    Some(names.split_off(surplus))
}

/// Most folders of a path that are looked for.
const MAX_NAMES: usize = 8;

/// The file of these names below a folder, in any case if there is none in this one.
fn find(folder: &Path, names: &[&str]) -> Option<PathBuf> {
    let (name, rest) = names.split_first()?;
    let open = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let exact = folder.join(name);
    let path = if exact.exists() {
        exact
    } else {
        let folded = name.to_lowercase();
        let is_it =
            |entry: &std::fs::DirEntry| entry.file_name().to_str().is_some_and(|found| found.to_lowercase() == folded);
        // The first one by name, so that the same folder always gives the same file.
        let entries = std::fs::read_dir(open).ok()?.flatten().filter(is_it);
        folder.join(entries.map(|entry| entry.file_name()).min()?)
    };
    match rest.is_empty() {
        true => path.is_file().then_some(path),
        false => find(&path, rest),
    }
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

/// Content of a data URI (RFC 2397) after its scheme, of any media type.
fn data(rest: &str) -> Result<Vec<u8>, &'static str> {
    let Some((head, content)) = rest.split_once(',') else { return Err("the data URI has no comma before its data") };
    let content = percent_decode(content).ok_or("the data URI has a broken percent escape")?;
    let head = head.trim_end();
    let is_base64 = head.len().checked_sub(7).and_then(|start| head.get(start..));
    match is_base64.is_some_and(|end| end.eq_ignore_ascii_case(";base64")) {
        true => base64(&content).ok_or("the data URI holds invalid base64"),
        false => Ok(content),
    }
}

fn percent_decode(text: &str) -> Option<Vec<u8>> {
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
    Some(out)
}

/// Decodes base64 (RFC 4648), with either alphabet. Padding may be left out, and lines may be broken.
fn base64(text: &[u8]) -> Option<Vec<u8>> {
    let mut out = Vec::with_capacity(text.len() / 4 * 3 + 3);
    let (mut value, mut digits, mut padding) = (0u32, 0usize, 0usize);
    for b in text.iter().filter(|b| !b.is_ascii_whitespace()) {
        let digit = match b {
            b'A'..=b'Z' => b - b'A',
            b'a'..=b'z' => b - b'a' + 26,
            b'0'..=b'9' => b - b'0' + 52,
            b'+' | b'-' => 62,
            b'/' | b'_' => 63,
            b'=' => {
                padding += 1;
                continue;
            }
            _ => return None,
        };
        if padding > 0 {
            return None;
        }
        value = value << 6 | u32::from(digit);
        digits += 1;
        if digits % 4 == 0 {
            out.extend_from_slice(&value.to_be_bytes()[1..]);
            value = 0;
        }
    }
    let left = digits % 4;
    if padding > 2 || left == 1 {
        return None;
    }
    if left > 0 {
        value <<= 6 * (4 - left);
        out.extend_from_slice(&value.to_be_bytes()[1..left]);
    }
    Some(out)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn base64_follows_the_rfc() {
        for (text, bytes) in [
            ("", &b""[..]),
            ("Zg==", b"f"),
            ("Zm8=", b"fo"),
            ("Zm9v", b"foo"),
            ("Zm9vYmFy", b"foobar"),
            ("Zm8", b"fo"),
            ("Zm9v\r\n YmFy", b"foobar"),
            ("-_-_", b"\xFB\xFF\xBF"),
        ] {
            assert_eq!(base64(text.as_bytes()).unwrap(), bytes);
        }
        for bad in ["Z", "Zm9v!", "Zg===", "=Zm9"] {
            assert!(base64(bad.as_bytes()).is_none(), "{bad}");
        }
    }

    #[test]
    fn data_of_any_media_type_is_read() {
        for uri in [
            "data:application/octet-stream;base64,Zm9v",
            "data:;base64,Zm9v",
            "data:image/png;charset=utf-8;BASE64,Zm9v",
            " DATA:a/b;base64,Zm\n9v",
            "data:,foo",
            "data:text/plain,f%6F%6f",
        ] {
            let Ok(Target::Data(bytes)) = resolve(Path::new("a.gltf"), "buffer 0", uri) else { panic!("{uri}") };
            assert_eq!(bytes, b"foo", "{uri}");
        }
        assert!(resolve(Path::new("a.gltf"), "buffer 0", "data:;base64,!").is_err());
        assert!(resolve(Path::new("a.gltf"), "buffer 0", "data:").is_err());
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

    #[test]
    fn files_are_guessed_below_the_folder_alone() {
        let outside = tempfile::tempdir().unwrap();
        std::fs::write(outside.path().join("secret.png"), "").unwrap();
        let folder = outside.path().join("model");
        std::fs::create_dir_all(folder.join("textures")).unwrap();
        for file in ["textures/Wood.png", "a b.png", "100%.png", "a%20c.png"] {
            std::fs::write(folder.join(file), "").unwrap();
        }
        let asset = folder.join("a.gltf");
        for (uri, file) in [
            ("textures\\wood.PNG", Some("textures/Wood.png")),
            ("C:\\Users\\me\\model\\textures\\Wood.png", Some("textures/Wood.png")),
            ("file:///home/me/textures/Wood.png", Some("textures/Wood.png")),
            ("../textures/Wood.png", Some("textures/Wood.png")),
            ("Textures/Wood.png?v=2", Some("textures/Wood.png")),
            ("100%.png", Some("100%.png")),
            ("a%20c.png", Some("a%20c.png")),
            ("sub/A%20B.png", Some("a b.png")),
            ("../secret.png", None),
            ("..\\secret.png", None),
            ("https://example.org/textures/Wood.png", None),
            ("textures", None),
            ("..", None),
            ("", None),
        ] {
            assert_eq!(guess(&asset, uri), file.map(|file| folder.join(file)), "{uri}");
        }
    }
}
