//! Valid inputs of every kind, small ones that hold as much as they can.

use lightwell_tests::root;
use std::io::Cursor;

/// A scene with all that one may hold.
pub const SCENE: &str = r#"Scene(
    description: "all that a scene may hold", gi: Vpl,
    settings: (duration: 4, frame_rate: 30, sky: (0.1, 0.2, 0.3), exposure: 1, move_speed: 2),
    presets: { "thesis": ["clpv.steps=16", "Lamp.light.intensity=2"] },
    materials: { "red": (color: (0.6, 0.05, 0.05), roughness: 0.4, metallic: 0.1, specular: 0.5, emissive: (1, 0, 0)) },
    entities: [
        (name: "Camera", transform: (translation: (0, 1, 4), look_at: (0, 0.5, 0)), camera: (fov: 45, near: 0.1, far: 50, lens: (
            exposure: Photographic(f_number: 2.8, shutter: 0.02, iso: 400), tone_map: AgX, bloom: (scatter: 0.2, radius: 0.1),
            depth_of_field: (focus: 2, f_number: 1.4, sensor_height: 24), vignette: 0.2, sharpening: 0.1, grain: 0.02))),
        (name: "Plan", camera: (projection: Orthographic(height: 4), near: 0)),
        (name: "Sun", transform: (rotation: (-60, 30, 0)), light: (kind: Directional, intensity: 3, shadow_size: 256)),
        (name: "Spot", light: (kind: Spot(inner: 20, outer: 40), color: (1, 0.9, 0.8), intensity: 3, range: 10)),
        (name: "Ball", transform: (translation: (0, 1, 0), scale: 2), mesh: Sphere(radius: 0.5), material: "red",
            animation: (tracks: [Spin(axis: (0, 1, 0), degrees_per_second: 15), Orbit(radius: 2, period: 8),
                Keys(target: Translation, interpolation: Cubic, keys: [(0, (0, 1, 4)), (1, (0.1, 1, 4)), (2, (0, 1, 4))])])),
        (name: "Tube", mesh: Cylinder(radius: 1, height: 2), children: [(name: "Box", mesh: Box(size: (1, 2, 3)))]),
        (name: "Volume", clpv: (quality: Medium, precision: Half, cells: (8, 8, 8), cell_size: Meters(0.3), cascades: 2), vpl: (particles: 64),
            slc: (rsm_size: 64)),
        (name: "Smoke", fog: (shape: Box(size: (4, 3, 4)), extinction: 0.1, albedo: (0.9, 0.9, 0.9), anisotropy: 0.5, falloff: 0.2)),
        (name: "Haze", fog: (shape: Sphere(radius: 2)), animation: (tracks: [Keys(target: Field("fog.extinction"), keys: [(0, 0), (1, 0.1)])])),
        (name: "Fire", particles: (rate: 60, life: 1.5, source: (0.2, 0.1, 0.2), velocity: (0, 2, 0), spread: 25, speed_variation: 0.5,
            gravity: (0, -1, 0), radius: 0.01, end_radius: 0.002, color: (1, 0.6, 0.2), end_color: (0.5, 0.1, 0), radiance: 300, seed: 3),
            animation: (tracks: [Keys(target: Field("particles.radiance"), keys: [(0, 0), (1, 300)])])),
        (name: "Parts", prefab: "a.prefab.ron", repeat: Grid(count: (2, 1, 3), spacing: (3, 0, 2.5)),
            overrides: { "2": (remove: true), "3/Part": (material: "red") }),
        (name: "Ring", prefab: "a.prefab.ron", repeat: Ring(count: 4, radius: 4)),
        (name: "Line", prefab: "a.prefab.ron", repeat: Line(count: 3, points: [(0, 0, 0), (20, 0, 0)])),
        (name: "Model", model: "a.gltf"),
    ],
)"#;

/// A colour table with all keywords that are read.
pub const TABLE: &str = "# a table\nTITLE \"warm\"\nLUT_3D_SIZE 2\nDOMAIN_MIN 0 0 0\nDOMAIN_MAX 1 1 1\n\
    0 0 0\n1 0.1 0\n0 1 0\n1 1 0\n0 0 0.8\n1 0 0.8\n0 1 0.8\n1e0 1 .8\n";

/// A table of actions with all that one may hold.
pub const ACTIONS: &str = r#"Actions(
    buttons: { "jump": [Key(Space), Pad(South), Mouse(Left)] },
    axes: { "right": [Buttons(negative: Key(A), positive: Key(D)), Stick(LeftX)] },
)"#;

/// A script of input.
pub const SCRIPT: &str = r#"Script(steps: 300, events: [
    (1, Press(Key(Enter))), (2, Release(Key(Enter))), (10, Press(Key(W))), (300, Release(Key(W))),
])"#;

/// Import settings with all that they may say.
pub const IMPORT: &str = r#"Import(
    scale: 0.01, up: Z, ignore: ["Blind*", "Glass"], normals: Smooth(crease: 40), flip_winding: true, parts: Split(most: 64),
)"#;

/// A prefab that the scene uses.
pub const PREFAB: &str = r#"Prefab(
    materials: { "own": (color: (0.1, 0.2, 0.3)) },
    entities: [(name: "Part", mesh: Box(size: (1, 1, 1)), material: "own", children: [(name: "Lamp", light: (kind: Point, intensity: 1))])],
)"#;

/// A triangle with a joint, a clip and an image in a data URI.
pub fn gltf_text() -> String {
    let picture = pictures_of_all_kinds().swap_remove(0);
    format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],
