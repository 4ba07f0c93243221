//! The JSON document: version, extensions, and loading of its buffers.

use super::accessor::Buffers;
use super::remarks::Remarks;
use super::{draco, mend, meshopt, source};
use crate::assets::AssetError;
use gltf::Document;
use gltf::json::Value;
use std::borrow::Cow;
use std::collections::HashSet;
use std::path::Path;

/// Buffers of a document: parts of the file itself, or loaded.
type BufferData<'a> = Vec<Cow<'a, [u8]>>;

/// Extensions that are read, at least as far as to draw the file sensibly.
const SUPPORTED: [&str; 22] = [
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    "EXT_texture_webp",
    draco::NAME,
    "KHR_lights_punctual",
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_dispersion",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_iridescence",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_texture_basisu",
    "KHR_meshopt_compression",
    "KHR_texture_transform",
    "KHR_materials_variants",
];

/// Parses and mends the document. Returns whether it uses `KHR_mesh_quantization` too.
pub(super) fn parse(path: &Path, json: &[u8], remarks: &mut Remarks) -> Result<(Document, bool), AssetError> {
    let mend::Parsed { mut value, text } = mend::parse(path, json, remarks)?;
    let before = value.clone();
    mend::version(&mut value, remarks);
    check_version(path, &value)?;
    mend::move_misplaced(&mut value, remarks);
    mend::ignore_targetless(&mut value, remarks);
    mend::mend(&mut value, remarks);
    let root = match value == before {
        true => gltf::json::deserialize::from_slice(&text),
        false => gltf::json::serialize::to_vec(&value).and_then(|text| gltf::json::deserialize::from_slice(&text)),
    };
    let mut root: gltf::json::Root = root.map_err(|e| {
        AssetError::format(path, format!("JSON, line {}, column {}", e.line(), e.column()), e.to_string())
    })?;
    check_extensions(path, &root, remarks)?;
    let quantized = root.extensions_used.iter().any(|e| e == "KHR_mesh_quantization");
    // They were checked above, against what is supported here rather than by the parser.
    root.extensions_required.clear();
    check(path, &root)?;
    Ok((Document::from_json_without_validation(root), quantized))
}

/// What the parser relies on is checked once more by the parser itself. It asks for positions, their bounds, strides that suit
/// vertices, and a buffer view for every accessor, without which the reader gets along.
fn check(path: &Path, root: &gltf::json::Root) -> Result<(), AssetError> {
    use gltf::json::validation::{Error as Kind, Validate};
    let mut faults = Vec::new();
    root.validate(root, gltf::json::Path::new, &mut |place, kind| faults.push((place(), kind)));
    let is_needed = |(place, kind): &&(gltf::json::Path, Kind)| {
        let ends = |fields: &[&str]| fields.iter().any(|field| place.as_str().ends_with(field));
        let is_dispensable = *kind == Kind::Missing && ends(&["bufferView", "POSITION", "\"POSITION\"]"]);
        !is_dispensable && !ends(&[".min", ".max", ".byteStride"])
    };
    let Some((place, kind)) = faults.iter().find(is_needed) else { return Ok(()) };
    let problem = match kind {
        Kind::IndexOutOfBounds => "refers to something that is not in the file (index out of range)",
        Kind::Invalid => "has a value that glTF 2.0 does not allow here",
        Kind::Missing => "is required, but missing",
        Kind::Oversize => "is larger than this system's memory",
        Kind::Unsupported => "is not supported",
    };
    Err(AssetError::format(path, place.to_string(), problem))
}

/// A version is the first thing that a reader must know.
fn check_version(path: &Path, root: &Value) -> Result<(), AssetError> {
    let fail = |place: &str, problem: String| Err(AssetError::format(path, place, problem));
    let version = root.get("asset").and_then(|asset| asset.get("version"));
    let parse = |text: &str| -> Option<(u32, u32)> {
        let (major, minor) = text.split_once('.')?;
        Some((major.parse().ok()?, minor.parse().ok()?))
    };
    match version.and_then(Value::as_str) {
        None => return fail("asset.version", "is missing, or no text such as \"2.0\": this is no glTF".into()),
        Some(version) => match parse(version) {
            Some((2, _)) => {}
            Some(_) => return fail("asset.version", format!("is {version}; only glTF 2 is read: convert the file")),
            None => return fail("asset.version", format!("{version:?} is not a version such as \"2.0\"")),
        },
    }
    match root.get("asset").and_then(|asset| asset.get("minVersion")).and_then(Value::as_str) {
        Some(least) if parse(least) != Some((2, 0)) => {
            fail("asset.minVersion", format!("is {least:?}; only glTF 2.0 is read"))
        }
        _ => Ok(()),
    }
}

fn check_extensions(path: &Path, root: &gltf::json::Root, remarks: &mut Remarks) -> Result<(), AssetError> {
    let known = |e: &str| SUPPORTED.contains(&e);
    for (i, extension) in root.extensions_required.iter().enumerate() {
        if !known(extension) {
            let problem =
                format!("the file needs the extension {extension}, which is not supported: export it without");
            return Err(AssetError::format(path, format!("extensionsRequired[{i}]"), problem));
        }
        if !root.extensions_used.contains(extension) {
            remarks.fault(format!(
                "extensionsRequired[{i}]: {extension} is not listed in extensionsUsed; read all the same"
            ));
        }
    }
    let unknown = root.extensions_used.iter().filter(|e| !known(e));
    remarks.extend(unknown.map(|e| format!("the extension {e} is not supported and has no effect")));
    Ok(())
}

