//! Skins, morph targets, animations, instances and surfaces of small files written here.
#![allow(clippy::unwrap_used)]

use super::Gltf;
use crate::assets::{AssetError, Between};
use glam::{Vec2, Vec3};
use gltf::json::Value;
use std::fmt::Write;
use std::path::Path;

/// A file under construction: data goes into its one buffer.
#[derive(Default)]
pub(crate) struct File {
    pub bytes: Vec<u8>,
    views: String,
    accessors: String,
    count: usize,
}

impl File {
    /// Adds an accessor with a view of its own; gives its index.
    pub fn accessor(&mut self, kind: u32, shape: &str, lanes: usize, bytes: &[u8], more: &str) -> usize {
        while !self.bytes.len().is_multiple_of(4) {
            self.bytes.push(0);
        }
        let size = match kind {
            5120 | 5121 => 1,
            5122 | 5123 => 2,
            _ => 4,
        };
        let comma = if self.count > 0 { "," } else { "" };
        let offset = self.bytes.len();
        write!(self.views, "{comma}{{\"buffer\":0,\"byteOffset\":{offset},\"byteLength\":{}}}", bytes.len()).unwrap();
        let (view, count) = (self.count, bytes.len() / size / lanes);
        write!(
            self.accessors,
            "{comma}{{\"bufferView\":{view},\"componentType\":{kind},\"count\":{count},\"type\":\"{shape}\"{more}}}"
        )
        .unwrap();
        self.bytes.extend(bytes);
        self.count += 1;
        view
    }

    pub fn floats(&mut self, shape: &str, lanes: usize, values: &[f32]) -> usize {
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        let bounds = if shape == "VEC3" { ",\"min\":[-9,-9,-9],\"max\":[9,9,9]" } else { "" };
        let bounds = if shape == "SCALAR" { ",\"min\":[0],\"max\":[9]" } else { bounds };
        self.accessor(5126, shape, lanes, &bytes, bounds)
    }

    /// The file as a GLB.
    pub fn glb(&self, rest: &str) -> Vec<u8> {
        let mut json = format!(
            "{{\"asset\":{{\"version\":\"2.0\"}},\"buffers\":[{{\"byteLength\":{}}}],\"bufferViews\":[{}],\"accessors\":[{}],{rest}}}",
            self.bytes.len(),
            self.views,
            self.accessors
        );
        while !json.len().is_multiple_of(4) {
            json.push(' ');
        }
        let mut bin = self.bytes.clone();
        bin.resize(bin.len().next_multiple_of(4), 0);
        let words = |list: &[usize]| list.iter().flat_map(|w| (*w as u32).to_le_bytes()).collect::<Vec<u8>>();
        let mut glb = words(&[0x4654_6C67, 2, 28 + json.len() + bin.len(), json.len(), 0x4E4F_534A]);
        glb.extend(json.as_bytes());
        glb.extend(words(&[bin.len(), 0x004E_4942]));
        glb.extend(bin);
        glb
    }

    fn load(&self, rest: &str) -> Result<Gltf, AssetError> {
        Gltf::from_bytes(Path::new("folder/test.glb"), &self.glb(rest))
    }
}

