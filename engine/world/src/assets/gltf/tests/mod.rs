//! Import of small files written here, good and bad.
#![allow(clippy::unwrap_used)]

mod broken;
mod exporters;
mod images;
mod layers;

use super::Gltf;
use crate::assets::{AlphaMode, AssetError, AssetLibrary, Levels, Minification, Sampling, Wrap};
use crate::world::{Camera, LightKind};
use glam::{Mat4, Quat, Vec3};
use std::path::Path;
use std::sync::Arc;

fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let group = |c: &[u8]| {
        let value = (0..3).fold(0u32, |v, i| v << 8 | u32::from(*c.get(i).unwrap_or(&0)));
        let digit = |i: usize| if i <= c.len() { DIGITS[(value >> (18 - 6 * i)) as usize & 63] as char } else { '=' };
        (0..4).map(digit).collect::<String>()
    };
    bytes.chunks(3).map(group).collect()
}

fn floats(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

/// A unit square in z = 0: positions at 0, texture coordinates at 48, u16 indices at 80, 12 bytes.
fn square_bytes() -> Vec<u8> {
    let mut bytes = floats(&[0., 0., 0., 1., 0., 0., 1., 1., 0., 0., 1., 0.]);
    bytes.extend(floats(&[0., 1., 1., 1., 1., 0., 0., 0.]));
    bytes.extend([0u16, 1, 2, 0, 2, 3].iter().flat_map(|i| i.to_le_bytes()));
    bytes
}

const VIEWS: &str = r#""bufferViews":[{"buffer":0,"byteLength":48},{"buffer":0,"byteOffset":48,"byteLength":32},
    {"buffer":0,"byteOffset":80,"byteLength":12}]"#;
const ACCESSORS: &str = r#""accessors":[
    {"bufferView":0,"componentType":5126,"count":4,"type":"VEC3","min":[0,0,0],"max":[1,1,0]},
    {"bufferView":1,"componentType":5126,"count":4,"type":"VEC2"},
    {"bufferView":2,"componentType":5123,"count":6,"type":"SCALAR"}]"#;
const MESH: &str =
    r#""meshes":[{"name":"square","primitives":[{"attributes":{"POSITION":0,"TEXCOORD_0":1},"indices":2}]}]"#;
const NODES: &str = r#""scenes":[{"nodes":[0]}],"nodes":[{"name":"a","mesh":0}]"#;

