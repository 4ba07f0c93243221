//! The JSON document: parsing, validation, extensions, and loading of its buffers.

use super::accessor::Buffers;
use super::{BufferData, draco, meshopt, source};
use crate::assets::AssetError;
use gltf::Document;
use gltf::json::camera;
use gltf::json::extensions::scene::khr_lights_punctual::Type;
use gltf::json::validation::Checked;
use std::borrow::Cow;
use std::path::Path;

/// Extensions that are read, at least as far as to draw the file sensibly.
const SUPPORTED: [&str; 21] = [
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

/// Parses and validates the document. Returns whether it uses `KHR_mesh_quantization` too.
pub(super) fn parse(path: &Path, json: &[u8], warnings: &mut Vec<String>) -> Result<(Document, bool), AssetError> {
    let mut root: gltf::json::Root = gltf::json::deserialize::from_slice(json).map_err(|e| {
        AssetError::format(path, format!("JSON, line {}, column {}", e.line(), e.column()), e.to_string())
    })?;
    check_version(path, &root.asset)?;
    check_extensions(path, &root, warnings)?;
    check_attributes(path, &root)?;
    check_channels(path, &root)?;
    check_kinds(path, &root)?;
    draco::give_views(&mut root);
    let quantized = root.extensions_used.iter().any(|e| e == "KHR_mesh_quantization");
    // They were checked above, against what is supported here rather than by the parser.
    root.extensions_required.clear();
    let document = Document::from_json(root).map_err(|e| describe(path, &e))?;
    Ok((document, quantized))
}

fn describe(path: &Path, error: &gltf::Error) -> AssetError {
    use gltf::json::validation::Error as Kind;
    let gltf::Error::Validation(faults) = error else {
        return AssetError::format(path, "document", error.to_string());
    };
    let Some((place, kind)) = faults.first() else {
        return AssetError::format(path, "document", "is not valid");
    };
    let problem = match kind {
        Kind::IndexOutOfBounds => "refers to something that is not in the file (index out of range)",
        Kind::Invalid => "has a value that glTF 2.0 does not allow here",
        Kind::Missing => "is required, but missing",
        Kind::Oversize => "is larger than this system's memory",
        Kind::Unsupported => "is not supported",
    };
    let more = if faults.len() > 1 { format!(" (and {} more faults)", faults.len() - 1) } else { String::new() };
    AssetError::format(path, place.to_string(), format!("{problem}{more}"))
}

/// The parser's own validation looks into the accessors of positions before it has checked that they are there.
fn check_attributes(path: &Path, root: &gltf::json::Root) -> Result<(), AssetError> {
    let count = root.accessors.len();
    for (m, mesh) in root.meshes.iter().enumerate() {
        for (p, primitive) in mesh.primitives.iter().enumerate() {
            if let Some(index) = primitive.attributes.values().find(|a| a.value() >= count) {
                let problem = format!("refers to accessor {}, but there are {count}", index.value());
                return Err(AssetError::format(path, format!("mesh {m}, primitive {p}"), problem));
            }
        }
    }
    Ok(())
}

/// The parser looks up what channels refer to without a check.
fn check_channels(path: &Path, root: &gltf::json::Root) -> Result<(), AssetError> {
    for (a, animation) in root.animations.iter().enumerate() {
        for (c, channel) in animation.channels.iter().enumerate() {
            let (node, sampler) = (channel.target.node.value(), channel.sampler.value());
            let problem = if matches!(channel.target.path, Checked::Invalid) {
                "moves something that is none of translation, rotation, scale and weights".into()
            } else if node >= root.nodes.len() {
                format!("moves node {node}, but there are {}", root.nodes.len())
            } else if sampler >= animation.samplers.len() {
                format!("refers to sampler {sampler}, but there are {}", animation.samplers.len())
            } else {
                continue;
            };
            return Err(AssetError::format(path, format!("animation {a}, channel {c}"), problem));
        }
        for (s, sampler) in animation.samplers.iter().enumerate() {
            let most = sampler.input.value().max(sampler.output.value());
            if most >= root.accessors.len() {
                let problem = format!("refers to accessor {most}, but there are {}", root.accessors.len());
                return Err(AssetError::format(path, format!("animation {a}, sampler {s}"), problem));
            }
        }
    }
    Ok(())
}

/// Parameters of a kind of camera or light that must be there are unwrapped by the parser.
fn check_kinds(path: &Path, root: &gltf::json::Root) -> Result<(), AssetError> {
    let fail = |place: String, part: &str| {
        Err(AssetError::format(path, place, format!("has no `{part}`, which its type asks for")))
    };
    for (i, camera) in root.cameras.iter().enumerate() {
        let part = match camera.type_ {
            Checked::Valid(camera::Type::Perspective) if camera.perspective.is_none() => "perspective",
            Checked::Valid(camera::Type::Orthographic) if camera.orthographic.is_none() => "orthographic",
            _ => continue,
        };
        return fail(format!("camera {i}"), part);
    }
    let lights = root.extensions.as_ref().and_then(|e| e.khr_lights_punctual.as_ref());
    for (i, light) in lights.iter().flat_map(|all| &all.lights).enumerate() {
        if matches!(light.type_, Checked::Valid(Type::Spot)) && light.spot.is_none() {
            return fail(format!("light {i}"), "spot");
        }
    }
    let count = lights.map_or(0, |all| all.lights.len());
    for (i, node) in root.nodes.iter().enumerate() {
        let light = node.extensions.as_ref().and_then(|e| e.khr_lights_punctual.as_ref());
        if let Some(index) = light.map(|l| l.light.value()).filter(|index| *index >= count) {
            let problem = format!("refers to light {index}, but there are {count}");
            return Err(AssetError::format(path, format!("node {i}"), problem));
        }
    }
    Ok(())
}

fn check_version(path: &Path, asset: &gltf::json::Asset) -> Result<(), AssetError> {
    let parse = |text: &str| -> Option<(u32, u32)> {
        let (major, minor) = text.split_once('.')?;
        Some((major.parse().ok()?, minor.parse().ok()?))
    };
    let fail = |place: &str, problem: String| Err(AssetError::format(path, place, problem));
    match parse(&asset.version) {
        Some((2, _)) => {}
        Some(_) => {
            return fail("asset.version", format!("is {}; only glTF 2 is read: convert the file", asset.version));
        }
        None => {
            return fail("asset.version", format!("{:?} is not a version such as \"2.0\"", asset.version));
        }
    }
    match &asset.min_version {
        Some(least) if parse(least) != Some((2, 0)) => {
            fail("asset.minVersion", format!("is {least:?}; only glTF 2.0 is read"))
        }
        _ => Ok(()),
    }
}

fn check_extensions(path: &Path, root: &gltf::json::Root, warnings: &mut Vec<String>) -> Result<(), AssetError> {
    let known = |e: &str| SUPPORTED.contains(&e);
    for (i, extension) in root.extensions_required.iter().enumerate() {
        if !known(extension) {
            let problem =
                format!("the file needs the extension {extension}, which is not supported: export it without");
            return Err(AssetError::format(path, format!("extensionsRequired[{i}]"), problem));
        }
        if !root.extensions_used.contains(extension) {
            let problem = format!("{extension} is not listed in extensionsUsed");
            return Err(AssetError::format(path, format!("extensionsRequired[{i}]"), problem));
        }
    }
    let unknown = root.extensions_used.iter().filter(|e| !known(e));
    warnings.extend(unknown.map(|e| format!("the extension {e} is not supported and has no effect")));
    Ok(())
}

/// Loads each buffer once: from the file's binary chunk, its data URI, or the file beside it.
pub(super) fn load_buffers<'a>(
    path: &Path,
    document: &Document,
    bin: Option<&'a [u8]>,
    beside: &mut source::Beside,
    warnings: &mut Vec<String>,
) -> Result<BufferData<'a>, AssetError> {
    let mut data = BufferData::new();
    for (i, buffer) in document.as_json().buffers.iter().enumerate() {
        let place = format!("buffer {i}");
        let wanted = buffer.byte_length.0;
        if meshopt::is_fallback(buffer) {
            // What refers to it is decoded from other buffers.
            data.push(Cow::Borrowed(&[][..]));
            continue;
        }
        let bytes = match (&buffer.uri, bin) {
            (Some(uri), _) => Cow::Owned(source::fetch(path, &place, uri, beside)?),
            (None, Some(bin)) if i == 0 => Cow::Borrowed(bin),
            (None, _) => {
                return Err(AssetError::format(path, place, "has no URI, and the file has no binary chunk for it"));
            }
        };
        if wanted == 0 {
            return Err(AssetError::format(path, place, "has no bytes: byteLength must be at least 1"));
        }
        if (bytes.len() as u64) < wanted {
            let problem = format!("is truncated: {} bytes of {wanted} are there", bytes.len());
            return Err(AssetError::format(path, place, problem));
        }
        // A binary chunk is padded to a multiple of four.
        let padding = if buffer.uri.is_none() { 3 } else { 0 };
        if bytes.len() as u64 > wanted + padding {
            warnings.push(format!("{place}: {} bytes beyond its length are ignored", bytes.len() as u64 - wanted));
        }
        data.push(truncate(bytes, wanted as usize));
    }
    Ok(data)
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

/// Checks all buffer views and accessors, used or not.
pub(super) fn check_data(document: &Document, buffers: &Buffers) -> Result<(), AssetError> {
    for view in document.views() {
        buffers.view(&view)?;
        let stride = view.stride().unwrap_or(4);
        if !(4..=252).contains(&stride) || stride % 4 != 0 {
            let problem = format!("stride {stride} must be a multiple of 4 between 4 and 252");
            return Err(AssetError::format(buffers.path, format!("buffer view {}", view.index()), problem));
        }
        if view.stride().is_some_and(|s| s > view.length()) {
            let problem = format!("stride {stride} is larger than the view ({} bytes)", view.length());
            return Err(AssetError::format(buffers.path, format!("buffer view {}", view.index()), problem));
        }
    }
    document.accessors().try_for_each(|accessor| buffers.check(&accessor))
}