/// A triangle that follows two joints and has one morph target, and a clip that moves all of it.
pub(crate) fn rigged() -> (File, String) {
    let mut file = File::default();
    let positions = file.floats("VEC3", 3, &[0., 0., 0., 1., 0., 0., 0., 1., 0.]);
    let normals = file.floats("VEC3", 3, &[0., 0., 1., 0., 0., 1., 0., 0., 1.]);
    let joints = file.accessor(5121, "VEC4", 4, &[0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0], "");
    let weights = file.accessor(5121, "VEC4", 4, &[51, 204, 0, 0, 255, 0, 0, 0, 255, 0, 0, 0], ",\"normalized\":true");
    let target = file.floats("VEC3", 3, &[0., 0., 1., 0., 0., 1., 0., 0., 1.]);
    let bind: Vec<f32> = [[1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1.]; 2].concat();
    let bind = file.floats("MAT4", 16, &bind);
    let times = file.floats("SCALAR", 1, &[0.0, 2.0]);
    let moves = file.floats("VEC3", 3, &[0., 0., 0., 4., 0., 0.]);
    let turns = file.accessor(5122, "VEC4", 4, &turns(), ",\"normalized\":true");
    let tangents = file.floats("SCALAR", 1, &[0., 0., 3., 0., 1., 0.]);
    let rest = format!(
        r#""scenes":[{{"nodes":[0,3]}}],"nodes":[{{"name":"hip","children":[1,2]}},{{"name":"knee","translation":[0,0,1]}},
        {{"name":"skinned","mesh":0,"skin":0,"translation":[7,7,7]}},{{"name":"rigid","mesh":0,"weights":[0.25]}}],
        "skins":[{{"joints":[0,1],"inverseBindMatrices":{bind}}}],
        "meshes":[{{"weights":[0.5],"primitives":[{{"attributes":{{"POSITION":{positions},"NORMAL":{normals},
            "JOINTS_0":{joints},"WEIGHTS_0":{weights}}},"targets":[{{"POSITION":{target}}}]}}]}}],
        "animations":[{{"name":"walk","samplers":[{{"input":{times},"output":{moves}}},
            {{"input":{times},"output":{turns},"interpolation":"STEP"}},
            {{"input":{times},"output":{tangents},"interpolation":"CUBICSPLINE"}}],
          "channels":[{{"sampler":0,"target":{{"node":0,"path":"translation"}}}},
            {{"sampler":1,"target":{{"node":1,"path":"rotation"}}}},
            {{"sampler":2,"target":{{"node":3,"path":"weights"}}}}]}}]"#
    );
    (file, rest)
}

/// No turn, then half a turn about x, in normalised shorts.
fn turns() -> Vec<u8> {
    [0i16, 0, 0, 32767, 32767, 0, 0, 0].iter().flat_map(|v| v.to_le_bytes()).collect()
}

#[test]
fn rigs_are_read() {
    let (file, rest) = rigged();
    let model = file.load(&rest).unwrap();
    assert!(model.warnings.is_empty(), "{:?}", model.warnings);
    assert_eq!((model.skins[0].joints.as_slice(), model.nodes[2].skin), (&[0, 1][..], Some(0)));
    assert_eq!((&model.nodes[2].weights[..], &model.nodes[3].weights[..]), (&[0.5][..], &[0.25][..]));
    let deform = model.nodes[2].primitives[0].0.deform.clone().unwrap();
    let skin = deform.skin.as_ref().unwrap();
    assert!((skin.of(0)[0].1 - 0.2).abs() < 1e-6 && skin.of(0)[1].0 == 1, "{:?}", skin.of(0));
    assert_eq!((skin.of(1), skin.of(2)), (&[(1, 1.0)][..], &[(0, 1.0)][..]));
    assert_eq!(deform.targets[0].positions[2], [0.0, 0.0, 1.0]);
    let clip = &model.clips[0];
    assert_eq!((clip.name.as_str(), clip.duration, clip.moves(0), clip.moves(3)), ("walk", 2.0, true, false));
    assert_eq!(clip.nodes[&0].translation.as_ref().unwrap().at(0.5), [1.0, 0.0, 0.0]);
    let turn = clip.nodes[&1].rotation.as_ref().unwrap();
    assert_eq!((turn.between, turn.at(1.9), turn.at(2.0)), (Between::Step, vec![0., 0., 0., 1.], vec![1., 0., 0., 0.]));
    // The spline leaves 0 with a slope of 3 and comes to 1 level: ½ + 2·3/8 half-way.
    assert_eq!(clip.nodes[&3].weights.as_ref().unwrap().at(1.0), [1.25]);
}

