//! A model of many meshes, as a glTF binary file.

use serde_json::{Value, json};

/// Corners of a box and the two directions along each of its faces.
const FACES: [([f32; 3], [f32; 3], [f32; 3]); 6] = [
    ([0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]),
    ([1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0]),
    ([1.0, 0.0, 1.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]),
    ([0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]),
    ([0.0, 1.0, 1.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]),
    ([0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]),
];

/// So many boxes in a square of 20 m, each a mesh of its own, all of one material.
pub fn boxes(count: usize) -> Vec<u8> {
    let edge = (count as f64).sqrt().ceil() as usize;
    let room = 20.0 / edge as f32;
    let mut bytes = Vec::new();
    let (mut accessors, mut meshes, mut nodes) = (Vec::new(), Vec::new(), Vec::new());
    for index in 0..count {
        let size = [0.5 * room, room * (0.3 + 0.07 * (index % 11) as f32), 0.5 * room];
        let place = [(index % edge) as f32 * room - 10.0, 0.0, (index / edge) as f32 * room - 10.0];
        let offset = bytes.len();
        add_box(&mut bytes, size);
        let accessor = |kind: &str, part: usize, count: usize, component: u32| json!({"bufferView": 0, "byteOffset": offset + part, "componentType": component, "count": count, "type": kind});
        let mut positions = accessor("VEC3", 0, 24, 5126);
        positions["min"] = json!([0, 0, 0]);
        positions["max"] = json!(size);
        accessors.extend([positions, accessor("VEC3", 288, 24, 5126), accessor("SCALAR", 576, 36, 5125)]);
        let first = 3 * index;
        let primitive =
            json!({"attributes": {"POSITION": first, "NORMAL": first + 1}, "indices": first + 2, "material": 0});
        meshes.push(json!({"primitives": [primitive]}));
        nodes.push(json!({"mesh": index, "name": format!("Box {index}"), "translation": place}));
    }
    let roots: Vec<usize> = (0..count).collect();
    let document = json!({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": roots}], "nodes": nodes, "meshes": meshes,
        "accessors": accessors, "bufferViews": [{"buffer": 0, "byteLength": bytes.len()}],
        "buffers": [{"byteLength": bytes.len()}],
        "materials": [{"pbrMetallicRoughness": {"baseColorFactor": [0.6, 0.5, 0.4, 1], "metallicFactor": 0}}],
    });
    container(&document, bytes)
}

/// Positions, normals and indices of a box with a corner at the origin.
fn add_box(bytes: &mut Vec<u8>, size: [f32; 3]) {
    let mut normals: Vec<f32> = Vec::with_capacity(72);
    let mut put = |value: [f32; 3]| value.iter().for_each(|x| bytes.extend(x.to_le_bytes()));
    for (corner, u, v) in FACES {
        for (a, b) in [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)] {
            put([0, 1, 2].map(|i| size[i] * (corner[i] + a * u[i] + b * v[i])));
        }
        let normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        (0..4).for_each(|_| normals.extend(normal));
    }
    normals.iter().for_each(|x| bytes.extend(x.to_le_bytes()));
    let indices = (0..6u32).flat_map(|face| [0, 1, 2, 0, 2, 3].map(|corner| 4 * face + corner));
    indices.for_each(|index| bytes.extend(index.to_le_bytes()));
}

/// Header, the document padded with spaces, the buffer (glTF 2.0, section 4.4).
pub fn container(document: &Value, buffer: Vec<u8>) -> Vec<u8> {
    let mut text = document.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let total = 12 + 8 + text.len() + 8 + buffer.len();
    let word = |value: usize| (value as u32).to_le_bytes();
    let mut bytes = [&b"glTF"[..], &word(2), &word(total), &word(text.len()), b"JSON"].concat();
    bytes.extend(text);
    bytes.extend(word(buffer.len()));
    bytes.extend(b"BIN\0");
    bytes.extend(buffer);
    bytes
}
