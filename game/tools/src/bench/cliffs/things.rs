//! The things that a model can hold, each as a small model of its own, and the plain room that they are put into.

use crate::bench::growth::container;
use crate::bench::picture::Canvas;
use anyhow::{Context, Result};
use serde_json::{Value, json};
use std::path::Path;

/// Edge of the largest texture \[texels\].
const TEXTURE: u32 = 4096;

/// One of the things.
pub struct Thing {
    /// Its name in the report.
    pub name: &'static str,
    content: Content,
}

/// What a thing adds to the plain room.
enum Content {
    /// Nothing: the plain room.
    Nothing,
    /// A card of two triangles with properties of its material, and the extensions that they need.
    Card(fn() -> Value),
    /// The card, bent by a morph target.
    Morph,
    /// The card, held by a joint.
    Skin,
    /// Lines of the scene's text.
    Text(&'static str),
}

/// All things, the plain room first.
pub const THINGS: [Thing; 15] = [
    Thing { name: "plain", content: Content::Nothing },
    Thing { name: "opaque card", content: Content::Card(|| json!({})) },
    Thing {
        name: "blend",
        content: Content::Card(
            || json!({"alphaMode": "BLEND", "pbrMetallicRoughness": {"baseColorFactor": [0.6, 0.5, 0.4, 0.5], "metallicFactor": 0}}),
        ),
    },
    Thing {
        name: "mask",
        content: Content::Card(
            || json!({"alphaMode": "MASK", "pbrMetallicRoughness": {"baseColorTexture": {"index": 1}, "metallicFactor": 0}}),
        ),
    },
    Thing { name: "glass", content: Content::Card(|| extension("transmission", json!({"transmissionFactor": 0.9}))) },
    Thing { name: "coat", content: Content::Card(|| extension("clearcoat", json!({"clearcoatFactor": 1.0}))) },
    Thing {
        name: "sheen",
        content: Content::Card(|| {
            extension("sheen", json!({"sheenColorFactor": [0.5, 0.5, 0.5], "sheenRoughnessFactor": 0.5}))
        }),
    },
    Thing { name: "emissive", content: Content::Card(|| json!({"emissiveFactor": [1, 0.8, 0.6]})) },
    Thing {
        name: "mirror",
        content: Content::Card(|| json!({"pbrMetallicRoughness": {"metallicFactor": 1, "roughnessFactor": 0}})),
    },
    Thing {
        name: "4k texture",
        content: Content::Card(
            || json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, "metallicFactor": 0}}),
        ),
    },
    Thing { name: "morph", content: Content::Morph },
    Thing { name: "skin", content: Content::Skin },
    Thing {
        name: "fifth light",
        content: Content::Text(
            "(name: \"Fifth\", transform: (translation: (-2, 1, -2)), light: (kind: Point, intensity: 0.2, range: 1)),\n",
        ),
    },
    Thing {
        name: "fog",
        content: Content::Text(
            "(name: \"Fog\", transform: (translation: (-2.6, 0.3, -2.6)), fog: (shape: Sphere(radius: 0.2), extinction: 0.5)),\n",
        ),
    },
    Thing {
        name: "particles",
        content: Content::Text(
            "(name: \"Sparks\", transform: (translation: (-2.6, 0.3, -2.6)), particles: (rate: 5, velocity: (0, 0.1, 0), gravity: (0, 0, 0))),\n",
        ),
    },
];

fn extension(name: &str, value: Value) -> Value {
    json!({"extensions": {format!("KHR_materials_{name}"): value}, "pbrMetallicRoughness": {"metallicFactor": 0}})
}

impl Thing {
    /// Writes the room with the thing in it as a scene; gives its file name.
    ///
    /// # Errors
    /// If a file cannot be written.
    pub fn write(&self, folder: &Path) -> Result<String> {
        let file = self.name.replace(' ', "-");
        let model = match &self.content {
            Content::Nothing | Content::Text(_) => None,
            Content::Card(material) => Some(card(&material(), Deformed::No)),
            Content::Morph => Some(card(&json!({}), Deformed::Morph)),
            Content::Skin => Some(card(&json!({}), Deformed::Skin)),
        };
        let mut text = room();
        if let Content::Text(more) = self.content {
            text += more;
        }
        if let Some(model) = model {
            write(&folder.join(format!("{file}.glb")), &model)?;
            text += &format!("(name: \"Thing\", model: (path: \"{file}.glb\")),\n");
        }
        let scene = format!("{file}.scene.ron");
        write(&folder.join(&scene), (text + "])\n").as_bytes())?;
        Ok(scene)
    }
}

fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    std::fs::write(path, bytes).with_context(|| format!("cannot write {}", path.display()))
}

/// Writes the textures that models name.
///
/// # Errors
/// If a file cannot be written.
pub fn write_textures(folder: &Path) -> Result<()> {
    Canvas::new([TEXTURE; 2]).save(&folder.join("large.png"))?;
    Canvas::new([4; 2]).save(&folder.join("small.png"))
}

/// A room of 6 m with four lights, boxes and balls: some ten thousand triangles. What is added stands in a corner.
fn room() -> String {
    let mut text = String::from(
        "Scene(gi: Clpv, settings: (exposure: 1), materials: {\"wall\": (color: (0.7, 0.7, 0.65), specular: 0), \
         \"red\": (color: (0.6, 0.1, 0.1), specular: 0), \"blue\": (color: (0.1, 0.2, 0.6), specular: 0)}, entities: [\n\
         (name: \"Camera\", transform: (translation: (2.4, 1.6, 2.6), look_at: (0.8, 1, -2)), camera: (fov: 60)),\n\
         (name: \"Light volume\", transform: (translation: (0, 1.5, 0)), clpv: (quality: Medium)),\n\
         (name: \"Floor\", mesh: Box(size: (6, 0.1, 6)), material: \"wall\"),\n\
         (name: \"Ceiling\", transform: (translation: (0, 3, 0)), mesh: Box(size: (6, 0.1, 6)), material: \"wall\"),\n\
         (name: \"Left\", transform: (translation: (-3, 1.5, 0)), mesh: Box(size: (0.1, 3, 6)), material: \"red\"),\n\
         (name: \"Right\", transform: (translation: (3, 1.5, 0)), mesh: Box(size: (0.1, 3, 6)), material: \"blue\"),\n\
         (name: \"Back\", transform: (translation: (0, 1.5, -3)), mesh: Box(size: (6, 3, 0.1)), material: \"wall\"),\n\
         (name: \"Front\", transform: (translation: (0, 1.5, 3)), mesh: Box(size: (6, 3, 0.1)), material: \"wall\"),\n",
    );
    for (x, z) in [(-1.5, -1.5), (1.5, -1.5), (-1.5, 1.5), (1.5, 1.5)] {
        text += &format!(
            "(name: \"Light {x} {z}\", transform: (translation: ({x}, 2.7, {z})), light: (kind: Point, intensity: 2)),\n\
             (name: \"Ball {x} {z}\", transform: (translation: ({x}, 0.4, {z})), \
             mesh: Sphere(radius: 0.35, segments: 52, rings: 26), material: \"wall\"),\n"
        );
    }
    text
}

/// How the card's corners move.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Deformed {
    No,
    Morph,
    Skin,
}