#[test]
fn broken_rigs_cost_their_part() {
    let (file, rest) = rigged();
    let mended = |from: &str, to: &str, words: &[&str]| {
        assert!(rest.contains(from), "{from}");
        let model = file.load(&rest.replacen(from, to, 1)).unwrap();
        let is_said = |fault: &String| words.iter().all(|word| fault.contains(word));
        assert!(model.faults.iter().any(is_said), "{words:?} are not in {:?}", model.faults);
        assert!(model.triangle_count() > 0, "{words:?}");
    };
    mended("\"joints\":[0,1]", "\"joints\":[0]", &["node 2", "joint 1", "has 1"]);
    mended("\"joints\":[0,1]", "\"joints\":[0,1,3]", &["skin 0", "2 inverse bind matrices for 3"]);
    mended("\"WEIGHTS_0\":3", "\"WEIGHTS_1\":3", &["JOINTS_0 and WEIGHTS_0"]);
    mended("\"JOINTS_0\":2", "\"JOINTS_0\":5", &["accessor 5", "2 elements"]);
    mended("\"targets\":[{\"POSITION\":4}]", "\"targets\":[{\"POSITION\":6}]", &["accessor 6"]);
    mended("\"output\":7", "\"output\":6", &["channel 0", "accessor 6", "2 numbers for 2 keys"]);
    mended("\"input\":6", "\"input\":9", &["channel 0", "accessor 9", ""]);
    let (again, twice) = (
        "{\"sampler\":1,\"target\":{\"node\":1,\"path\":\"rotation\"}}",
        "\"target\":{\"node\":0,\"path\":\"translation\"}}",
    );
    mended(again, &format!("{{\"sampler\":0,{twice}"), &["another channel"]);
    mended("\"output\":8", "\"output\":2", &["channel 1", "normalised"]);
}

#[test]
fn colours_and_coordinates_of_all_kinds() {
    let mut file = File::default();
    let positions = file.floats("VEC3", 3, &[0., 0., 0., 1., 0., 0., 0., 1., 0.]);
    let uv = file.floats("VEC2", 2, &[0., 0., 1., 0., 0., 1.]);
    let second =
        file.accessor(5123, "VEC2", 2, bytemuck::cast_slice(&[0u16, 65535, 65535, 0, 0, 0]), ",\"normalized\":true");
    let rgb = file.accessor(5121, "VEC3", 3, &[255, 0, 0, 0, 255, 0, 0, 0, 51], ",\"normalized\":true");
    let rgba = file.floats("VEC4", 4, &[2.0, 0.5, 0., 1., 0., 0., 0., 0.25, -1., 0., 0., 0.]);
    let image = "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNkYPhfDwAChwGA60e6kgAAAABJRU5ErkJggg==";
    let mesh = |color: usize| {
        format!(
            r#"{{"primitives":[{{"material":0,"attributes":{{"POSITION":{positions},"TEXCOORD_0":{uv},"TEXCOORD_3":{second},"COLOR_0":{color}}}}}]}}"#
        )
    };
    let rest = format!(
        r#""extensionsUsed":["KHR_texture_transform"],"images":[{{"uri":"{image}"}}],"textures":[{{"source":0}}],
        "materials":[{{"pbrMetallicRoughness":{{"baseColorTexture":{{"index":0,"extensions":{{"KHR_texture_transform":
            {{"offset":[0.5,0],"scale":[2,4]}}}}}}}},
          "normalTexture":{{"index":0,"texCoord":0,"extensions":{{"KHR_texture_transform":{{"texCoord":3,"rotation":1.5707964}}}}}}}}],
        "meshes":[{},{}],"nodes":[{{"mesh":0}},{{"mesh":1}}]"#,
        mesh(rgb),
        mesh(rgba)
    );
    let model = file.load(&rest).unwrap();
    let (mesh, material) = &model.nodes[0].primitives[0];
    assert_eq!((material.uv.base_color.set, material.uv.normal.set), (0, 1));
    assert_eq!(material.uv.base_color.apply([[0.25, 0.5], [9.0, 9.0]]), [1.0, 2.0]);
    // Counter-clockwise on the image, whose v points down: (1, 0) goes to (0, −1).
    let turned = Vec2::from(material.uv.normal.apply([[9.0, 9.0], [1.0, 0.0]]));
    assert!(turned.abs_diff_eq(Vec2::new(0.0, -1.0), 1e-6), "{turned}");
    let at = |position: [f32; 3]| mesh.vertices.iter().position(|v| v.position == position).unwrap();
    let corner = mesh.extra(at([0.0, 1.0, 0.0]));
    assert_eq!((corner.uv, corner.color), ([0.0, 0.0], [0, 0, 13107, 65535]));
    let (mesh, _) = &model.nodes[1].primitives[0];
    let colors: Vec<_> = (0..3).map(|i| mesh.extra(i).color).collect();
    assert_eq!(colors, [[65535, 32768, 0, 65535], [0, 0, 0, 16384], [0, 0, 0, 0]]);
}