fn document(bytes: &[u8], parts: &[&str]) -> String {
    let uri = format!("data:application/octet-stream;base64,{}", base64(bytes));
    let buffer = format!(r#""buffers":[{{"byteLength":{},"uri":"{uri}"}}]"#, bytes.len());
    format!(r#"{{"asset":{{"version":"2.0"}},{buffer},{}}}"#, parts.join(","))
}

fn load(json: &str) -> Result<Gltf, AssetError> {
    Gltf::from_bytes(Path::new("folder/test.gltf"), json.as_bytes())
}

/// Loads what must be refused, with all these words in the message.
fn refuse(json: &str, words: &[&str]) {
    let message = load(json).unwrap_err().to_string();
    assert!(message.contains("test.gltf"), "{message}");
    for word in words {
        assert!(message.contains(word), "\"{word}\" is not in: {message}");
    }
}

fn png(width: u32, height: u32) -> Vec<u8> {
    let mut out = std::io::Cursor::new(Vec::new());
    image::RgbImage::from_pixel(width, height, image::Rgb([10, 20, 30]))
        .write_to(&mut out, image::ImageFormat::Png)
        .unwrap();
    out.into_inner()
}

#[test]
fn a_square_gets_flat_normals() {
    let model = load(&document(&square_bytes(), &[VIEWS, ACCESSORS, MESH, NODES])).unwrap();
    assert_eq!((model.nodes.len(), &model.roots[..], model.triangle_count()), (1, &[0usize][..], 2));
    let (mesh, material) = &model.nodes[0].primitives[0];
    assert_eq!((mesh.name.as_str(), mesh.vertices.len()), ("square", 6));
    assert!(mesh.vertices.iter().all(|v| v.normal == [0.0, 0.0, 1.0]));
    assert_eq!(mesh.bounds.max, Vec3::new(1.0, 1.0, 0.0));
    assert_eq!((material.metallic, material.roughness), (1.0, 1.0));
    assert!(model.warnings.is_empty(), "{:?}", model.warnings);
}

#[test]
fn nodes_share_meshes_and_keep_mirroring_and_matrices() {
    let turn = Quat::from_rotation_y(0.7);
    let matrix = Mat4::from_scale_rotation_translation(Vec3::new(-2.0, 3.0, 4.0), turn, Vec3::new(1.0, 2.0, 3.0));
    let matrix: Vec<String> = matrix.to_cols_array().iter().map(f32::to_string).collect();
    let nodes = format!(
        r#""scene":0,"scenes":[{{"nodes":[0]}}],"nodes":[{{"children":[1,2]}},{{"mesh":0,"scale":[1,-1,1]}},
           {{"mesh":0,"matrix":[{}]}},{{"name":"outside"}}]"#,
        matrix.join(",")
    );
    let model = load(&document(&square_bytes(), &[VIEWS, ACCESSORS, MESH, &nodes])).unwrap();
    assert_eq!(model.nodes[1].parent, Some(0));
    assert_eq!(model.nodes[0].children, [1, 2]);
    assert_eq!(model.nodes[1].local.scale, Vec3::new(1.0, -1.0, 1.0));
    assert!(Arc::ptr_eq(&model.nodes[1].primitives[0].0, &model.nodes[2].primitives[0].0));
    assert!((model.nodes[2].local.scale - Vec3::new(-2.0, 3.0, 4.0)).length() < 1e-5);
    assert!(model.nodes[2].local.rotation.angle_between(turn) < 1e-3);
    assert_eq!((model.node("outside"), &model.roots[..]), (Some(3), &[0usize][..]));
}

#[test]
fn matrices_without_volume_are_taken() {
    for matrix in [
        "0,0,0,0, 0,0,0,0, 0,0,0,0, 0,0,0,1",
        "0,0,0,0, 0,2,0,0, 0,0,0,0, 0,0,0,1",
        "0,0,0,0, 0,2,0,0, 0,0,3,0, 0,0,0,1",
    ] {
        let model = load(&document(&[0; 4], &[&format!(r#""nodes":[{{"matrix":[{matrix}]}}]"#)])).unwrap();
        assert!(model.nodes[0].local.matrix().is_finite() && model.nodes[0].local.rotation.is_normalized(), "{matrix}");
    }
}

#[test]
fn materials_lights_and_cameras() {
    let mut bytes = square_bytes();
    let picture = png(3, 2);
    bytes.extend(&picture);
    let views =
        VIEWS.replace("12}]", &format!("12}},{{\"buffer\":0,\"byteOffset\":92,\"byteLength\":{}}}]", picture.len()));
    let mesh = MESH.replace("\"indices\"", "\"material\":0,\"indices\"");
    let rest = r#""extensionsUsed":["KHR_lights_punctual","KHR_materials_emissive_strength","KHR_materials_ior","KHR_materials_specular","FANCY_thing"],
        "images":[{"bufferView":3,"mimeType":"image/png"}],
        "samplers":[{"wrapS":33071,"wrapT":33648,"magFilter":9728}],
        "textures":[{"source":0,"sampler":0},{"source":0,"sampler":0}],
        "materials":[{"name":"m","alphaMode":"MASK","alphaCutoff":0.25,"doubleSided":true,"emissiveFactor":[1,0.5,0],
            "normalTexture":{"index":1,"scale":0.5},"emissiveTexture":{"index":1},
            "pbrMetallicRoughness":{"baseColorFactor":[0.1,0.2,0.3,0.4],"metallicFactor":0.5,"roughnessFactor":0.6,
                "baseColorTexture":{"index":0}},
            "extensions":{"KHR_materials_emissive_strength":{"emissiveStrength":4},"KHR_materials_ior":{"ior":2},
                "KHR_materials_specular":{"specularFactor":0.5,"specularColorFactor":[1,0.5,0]}}}],
        "cameras":[{"type":"perspective","perspective":{"yfov":1,"znear":0.1}},
            {"type":"orthographic","orthographic":{"xmag":2,"ymag":1.5,"znear":0,"zfar":9}}],
        "extensions":{"KHR_lights_punctual":{"lights":[{"type":"spot","intensity":5,"color":[1,0,0],
            "spot":{"innerConeAngle":0.1,"outerConeAngle":0.5}}]}},
        "nodes":[{"mesh":0,"camera":0,"extensions":{"KHR_lights_punctual":{"light":0}}},{"camera":1}]"#;
    let model = load(&document(&bytes, &[&views, ACCESSORS, &mesh, rest])).unwrap();
    let node = &model.nodes[0];
    let m = &node.primitives[0].1;
    assert_eq!((m.alpha_mode, m.double_sided, m.metallic, m.roughness), (AlphaMode::Mask(0.25), true, 0.5, 0.6));
    assert_eq!((m.emissive, m.normal_scale, m.specular), (Vec3::new(4.0, 2.0, 0.0), 0.5, 0.5));
    assert!((m.dielectric_reflectance() - Vec3::new(1.0, 0.5, 0.0) * (1.0 / 9.0 / 0.04)).length() < 1e-5);
    let (base, glow) = (m.base_color_texture.as_ref().unwrap(), m.emissive_texture.as_ref().unwrap());
    let normal = m.normal_texture.as_ref().unwrap();
    assert!(Arc::ptr_eq(base, glow) && base.srgb && !normal.srgb);
    assert_eq!((base.width, base.height, &base.rgba[..4]), (3, 2, &[10, 20, 30, 255][..]));
    assert_eq!(normal.rgba, base.rgba);
    let expected = Sampling { wrap_u: Wrap::Clamp, wrap_v: Wrap::Mirror, nearest: true, minification: None };
    assert_eq!(base.sampling, expected);
    assert_eq!(node.light.as_ref().unwrap().intensity, 5.0);
    let LightKind::Spot { inner, outer } = node.light.as_ref().unwrap().kind else { panic!("no spot") };
    assert!((inner - 5.729_578).abs() < 1e-4 && (outer - 28.647_89).abs() < 1e-4);
    assert!((node.camera.as_ref().unwrap().camera().fov - 57.295_78).abs() < 1e-3);
    let parallel = model.nodes[1].camera.as_ref().unwrap();
    let projection = crate::world::Projection::Orthographic { height: 3.0 };
    let expected = Camera { projection, near: 0.0, far: Some(9.0), ..Camera::default() };
    assert_eq!((parallel.camera(), parallel.aspect), (expected, Some(4.0 / 3.0)));
    assert!(model.warnings.iter().any(|w| w.contains("FANCY_thing")), "{:?}", model.warnings);
    // The texture lies upright on the square: the tangent goes along +u, and the bitangent up the image.
    for v in &node.primitives[0].0.vertices {
        assert!((Vec3::from_slice(&v.tangent[..3]) - Vec3::X).length() < 1e-5 && v.tangent[3] == 1.0, "{v:?}");
    }
}

#[test]
fn glass_is_a_thin_wall_or_a_body() {
    let mut bytes = square_bytes();
    let picture = png(3, 2);
    bytes.extend(&picture);
    let views =
        VIEWS.replace("12}]", &format!("12}},{{\"buffer\":0,\"byteOffset\":92,\"byteLength\":{}}}]", picture.len()));
    let load_one = |extensions: &str| {
        let mesh = MESH.replace("\"indices\"", "\"material\":0,\"indices\"");
        let rest = format!(
            r#""extensionsUsed":["KHR_materials_transmission","KHR_materials_volume","KHR_materials_ior"],
            "images":[{{"bufferView":3,"mimeType":"image/png"}}],"textures":[{{"source":0}}],
            "materials":[{{"name":"m","extensions":{{{extensions}}}}}],"nodes":[{{"mesh":0}}]"#
        );
        let model = load(&document(&bytes, &[&views, ACCESSORS, &mesh, &rest])).unwrap();
        (model.nodes[0].primitives[0].1.clone(), model.warnings)
    };
    let factor = r#""KHR_materials_transmission":{"transmissionFactor":0.75,"transmissionTexture":{"index":0}}"#;
    let (wall, warnings) = load_one(factor);
    assert_eq!(
        (wall.transmission, wall.ior, wall.volume, wall.is_glass()),
        (0.75, 1.5, None, false),
        "a metal by default"
    );
    assert!(!wall.transmission_texture.as_ref().unwrap().srgb && warnings.is_empty(), "{warnings:?}");
    let volume =
        |fields: &str| format!("{factor},\"KHR_materials_ior\":{{\"ior\":1.33}},\"KHR_materials_volume\":{{{fields}}}");
    let (water, _) =
        load_one(&volume(r#""thicknessFactor":1,"attenuationDistance":2,"attenuationColor":[0.5,1,0.25]"#));
    let attenuation = water.volume.unwrap();
    assert_eq!((water.ior, attenuation.distance), (1.33, 2.0));
    let left = (-attenuation.absorption() * 2.0).exp();
    assert!((left - Vec3::new(0.5, 1.0, 0.25)).length() < 1e-5, "{left}");
    let f0 = (0.33_f32 / 2.33).powi(2) / 0.04;
    assert!((water.dielectric_reflectance() - Vec3::splat(f0)).length() < 1e-5);
    let (clear, _) = load_one(&volume(r#""thicknessFactor":0.1"#));
    assert_eq!(clear.volume.unwrap().absorption(), Vec3::ZERO);
    let (thin, _) = load_one(&volume(r#""thicknessFactor":0,"attenuationDistance":2"#));
    assert_eq!(thin.volume, None);
}

#[test]
fn sparse_and_normalised_accessors() {
    let mut bytes = square_bytes();
    bytes.extend([0u8, 255, 255, 255, 255, 0, 0, 0].iter().flat_map(|b| [*b, 0, 0, 0]).take(16)); // 92: padding
    bytes.extend([2u8, 0, 0, 0]); // 108: sparse index
    bytes.extend(floats(&[5.0, 6.0, 7.0])); // 112: sparse value
    bytes.extend([0u8, 255, 0, 0, 255, 255, 0, 0, 255, 0, 0, 0, 51, 0, 0, 0]); // 124: u8 texture coordinates
    let views = VIEWS.replace(
        "12}]",
        r#"12},{"buffer":0,"byteOffset":108,"byteLength":4},{"buffer":0,"byteOffset":112,"byteLength":12},
        {"buffer":0,"byteOffset":124,"byteLength":16,"byteStride":4}]"#,
    );
    let accessors = r#""accessors":[{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3","min":[0,0,0],"max":[5,6,7],
        "sparse":{"count":1,"indices":{"bufferView":3,"componentType":5121},"values":{"bufferView":4}}},
        {"bufferView":5,"componentType":5121,"normalized":true,"count":4,"type":"VEC2"},
        {"bufferView":2,"componentType":5123,"count":6,"type":"SCALAR"}]"#;
    let model = load(&document(&bytes, &[&views, accessors, MESH, NODES])).unwrap();
    let v = &model.nodes[0].primitives[0].0.vertices;
    assert_eq!((v[2].position, v[4].position), ([5.0, 6.0, 7.0], [5.0, 6.0, 7.0]));
    assert_eq!((v[0].uv, v[1].uv, v[5].uv), ([0.0, 1.0], [1.0, 1.0], [0.2, 0.0]));
    let model = load(&document(
        &{
            let mut b = bytes.clone();
            b[108] = 4;
            b
        },
        &[&views, accessors, MESH, NODES],
    ))
    .unwrap();
    assert!(model.faults[0].contains("accessor 0: sparse index 4"), "{:?}", model.faults);
}

#[test]
fn the_library_reloads_and_keeps_the_last_good() {
    let folder = tempfile::tempdir().unwrap();
    let picture = folder.path().join("a.png");
    std::fs::write(&picture, png(4, 4)).unwrap();
    let mut library = AssetLibrary::new();
    let first = library.texture(&picture, true, Sampling::default()).unwrap();
    assert!(Arc::ptr_eq(&first, &library.texture(&picture, true, Sampling::default()).unwrap()));
    assert!(!Arc::ptr_eq(&first, &library.texture(&picture, false, Sampling::default()).unwrap()));
    std::fs::write(&picture, b"broken").unwrap();
    assert!(library.reload(&picture).unwrap_err().to_string().contains("a.png"));
    assert!(Arc::ptr_eq(&first, &library.texture(&picture, true, Sampling::default()).unwrap()));
    std::fs::write(&picture, png(8, 2)).unwrap();
    assert!(library.reload(&picture).unwrap());
    assert_eq!(library.texture(&picture, true, Sampling::default()).unwrap().width, 8);
    assert!(!library.reload(folder.path().join("other.png")).unwrap());
    // A model follows its buffer.
    let model = folder.path().join("m.gltf");
    let json = document(&square_bytes(), &[VIEWS, ACCESSORS, MESH, NODES]);
    let start = json.find("data:").unwrap();
    let end = start + json[start..].find('"').unwrap();
    std::fs::write(&model, format!("{}b%201.bin{}", &json[..start], &json[end..])).unwrap();
    std::fs::write(folder.path().join("b 1.bin"), square_bytes()).unwrap();
    let first = library.gltf(&model).unwrap();
    assert!(Arc::ptr_eq(&first, &library.gltf(&model).unwrap()));
    assert!(library.reload(folder.path().join("b 1.bin")).unwrap());
    assert!(!Arc::ptr_eq(&first, &library.gltf(&model).unwrap()));
    assert!(library.gltf(folder.path().join("none.gltf")).unwrap_err().to_string().contains("none.gltf"));
}

#[test]
fn unlit_materials_shine_by_themselves() {
    let mesh = MESH.replace("\"indices\"", "\"material\":0,\"indices\"");
    let rest = r#""extensionsUsed":["KHR_materials_unlit"],"nodes":[{"mesh":0}],"materials":[{
        "extensions":{"KHR_materials_unlit":{}},"emissiveFactor":[1,1,1],
        "pbrMetallicRoughness":{"baseColorFactor":[0.25,0.5,0.75,1]}}]"#;
    let model = load(&document(&square_bytes(), &[VIEWS, ACCESSORS, &mesh, rest])).unwrap();
    let m = &model.nodes[0].primitives[0].1;
    // Nothing is reflected, and the base colour is seen whatever the light; its emission does not count.
    assert!(m.unlit && model.warnings.is_empty(), "{:?}", model.warnings);
    assert_eq!((m.emissive, m.base_color.truncate(), m.specular), (Vec3::new(0.25, 0.5, 0.75), Vec3::ZERO, 0.0));
}

/// What a matrix shears is not kept, and the library tells so with file and node.
#[test]
fn shear_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("leaning.gltf");
    let matrix = "1,0,0,0, 0.5,1,0,0, 0,0,1,0, 0,0,0,1";
    let json = format!(
        r#"{{"asset": {{"version": "2.0"}}, "scenes": [{{"nodes": [0]}}], "nodes": [{{"name": "Tower", "matrix": [{matrix}]}}]}}"#
    );
    std::fs::write(&path, json).unwrap();
    let mut library = crate::assets::AssetLibrary::new();
    library.gltf(&path).unwrap();
    let told: Vec<String> = library.warnings().collect();
    assert!(
        told.len() == 1 && told[0].contains("leaning.gltf") && told[0].contains("\"Tower\": its matrix shears"),
        "{told:?}"
    );
}