/// A card of 0.3 m in a corner, as a glTF binary file.
fn card(material: &Value, deformed: Deformed) -> Vec<u8> {
    let corners = [[-2.8, 0.6, -2.7], [-2.5, 0.6, -2.7], [-2.5, 0.9, -2.7], [-2.8, 0.9, -2.7]];
    let mut bytes: Vec<u8> = Vec::new();
    let mut views = Vec::new();
    let mut accessors = Vec::new();
    let mut add = |data: &[u8], component: u32, kind: &str, count: usize| {
        views.push(json!({"buffer": 0, "byteOffset": bytes.len(), "byteLength": data.len()}));
        accessors
            .push(json!({"bufferView": views.len() - 1, "componentType": component, "count": count, "type": kind}));
        bytes.extend_from_slice(data);
        accessors.len() - 1
    };
    let floats = |values: &[f32]| values.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<u8>>();
    let position = add(&floats(corners.as_flattened()), 5126, "VEC3", 4);
    let normal = add(&floats(&[0.0, 0.0, 1.0].repeat(4)), 5126, "VEC3", 4);
    let uv = add(&floats(&[0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 1.0]), 5126, "VEC2", 4);
    let indices: Vec<u8> = [0u16, 1, 2, 0, 2, 3].iter().flat_map(|index| index.to_le_bytes()).collect();
    let indices = add(&indices, 5123, "SCALAR", 6);
    let mut attributes = json!({"POSITION": position, "NORMAL": normal, "TEXCOORD_0": uv});
    let mut mesh = json!({});
    let mut node = json!({"mesh": 0, "name": "Card"});
    let mut document = json!({});
    let mut primitive = json!({"indices": indices, "material": 0});
    match deformed {
        Deformed::No => {}
        Deformed::Morph => {
            primitive["targets"] = json!([{"POSITION": add(&floats(&[0.0, 0.0, 0.1].repeat(4)), 5126, "VEC3", 4)}]);
            mesh["weights"] = json!([0.5]);
        }
        Deformed::Skin => {
            attributes["JOINTS_0"] = json!(add(&[0; 16], 5121, "VEC4", 4));
            attributes["WEIGHTS_0"] = json!(add(&floats(&[1.0, 0.0, 0.0, 0.0].repeat(4)), 5126, "VEC4", 4));
            node["skin"] = json!(0);
            document["skins"] = json!([{"joints": [1]}]);
        }
    }
    primitive["attributes"] = attributes;
    mesh["primitives"] = json!([primitive]);
    accessors[position]["min"] = json!([-2.8, 0.6, -2.7]);
    accessors[position]["max"] = json!([-2.5, 0.9, -2.7]);
    let mut material = material.clone();
    if material.get("pbrMetallicRoughness").is_none() {
        material["pbrMetallicRoughness"] = json!({"metallicFactor": 0});
    }
    let used: Vec<String> =
        material["extensions"].as_object().map(|extensions| extensions.keys().cloned().collect()).unwrap_or_default();
    let text = material.to_string();
    if text.contains("Texture") {
        document["images"] = json!([{"uri": "large.png"}, {"uri": "small.png"}]);
        document["textures"] = json!([{"source": 0}, {"source": 1}]);
    }
    if !used.is_empty() {
        document["extensionsUsed"] = json!(used);
    }
    document["asset"] = json!({"version": "2.0"});
    document["scene"] = json!(0);
    document["scenes"] = json!([{"nodes": [0, 1]}]);
    document["nodes"] = json!([node, {"name": "Joint"}]);
    document["meshes"] = json!([mesh]);
    document["materials"] = json!([material]);
    document["accessors"] = json!(accessors);
    document["bufferViews"] = json!(views);
    document["buffers"] = json!([{"byteLength": bytes.len()}]);
    container(&document, bytes)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use lightwell::gpu::Gpu;
    use lightwell_runtime::cli::{Common, LookArgs};
    use lightwell_runtime::session::Session;
    use std::sync::Arc;

    #[test]
    fn every_room_opens_and_holds_what_it_is_named_after() {
        let folder = tempfile::tempdir().unwrap();
        write_textures(folder.path()).unwrap();
        let gpu = Arc::new(Gpu::noop(&Default::default()).unwrap());
        let mut plain = 0;
        for thing in &THINGS {
            let scene = folder.path().join(thing.write(folder.path()).unwrap());
            let (look, common) = (LookArgs::default(), Common::default());
            let session = Session::open(gpu.clone(), &scene.to_string_lossy(), &look, &common).unwrap();
            let surfaces = session.scene().primitives.iter().filter(|p| !p.is_particles());
            let triangles: usize = surfaces.map(|p| p.mesh.triangle_count()).sum();
            match &thing.content {
                Content::Nothing => plain = triangles,
                Content::Text(_) => assert_eq!(triangles, plain, "{}", thing.name),
                _ => assert_eq!(triangles, plain + 2, "{}", thing.name),
            }
            assert_eq!(session.scene().lights.len(), if thing.name == "fifth light" { 5 } else { 4 });
        }
        assert!((9_000..20_000).contains(&plain), "{plain} triangles");
    }
}