/// The buffers that geometry is read from. Without one of them there is no model.
fn buffers_of_geometry(document: &Document) -> HashSet<usize> {
    let mut found = HashSet::new();
    for primitive in document.meshes().flat_map(|mesh| mesh.primitives()) {
        let positions = primitive.get(&gltf::Semantic::Positions);
        let views = positions.into_iter().chain(primitive.indices()).filter_map(|accessor| accessor.view());
        found.extend(views.map(|view| view.buffer().index()));
    }
    found
}

/// Loads each buffer once: from the file's binary chunk, its data URI, or the file beside it. One that is not there, and
/// that no geometry is read from, is empty.
///
/// # Errors
/// A buffer of geometry that is not there.
pub(super) fn load_buffers<'a>(
    path: &Path,
    document: &Document,
    bin: Option<&'a [u8]>,
    beside: &mut source::Beside,
    remarks: &mut Remarks,
) -> Result<BufferData<'a>, AssetError> {
    let mut data = BufferData::new();
    let needed = buffers_of_geometry(document);
    let buffers = &document.as_json().buffers;
    // The first buffer, if it does not name a file; some exporters have it elsewhere in the list.
    let of_chunk = buffers.iter().position(|buffer| buffer.uri.is_none()).unwrap_or(0);
    if of_chunk > 0 && bin.is_some() {
        remarks.fault(format!("buffer {of_chunk}: has no URI and is not the first; read from the file's binary chunk"));
    }
    for (i, buffer) in buffers.iter().enumerate() {
        if meshopt::is_fallback(buffer) {
            // What refers to it is decoded from other buffers.
            data.push(Cow::Borrowed(&[][..]));
            continue;
        }
        let chunk = bin.filter(|_| i == of_chunk);
        match load_buffer(path, i, buffer, chunk, beside, remarks) {
            Err(error) if needed.contains(&i) => return Err(error),
            result => data.push(remarks.part(result, "what it holds is left out")?.unwrap_or_default()),
        }
    }
    Ok(data)
}

fn load_buffer<'a>(
    path: &Path,
    index: usize,
    buffer: &gltf::json::Buffer,
    chunk: Option<&'a [u8]>,
    beside: &mut source::Beside,
    remarks: &mut Remarks,
) -> Result<Cow<'a, [u8]>, AssetError> {
    let (place, wanted) = (format!("buffer {index}"), buffer.byte_length.0);
    let (bytes, is_chunk) = match (&buffer.uri, chunk) {
        (None, Some(chunk)) => (Cow::Borrowed(chunk), true),
        (None, None) => {
            return Err(AssetError::format(path, place, "has no URI, and the file has no binary chunk for it"));
        }
        (Some(uri), chunk) => match (source::fetch(path, &place, uri, beside, remarks), chunk) {
            (Ok(bytes), _) => (Cow::Owned(bytes), false),
            (Err(error @ AssetError::Budget { .. }), _) | (Err(error), None) => return Err(error),
            (Err(error), Some(chunk)) => {
                remarks.broken(&error, "the binary chunk of the file is read in its place");
                (Cow::Borrowed(chunk), true)
            }
        },
    };
    let found = bytes.len() as u64;
    // A binary chunk is padded to a multiple of four.
    let padding = if is_chunk { 3 } else { 0 };
    if wanted == 0 || found < wanted {
        // What lies beyond the end is missed by those that need it.
        remarks.fault(format!("{place}: has {found} bytes, and its byteLength is {wanted}; what is there is read"));
        return Ok(bytes);
    }
    if found > wanted + padding {
        remarks.push(format!("{place}: {} bytes beyond its length are ignored", found - wanted));
    }
    Ok(truncate(bytes, wanted as usize))
}

fn truncate(bytes: Cow<'_, [u8]>, length: usize) -> Cow<'_, [u8]> {
    match bytes {
        Cow::Borrowed(b) => Cow::Borrowed(&b[..length]),
        Cow::Owned(mut b) => {
            b.truncate(length);
            Cow::Owned(b)
        }
    }
}

/// Checks all buffer views and accessors. Faults that no part has noted are noted.
pub(super) fn check_data(document: &Document, buffers: &Buffers, remarks: &mut Remarks) {
    for view in document.views() {
        let stride = view.stride().unwrap_or(4);
        let problem = if !(4..=252).contains(&stride) || stride % 4 != 0 {
            Some(format!("stride {stride} must be a multiple of 4 between 4 and 252"))
        } else if view.stride().is_some_and(|s| s > view.length()) {
            Some(format!("stride {stride} is larger than the view ({} bytes)", view.length()))
        } else {
            None
        };
        let problem = problem.map(|p| AssetError::format(buffers.path, format!("buffer view {}", view.index()), p));
        let error = problem.or_else(|| buffers.view(&view).err()).or_else(|| buffers.check_length(&view).err());
        if let Some(error) = error {
            remarks.unused(&error);
        }
    }
    for error in document.accessors().filter_map(|accessor| buffers.check_all(&accessor).err()) {
        remarks.unused(&error);
    }
}
