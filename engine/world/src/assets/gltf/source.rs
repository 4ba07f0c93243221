//! Bytes of a glTF asset: the GLB container, and files beside it.

use super::remarks::Remarks;
use super::uri::{self, Target};
use crate::assets::{AssetError, Meter, read_file};
use std::path::{Path, PathBuf};

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
    if bytes.starts_with(b"glTF") {
        return split_glb(path, bytes, remarks);
    }
    if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("glb")) {
        let text = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
        if !text.trim_ascii_start().starts_with(b"{") {
            let problem = "the file does not begin with \"glTF\": it is no GLB file";
            return Err(AssetError::format(path, "GLB header", problem));
        }
        remarks.fault("GLB header: there is none; the file is read as JSON text".into());
    }
    Ok(Container { json: bytes, bin: None })
}

fn split_glb<'a>(path: &Path, bytes: &'a [u8], remarks: &mut Remarks) -> Result<Container<'a>, AssetError> {
    let fail = |problem: &str| Err(AssetError::format(path, "GLB header", problem));
    let (Some(version), Some(length)) = (word(bytes, 4), word(bytes, 8)) else {
        return fail("the file ends within the header");
    };
    if version != 2 {
        return fail(&format!("version {version} is not supported, only 2"));
    }
    let (length, mut at, mut index) = (length as usize, 12, 0);
    let mut found = Container { json: &[], bin: None };
    // Chunks say themselves how long they are, so that a wrong length of the whole is no harm. What comes after it counts
    // only where something is still missing.
    while at < bytes.len() && (at < length || found.json.is_empty() || found.bin.is_none()) {
        if at >= length && chunk(bytes, at).is_none() {
            break;
        }
        match add_chunk(path, bytes, at, index, &mut found, remarks) {
            Ok(end) => at = end,
            Err(error) if found.json.is_empty() || found.bin.is_none() => return Err(error),
            Err(error) => {
                remarks.broken(&error, "ignored");
                break;
            }
        }
        index += 1;
    }
    if found.json.is_empty() {
        return fail("there is no JSON chunk, or it is empty");
    }
    if length < at || length > bytes.len() {
        let size = bytes.len();
        remarks
            .fault(format!("GLB header: length {length} is wrong: chunks end at {at}, and the file at {size} bytes"));
    }
    if at < bytes.len() {
        remarks.push(format!("{} bytes after the end of the GLB content are ignored", bytes.len() - at));
    }
    Ok(found)
}

/// Kind and content of the chunk at a place; `None` if it is not there as a whole, or of no known kind.
fn chunk(bytes: &[u8], at: usize) -> Option<(u32, &[u8])> {
    let (size, kind) = (word(bytes, at)? as usize, word(bytes, at.checked_add(4)?)?);
    let data = bytes.get(at + 8..(at + 8).checked_add(size)?)?;
    [CHUNK_JSON, CHUNK_BIN].contains(&kind).then_some((kind, data))
}

/// Takes the chunk at a place, if it is the first of its kind. Returns where the next one begins.
fn add_chunk<'a>(
    path: &Path,
    bytes: &'a [u8],
    at: usize,
    index: usize,
    found: &mut Container<'a>,
    remarks: &mut Remarks,
) -> Result<usize, AssetError> {
    let place = || format!("GLB chunk {index}");
    let fail = |problem: &str| Err(AssetError::format(path, place(), problem));
    let (Some(size), Some(kind)) = (word(bytes, at), word(bytes, at + 4)) else {
        return fail("the file ends within the chunk's header");
    };
    let Some(end) = (at + 8).checked_add(size as usize).filter(|end| *end <= bytes.len()) else {
        return fail(&format!("length {size} is beyond the end of the file"));
    };
    let data = &bytes[at + 8..end];
    match kind {
        CHUNK_JSON if data.is_empty() => return fail("the JSON chunk is empty"),
        CHUNK_JSON if found.json.is_empty() => {
            found.json = data;
            if index > 0 {
                remarks.fault(format!("{}: is the JSON chunk, which must be the first", place()));
            }
        }
        CHUNK_BIN if found.bin.is_none() => {
            found.bin = Some(data);
            if index != 1 {
                remarks.fault(format!("{}: is the binary chunk, which must be the second", place()));
            }
        }
        CHUNK_JSON | CHUNK_BIN => remarks.fault(format!("{}: is the second of its kind; ignored", place())),
        _ => {}
    }
    if size % 4 == 0 {
        return Ok(end);
    }
    remarks.fault(format!("{}: length {size} is not a multiple of 4", place()));
    // Some exporters fill a chunk up without counting the filling.
    let aligned = end.next_multiple_of(4);
    let is_filled = chunk(bytes, end).is_none() && (chunk(bytes, aligned).is_some() || aligned >= bytes.len());
    Ok(if is_filled { aligned.min(bytes.len()) } else { end })
}

/// The files beside an asset, and what reading them may take.
pub(super) struct Beside<'a> {
    /// Those that were read.
    pub files: Vec<PathBuf>,
    /// The amounts that the load takes.
    pub meter: &'a Meter,
}

/// Reads what a URI refers to; files are noted. Where the URI leads to no file, the one that it most likely means is read, which
/// is noted as a fault.
pub(super) fn fetch(
    asset: &Path,
    place: &str,
    uri: &str,
    beside: &mut Beside,
    remarks: &mut Remarks,
) -> Result<Vec<u8>, AssetError> {
    let result = match uri::resolve(asset, place, uri) {
        Ok(Target::Data(bytes)) => return Ok(bytes),
        Ok(Target::File(file)) => read(asset, place, file, beside),
        Err(error) => Err(error),
    };
    let Err(error @ AssetError::Format { .. }) = result else { return result };
    let Some(file) = uri::guess(asset, uri) else { return Err(error) };
    let bytes = read(asset, place, file.clone(), beside)?;
    let found = file.strip_prefix(asset.parent().unwrap_or(Path::new(""))).unwrap_or(&file);
    remarks.fault(format!("{place}: URI \"{}\" leads to no file; {} is read", uri::shown(uri), found.display()));
    Ok(bytes)
}

fn read(asset: &Path, place: &str, file: PathBuf, beside: &mut Beside) -> Result<Vec<u8>, AssetError> {
    check_location(asset, place, &file)?;
    let bytes = read_file(&file, beside.meter).map_err(|e| match e {
        AssetError::Io { path, reason } => {
            AssetError::format(asset, place, format!("{}: cannot be read: {reason}", path.display()))
        }
        other => other,
    })?;
    beside.files.push(file);
    Ok(bytes)
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
