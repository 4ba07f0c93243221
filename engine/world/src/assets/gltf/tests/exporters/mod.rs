//! Faults that exporters are known for, one input each: a small model that has everything, an edit of it, and what must come of it.
//!
//! The faults are those of the lists that `docs/gltf.md` names: the issues of the glTF validator, and what other importers work
//! around.

mod containers;
mod geometry;
mod materials;
mod nodes;
mod rigs;

use super::*;
use gltf::json::Value;

/// A change of the model.
#[derive(Clone, Debug)]
enum Edit {
    /// Sets a value, by its JSON pointer; `null` takes it away.
    Set(&'static str, &'static str),
    /// Replaces the bytes of an accessor.
    Bytes(usize, Vec<u8>),
}
use Edit::{Bytes, Set};

/// What must come of a fault.
enum Outcome {
    /// No word, and the model is as it would be with these edits.
    Read(&'static [Edit]),
    /// A fault with these words, and the model is as it would be with these edits.
    Mended(&'static [Edit], &'static [&'static str]),
    /// A fault with these words; the square is drawn.
    Warned(&'static [&'static str]),
    /// An error with these words.
    Refused(&'static [&'static str]),
}
use Outcome::{Mended, Read, Refused, Warned};

/// Name, edits, outcome.
type Case = (&'static str, Vec<Edit>, Outcome);

const POSITION: usize = 0;
const NORMAL: usize = 1;
const TANGENT: usize = 2;
const UV: usize = 3;
const COLOR: usize = 4;
const JOINTS: usize = 5;
const WEIGHTS: usize = 6;
const TARGET: usize = 7;
const INDICES: usize = 8;
const BIND: usize = 9;
const TIMES: usize = 10;
const MOVES: usize = 11;
const TURNS: usize = 12;
const MORPHS: usize = 13;
const IMAGE: usize = 14;

fn shorts(values: &[i16]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

fn words(values: &[u32]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

/// Bytes of the accessors, each of which has a buffer view of its own; the last view has the image.
fn contents() -> Vec<Vec<u8>> {
    let identity = Mat4::IDENTITY.to_cols_array();
    vec![
        floats(&[0., 0., 0., 1., 0., 0., 1., 1., 0., 0., 1., 0.]),
        floats(&[[0., 0., 1.]; 4].concat()),
        floats(&[[1., 0., 0., 1.]; 4].concat()),
        floats(&[0., 1., 1., 1., 1., 0., 0., 0.]),
        floats(&[[1., 0., 1., 1.], [0., 1., 0., 1.], [0., 0., 1., 1.], [1., 1., 0., 1.]].concat()),
        [[0u8, 1, 0, 0], [1, 0, 0, 0], [0, 0, 0, 0], [0, 0, 0, 0]].concat(),
        floats(&[[0.5, 0.5, 0., 0.], [1., 0., 0., 0.], [1., 0., 0., 0.], [1., 0., 0., 0.]].concat()),
        floats(&[0., 0., 0., 0., 0., 1., 0., 0., 1., 0., 0., 1.]),
        shorts(&[0, 1, 2, 0, 2, 3]),
        floats(&[identity, identity].concat()),
        floats(&[0., 1., 2.]),
        floats(&[0., 0., 0., 1., 0., 0., 2., 0., 0.]),
        floats(&[0., 0., 0., 1., 0., 0., 1., 0., 0., 1., 0., 0.]),
        floats(&[0., 1., 0.]),
        png(3, 2),
    ]
}

/// The model without its buffer and its buffer views.
const MODEL: &str = r#"{
    "asset": {"version": "2.0", "generator": "x"}, "scene": 0, "scenes": [{"nodes": [0, 1, 3]}],
    "extensionsUsed": ["KHR_lights_punctual", "KHR_texture_transform"],
    "extensions": {"KHR_lights_punctual": {"lights": [{"type": "point", "intensity": 2}]}},
    "cameras": [{"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}}],
    "nodes": [{"name": "body", "mesh": 0, "skin": 0}, {"name": "hip", "children": [2]},
        {"name": "knee", "translation": [0, 0, 1]},
        {"name": "view", "camera": 0, "extensions": {"KHR_lights_punctual": {"light": 0}}}],
    "meshes": [{"name": "square", "weights": [0.5], "primitives": [{"material": 0, "indices": 8, "targets": [{"POSITION": 7}],
        "attributes": {"POSITION": 0, "NORMAL": 1, "TANGENT": 2, "TEXCOORD_0": 3, "COLOR_0": 4, "JOINTS_0": 5, "WEIGHTS_0": 6}}]}],
    "skins": [{"joints": [1, 2], "inverseBindMatrices": 9}],
    "materials": [{"name": "paint", "alphaMode": "MASK", "doubleSided": true, "emissiveFactor": [0, 0.5, 1],
        "normalTexture": {"index": 0}, "pbrMetallicRoughness":
            {"baseColorFactor": [0.5, 0.25, 1, 1], "baseColorTexture": {"index": 0}, "metallicFactor": 0.25}}],
    "textures": [{"source": 0, "sampler": 0}], "samplers": [{}], "images": [{"bufferView": 14, "mimeType": "image/png"}],
    "animations": [{"name": "walk", "samplers": [{"input": 10, "output": 11}, {"input": 10, "output": 12, "interpolation": "LINEAR"},
            {"input": 10, "output": 13}],
        "channels": [{"sampler": 0, "target": {"node": 1, "path": "translation"}},
            {"sampler": 1, "target": {"node": 1, "path": "rotation"}}, {"sampler": 2, "target": {"node": 0, "path": "weights"}}]}],
    "accessors": [
        {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]},
        {"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC3"},
        {"bufferView": 2, "componentType": 5126, "count": 4, "type": "VEC4"},
        {"bufferView": 3, "componentType": 5126, "count": 4, "type": "VEC2"},
        {"bufferView": 4, "componentType": 5126, "count": 4, "type": "VEC4"},
        {"bufferView": 5, "componentType": 5121, "count": 4, "type": "VEC4"},
        {"bufferView": 6, "componentType": 5126, "count": 4, "type": "VEC4"},
        {"bufferView": 7, "componentType": 5126, "count": 4, "type": "VEC3"},
        {"bufferView": 8, "componentType": 5123, "count": 6, "type": "SCALAR"},
        {"bufferView": 9, "componentType": 5126, "count": 2, "type": "MAT4"},
        {"bufferView": 10, "componentType": 5126, "count": 3, "type": "SCALAR"},
        {"bufferView": 11, "componentType": 5126, "count": 3, "type": "VEC3"},
        {"bufferView": 12, "componentType": 5126, "count": 3, "type": "VEC4"},
        {"bufferView": 13, "componentType": 5126, "count": 3, "type": "SCALAR"}]
}"#;

/// The model with edits, as JSON, and the content of its buffer.
fn edited(edits: &[Edit]) -> (Value, Vec<u8>) {
    let mut contents = contents();
    for edit in edits {
        if let Bytes(accessor, bytes) = edit {
            contents[*accessor] = bytes.clone();
        }
    }
    let (mut bin, mut views) = (Vec::new(), Vec::new());
    for content in contents {
        views.push(format!(r#"{{"buffer":0,"byteOffset":{},"byteLength":{}}}"#, bin.len(), content.len()));
        bin.extend(content);
        bin.resize(bin.len().next_multiple_of(4), 0);
    }
    let mut root: Value = gltf::json::deserialize::from_str(MODEL).unwrap();
    let json = |text: &str| gltf::json::deserialize::from_str::<Value>(text).unwrap_or_else(|e| panic!("{text}: {e}"));
    root["bufferViews"] = json(&format!("[{}]", views.join(",")));
    root["buffers"] = json(&format!(r#"[{{"byteLength":{}}}]"#, bin.len()));
    for edit in edits {
        if let Set(pointer, value) = edit {
            set(&mut root, pointer, json(value));
        }
    }
    (root, bin)
}

fn set(root: &mut Value, pointer: &str, value: Value) {
    let (parent, name) = pointer.rsplit_once('/').unwrap();
    let parent = root.pointer_mut(parent).unwrap_or_else(|| panic!("{pointer}: there is no {parent}"));
    match parent {
        Value::Array(items) if name == "-" => items.push(value),
        Value::Array(items) => items[name.parse::<usize>().unwrap()] = value,
        Value::Object(fields) if value.is_null() => drop(fields.remove(name)),
        Value::Object(fields) => drop(fields.insert(name.into(), value)),
        other => panic!("{pointer}: {other}"),
    }
}

fn chunk(kind: u32, content: &[u8]) -> Vec<u8> {
    [&words(&[content.len() as u32, kind]), content].concat()
}

const JSON: u32 = 0x4E4F_534A;
const BIN: u32 = 0x004E_4942;

fn header(length: usize) -> Vec<u8> {
    words(&[0x4654_6C67, 2, length as u32])
}

/// A binary file of these chunks, with a header of their length.
fn glb(chunks: &[Vec<u8>]) -> Vec<u8> {
    let body = chunks.concat();
    [header(12 + body.len()), body].concat()
}

/// JSON as a chunk has it, filled up to a multiple of four.
fn text(root: &Value) -> Vec<u8> {
    let mut text = root.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    text
}

fn load_edited(edits: &[Edit]) -> Result<Gltf, AssetError> {
    let (root, bin) = edited(edits);
    Gltf::from_bytes(Path::new("folder/test.glb"), &glb(&[chunk(JSON, &text(&root)), chunk(BIN, &bin)]))
}

/// All that a model is, but for identities and names of meshes.
fn summary(model: &Gltf) -> String {
    let mut lines = vec![format!("roots {:?} skins {:?} clips {:?}", model.roots, model.skins, model.clips)];
    for node in &model.nodes {
        let (parts, rest) = ((&node.name, node.parent, &node.children, node.local), (&node.weights, node.skin));
        lines.push(format!("{parts:?} {rest:?} {:?} {:?} {:?}", node.camera, node.light, node.instances));
        for (mesh, m) in &node.primitives {
            lines.push(format!("{:?} {:?} {:?} {:?}", mesh.vertices, mesh.indices, mesh.extras, mesh.deform));
            let factors =
                (m.base_color, m.metallic, m.roughness, m.specular, m.specular_color, m.emissive, m.normal_scale);
            let textures = m.textures();
            let used = textures.iter().filter_map(|(texture, map)| texture.map(|texture| (texture, map)));
            let textures: Vec<_> =
                used.map(|(t, map)| (t.width, t.height, &t.rgba, t.srgb, t.sampling, *map)).collect();
            lines.push(format!("{factors:?} {:?} {} {:?} {textures:?}", m.alpha_mode, m.double_sided, m.unlit));
        }
    }
    lines.join("\n")
}

/// Asserts that two models are the same.
fn same(name: &str, found: &Gltf, wanted: &Gltf) {
    let (found, wanted) = (summary(found), summary(wanted));
    let differing = found.lines().zip(wanted.lines()).find(|(a, b)| a != b);
    assert!(found == wanted, "{name}: differs: {differing:#?}");
}

fn says(name: &str, model: &Gltf, words: &[&str]) {
    let is_said = model.faults.iter().any(|fault| words.iter().all(|word| fault.contains(word)));
    assert!(is_said, "{name}: {words:?} are not in {:#?}", model.faults);
}

fn check(cases: Vec<Case>) {
    for (name, edits, outcome) in cases {
        let result = load_edited(&edits);
        if let Refused(words) = outcome {
            let message = result.map(|model| model.faults).expect_err(name).to_string();
            assert!(words.iter().all(|word| message.contains(word)), "{name}: {words:?} are not in {message}");
            continue;
        }
        let model = result.unwrap_or_else(|error| panic!("{name}: {error}"));
        let sound = |edits: &[Edit]| load_edited(edits).unwrap();
        match outcome {
            Read(edits) => {
                assert!(model.faults.is_empty(), "{name}: {:?}", model.faults);
                same(name, &model, &sound(edits));
            }
            Mended(edits, words) => {
                same(name, &model, &sound(edits));
                says(name, &model, words);
            }
            Warned(words) => {
                says(name, &model, words);
                assert_eq!(model.triangle_count(), 2, "{name}");
            }
            Refused(_) => {}
        }
    }
}

#[test]
fn the_model_without_an_edit_has_no_fault() {
    let model = load_edited(&[]).unwrap();
    assert!(model.warnings.is_empty(), "{:?}", model.warnings);
    assert_eq!((model.triangle_count(), model.clips[0].nodes.len()), (2, 2));
}