#[test]
fn instances_stand_where_their_accessors_say() {
    let mut file = File::default();
    let positions = file.floats("VEC3", 3, &[0., 0., 0., 1., 0., 0., 0., 1., 0.]);
    let places = file.floats("VEC3", 3, &[0., 0., 0., 5., 0., 0.]);
    let rest = format!(
        r#""extensionsUsed":["EXT_mesh_gpu_instancing"],"extensionsRequired":["EXT_mesh_gpu_instancing"],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":{positions}}}}}]}}],
        "nodes":[{{"mesh":0,"extensions":{{"EXT_mesh_gpu_instancing":{{"attributes":{{"TRANSLATION":{places}}}}}}}}}]"#
    );
    let model = file.load(&rest).unwrap();
    assert_eq!((model.nodes[0].instances.len(), model.triangle_count()), (2, 2));
    assert_eq!(model.nodes[0].instances[1].translation, Vec3::X * 5.0);
    let model = file.load(&rest.replace("\"TRANSLATION\":1", "\"TRANSLATION\":8")).unwrap();
    assert!(model.faults[0].contains("accessor 8") && model.triangle_count() == 1, "{:?}", model.faults);
}

#[test]
fn compressed_views_that_lie_about_their_size_are_refused() {
    let mut file = File::default();
    let encoded = meshopt::encode_vertex_buffer(&[[0.0f32; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]).unwrap();
    file.bytes = encoded.clone();
    let json = |count: u64, length: u64| {
        let json = format!(
            r#"{{"asset":{{"version":"2.0"}},"extensionsUsed":["EXT_meshopt_compression"],"extensionsRequired":["EXT_meshopt_compression"],
            "buffers":[{{"byteLength":{size}}},{{"byteLength":{length},"extensions":{{"EXT_meshopt_compression":{{"fallback":true}}}}}}],
            "bufferViews":[{{"buffer":1,"byteLength":{length},"byteStride":12,"extensions":{{"EXT_meshopt_compression":
              {{"buffer":0,"byteLength":{size},"byteStride":12,"count":{count},"mode":"ATTRIBUTES"}}}}}}],
            "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}}],
            "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],"nodes":[{{"mesh":0}}]}}"#,
            size = encoded.len()
        );
        let value: Value = gltf::json::deserialize::from_str(&json).unwrap();
        let mut json = value.to_string();
        while !json.len().is_multiple_of(4) {
            json.push(' ');
        }
        let mut bin = encoded.clone();
        bin.resize(bin.len().next_multiple_of(4), 0);
        let words = |list: &[usize]| list.iter().flat_map(|w| (*w as u32).to_le_bytes()).collect::<Vec<u8>>();
        let mut glb = words(&[0x4654_6C67, 2, 28 + json.len() + bin.len(), json.len(), 0x4E4F_534A]);
        glb.extend(json.as_bytes());
        glb.extend(words(&[bin.len(), 0x004E_4942]));
        glb.extend(bin);
        Gltf::from_bytes(Path::new("m.glb"), &glb)
    };
    let model = json(3, 36).unwrap();
    assert_eq!(model.nodes[0].primitives[0].0.vertices[1].position, [1.0, 0.0, 0.0]);
    for (count, length, word) in [(4, 36, "do not make"), (1 << 40, 12 << 40, "cannot decode"), (300, 3600, "broken")] {
        let model = json(count, length).unwrap();
        assert!(model.faults[0].contains("buffer view 0") && model.faults[0].contains(word), "{:?}", model.faults);
        assert_eq!(model.triangle_count(), 0);
    }
}