"nodes":[{{"mesh":0,"children":[1],"skin":0}},{{"translation":[0,1,0],"rotation":[0,0,0,1],"scale":[1,1,1]}}],
"skins":[{{"joints":[1]}}],
"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"TEXCOORD_0":1}},"indices":2,"material":0,"mode":4}}]}}],
"materials":[{{"pbrMetallicRoughness":{{"baseColorTexture":{{"index":0}},"metallicFactor":0.5}},"alphaMode":"MASK","alphaCutoff":0.5}}],
"textures":[{{"source":0,"sampler":0}}],"samplers":[{{"magFilter":9729,"wrapS":33071}}],
"images":[{{"uri":"data:image/png;base64,{}"}}],
"animations":[{{"channels":[{{"sampler":0,"target":{{"node":1,"path":"translation"}}}}],"samplers":[{{"input":3,"output":0,"interpolation":"LINEAR"}}]}}],
"accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}},
{{"bufferView":1,"componentType":5126,"count":3,"type":"VEC2"}},{{"bufferView":2,"componentType":5123,"count":3,"type":"SCALAR"}},
{{"bufferView":3,"componentType":5126,"count":3,"type":"SCALAR","min":[0],"max":[2]}}],
"bufferViews":[{{"buffer":0,"byteOffset":0,"byteLength":36}},{{"buffer":0,"byteOffset":36,"byteLength":24}},
{{"buffer":0,"byteOffset":60,"byteLength":6}},{{"buffer":0,"byteOffset":68,"byteLength":12}}],
"buffers":[{{"byteLength":80,"uri":"data:application/octet-stream;base64,{}"}}]}}"#,
        base64(&picture),
        base64(&triangle())
    )
}

/// Three positions, coordinates and indices, and three times.
fn triangle() -> Vec<u8> {
    let floats = [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0];
    let mut bytes: Vec<u8> = floats.iter().flat_map(|value| value.to_le_bytes()).collect();
    bytes.extend([0, 0, 1, 0, 2, 0, 0, 0]);
    bytes.extend([0.0_f32, 1.0, 2.0].iter().flat_map(|value| value.to_le_bytes()));
    bytes
}

/// Images of 8 by 8 pixels in every format that textures may have.
pub fn pictures_of_all_kinds() -> Vec<Vec<u8>> {
    let color = |x: u32, y: u32| image::Rgb([(30 * x) as u8, (30 * y) as u8, (x * y) as u8]);
    let picture = image::RgbImage::from_fn(8, 8, color);
    let encode = |format: image::ImageFormat| {
        let mut bytes = Cursor::new(Vec::new());
        picture.write_to(&mut bytes, format).expect("encoded");
        bytes.into_inner()
    };
    let data = |name: &str| std::fs::read(root().join("engine/tests/data").join(name)).expect("a picture of the tests");
    let mut all = [image::ImageFormat::Png, image::ImageFormat::Jpeg, image::ImageFormat::WebP].map(encode).to_vec();
    all.extend(["gradient.webp", "gradient_etc1s.ktx2", "gradient_uastc.ktx2", "gradient_uastc_zstd.ktx2"].map(data));
    all
}

/// Images of the sky: the two formats.
pub fn skies_of_all_kinds() -> Vec<Vec<u8>> {
    let picture = image::Rgb32FImage::from_fn(8, 4, |x, y| image::Rgb([x as f32, 0.1 * y as f32, 7.5]));
    let encode = |format: image::ImageFormat| {
        let mut bytes = Cursor::new(Vec::new());
        picture.write_to(&mut bytes, format).expect("encoded");
        bytes.into_inner()
    };
    [image::ImageFormat::Hdr, image::ImageFormat::OpenExr].map(encode).to_vec()
}

fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::new();
    for chunk in bytes.chunks(3) {
        let word = chunk.iter().fold(0_u32, |word, byte| word << 8 | u32::from(*byte)) << (8 * (3 - chunk.len()));
        for i in 0..4 {
            let digit = char::from(DIGITS[(word >> (18 - 6 * i) & 63) as usize]);
            text.push(if i <= chunk.len() { digit } else { '=' });
        }
    }
    text
}

/// The model as a binary file.
pub fn glb() -> Vec<u8> {
    let text = gltf_text();
    let (head, tail) = text.split_once(r#","uri":"data:application"#).expect("the buffer");
    let mut json = format!("{head}}}]{}", tail.split_once("}]").expect("its end").1).into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let data = triangle();
    let mut bytes = b"glTF".to_vec();
    for word in [2, (28 + json.len() + data.len()) as u32, json.len() as u32, 0x4E4F_534A] {
        bytes.extend(word.to_le_bytes());
    }
    bytes.extend(json);
    bytes.extend((data.len() as u32).to_le_bytes());
    bytes.extend(0x004E_4942_u32.to_le_bytes());
    bytes.extend(data);
    bytes
}

/// Small models of that ending from the folder of models, if it is given.
pub fn small_models(wanted: &str) -> Vec<Vec<u8>> {
    let Some(folder) = std::env::var_os("LIGHTWELL_MODELS").map(std::path::PathBuf::from) else { return Vec::new() };
    let mut pending = vec![folder];
    let mut models = Vec::new();
    while let Some(folder) = pending.pop() {
        for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
            let path = entry.path();
            let is_model = path.extension().is_some_and(|ending| ending == wanted);
            if path.is_dir() {
                pending.push(path);
            } else if is_model && entry.metadata().is_ok_and(|data| data.len() < 20_000) {
                models.extend(std::fs::read(path));
            }
        }
    }
    models.sort();
    models
}
