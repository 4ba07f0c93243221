//! Mutated input of every kind that a user may hand over: whatever it is, the answer is a result or an error, soon, and
//! never a panic.
//!
//! Each test mutates a few valid inputs, always in the same way, 100,000 times, or as often as 40 seconds allow where that
//! is less. `LIGHTWELL_FUZZ=1000000` tries as many of each, however long it takes. What panics is written into `out/fuzz/`.

use clap::Parser;
use fastrand::Rng;
use lightwell::assets::{AssetLibrary, Gltf, Sampling, SkyMap};
use lightwell::files::{LoadOptions, load_scene};
use lightwell::gpu::{Gpu, GpuOptions};
use lightwell_game::cli::Cli;
use lightwell_tests::{folder_from_env, root};
use std::io::Cursor;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Inputs of each kind, where nothing else is asked for.
const EXECUTIONS: u32 = 100_000;
/// Time after which it is enough, where nothing else is asked for: the whole suite shall take minutes.
const BUDGET: Duration = Duration::from_secs(40);
/// No input of this size may take longer, whatever the machine is busy with.
const LONGEST: Duration = Duration::from_secs(20);

/// Words that change what a text means.
const WORDS: [&str; 36] = [
    "0",
    "-1",
    "1e38",
    "-1e-45",
    "NaN",
    "inf",
    "4294967295",
    "4294967296",
    "18446744073709551615",
    "true",
    "()",
    "[]",
    "{}",
    "((((",
    "))))",
    "\"",
    "\\",
    "\"\"",
    ",",
    ":",
    "/*",
    "//",
    "\u{0}",
    "\u{feff}",
    "\u{1F600}",
    "Some(None)",
    "..",
    "../../..",
    "#import",
    "#ifdef X",
    "#{X}",
    "@group(9999)",
    "array<f32>",
    "null",
    "data:,",
    "%00",
];

/// Tries as many mutations of the inputs as are asked for, or as there is time for.
fn fuzz(name: &str, seeds: &[Vec<u8>], mut attempt: impl FnMut(&[u8])) {
    let asked: Option<u32> = std::env::var("LIGHTWELL_FUZZ").ok().and_then(|n| n.parse().ok());
    let (wanted, budget) = asked.map_or((EXECUTIONS, BUDGET), |count| (count, Duration::MAX));
    let mut random = Rng::with_seed(7);
    let start = Instant::now();
    let mut slowest = Duration::ZERO;
    let mut count = 0;
    while count < wanted && start.elapsed() < budget {
        count += 1;
        let input = mutated(&mut random, seeds);
        let begin = Instant::now();
        if catch_unwind(AssertUnwindSafe(|| attempt(&input))).is_err() {
            panic!("{name}: panics, see {}", keep(name, &input).display());
        }
        let elapsed = begin.elapsed();
        assert!(elapsed < LONGEST, "{name}: takes {elapsed:?}, see {}", keep(name, &input).display());
        slowest = slowest.max(elapsed);
    }
    let memory = peak_memory().map_or(String::new(), |mib| format!(", at most {mib} MiB in the process"));
    println!("{name}: {count} inputs in {:.1} s, the slowest {slowest:?}{memory}", start.elapsed().as_secs_f64());
    assert!(peak_memory().is_none_or(|mib| mib < 1024), "{name}{memory}");
}

fn keep(name: &str, input: &[u8]) -> PathBuf {
    let folder = root().join("out/fuzz");
    std::fs::create_dir_all(&folder).expect("a folder");
    let path = folder.join(name);
    std::fs::write(&path, input).expect("written");
    path
}

/// Largest memory that the process had so far, where the system tells [MiB].
fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    Some(line.split_whitespace().nth(1)?.parse::<u64>().ok()? / 1024)
}

/// One of the inputs with one to four mutations.
fn mutated(random: &mut Rng, seeds: &[Vec<u8>]) -> Vec<u8> {
    let mut input = seeds[random.usize(..seeds.len())].clone();
    for _ in 0..random.usize(1..5) {
        mutate(random, &mut input, seeds);
    }
    input
}

fn mutate(random: &mut Rng, input: &mut Vec<u8>, seeds: &[Vec<u8>]) {
    let length = input.len();
    if length == 0 {
        input.extend(WORDS[random.usize(..WORDS.len())].bytes());
        return;
    }
    let at = random.usize(..length);
    let end = (at + 1 + random.usize(..32)).min(length);
    match random.u8(..8) {
        0 => input[at] ^= 1 << random.u8(..8),
        1 => input[at] = random.u8(..),
        2 => drop(input.drain(at..end)),
        3 => {
            let copy = input[at..end].to_vec();
            input.splice(at..at, copy);
        }
        4 => drop(input.splice(at..at, WORDS[random.usize(..WORDS.len())].bytes())),
        5 => replace_number(random, input, at),
        6 => input.truncate(at),
        _ => {
            let other = &seeds[random.usize(..seeds.len())];
            let from = random.usize(..other.len().max(1)).min(other.len());
            let until = (from + random.usize(..256)).min(other.len());
            input.splice(at..end, other[from..until].iter().copied());
        }
    }
}

/// Another number for the next one in a text; in bytes, four that are a large or a small number.
fn replace_number(random: &mut Rng, input: &mut Vec<u8>, at: usize) {
    let is_number = |byte: &u8| byte.is_ascii_digit() || matches!(byte, b'.' | b'-' | b'+' | b'e');
    if input.is_ascii() {
        let Some(start) = input[at..].iter().position(u8::is_ascii_digit).map(|from| at + from) else { return };
        let end = input[start..].iter().position(|byte| !is_number(byte)).map_or(input.len(), |to| start + to);
        input.splice(start..end, WORDS[random.usize(..10)].bytes());
    } else if at + 4 <= input.len() {
        let value = [0, 1, u32::MAX, 1 << 31, 1 << 20, u32::MAX - 3][random.usize(..6)];
        input[at..at + 4].copy_from_slice(&value.to_le_bytes());
    }
}

/// Writes inputs into a file, and loads the scene beside it.
struct Loader {
    folder: tempfile::TempDir,
    file: &'static str,
    /// Knows the model from the input before.
    library: AssetLibrary,
    loaded: u32,
}

impl Loader {
    fn new(folder: tempfile::TempDir, file: &'static str) -> Self {
        Self { folder, file, library: AssetLibrary::new(), loaded: 0 }
    }

    fn load(&mut self, input: &[u8]) {
        self.loaded += 1;
        if self.loaded.is_multiple_of(500) {
            self.library = AssetLibrary::new();
        }
        std::fs::write(self.folder.path().join(self.file), input).expect("written");
        let _ = load_scene(&self.folder.path().join("a.scene.ron"), &mut self.library, &LoadOptions::default());
    }
}

const SCENE: &str = r#"Scene(
    description: "all that a scene may hold", gi: Vpl,
    settings: (duration: 4, frame_rate: 30, sky: (0.1, 0.2, 0.3), exposure: 1, move_speed: 2),
    presets: { "thesis": ["clpv.steps=16", "Lamp.light.intensity=2"] },
    materials: { "red": (color: (0.6, 0.05, 0.05), roughness: 0.4, metallic: 0.1, specular: 0.5, emissive: (1, 0, 0)) },
    entities: [
        (name: "Camera", transform: (translation: (0, 1, 4), look_at: (0, 0.5, 0)), camera: (fov: 45, near: 0.1, far: 50)),
        (name: "Plan", camera: (projection: Orthographic(height: 4), near: 0)),
        (name: "Sun", transform: (rotation: (-60, 30, 0)), light: (kind: Directional, intensity: 3, shadow_size: 256)),
        (name: "Spot", light: (kind: Spot(inner: 20, outer: 40), color: (1, 0.9, 0.8), intensity: 3, range: 10)),
        (name: "Ball", transform: (translation: (0, 1, 0), scale: 2), mesh: Sphere(radius: 0.5), material: "red",
            animation: (tracks: [Spin(axis: (0, 1, 0), degrees_per_second: 15), Orbit(radius: 2, period: 8),
                Keys(target: Translation, interpolation: Cubic, keys: [(0, (0, 1, 4)), (1, (0.1, 1, 4)), (2, (0, 1, 4))])])),
        (name: "Tube", mesh: Cylinder(radius: 1, height: 2), children: [(name: "Box", mesh: Box(size: (1, 2, 3)))]),
        (name: "Volume", clpv: (quality: Medium, cells: (8, 8, 8), cell_size: Meters(0.3), cascades: 2), vpl: (particles: 64),
            slc: (rsm_size: 64)),
        (name: "Parts", prefab: "a.prefab.ron", repeat: Grid(count: (2, 1, 3), spacing: (3, 0, 2.5)),
            overrides: { "2": (remove: true), "3/Part": (material: "red") }),
        (name: "Ring", prefab: "a.prefab.ron", repeat: Ring(count: 4, radius: 4)),
        (name: "Line", prefab: "a.prefab.ron", repeat: Line(count: 3, points: [(0, 0, 0), (20, 0, 0)])),
        (name: "Model", model: "a.gltf"),
    ],
)"#;

const PREFAB: &str = r#"Prefab(
    materials: { "own": (color: (0.1, 0.2, 0.3)) },
    entities: [(name: "Part", mesh: Box(size: (1, 1, 1)), material: "own", children: [(name: "Lamp", light: (kind: Point, intensity: 1))])],
)"#;

/// A triangle with a joint, a clip and a picture in a data URI.
fn gltf_text() -> String {
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

/// Pictures of 8 by 8 pixels in every format that textures may have.
fn pictures_of_all_kinds() -> Vec<Vec<u8>> {
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

/// Pictures of the sky: the two formats.
fn skies_of_all_kinds() -> Vec<Vec<u8>> {
    let picture = image::Rgb32FImage::from_fn(8, 4, |x, y| image::Rgb([x as f32, 0.1 * y as f32, 7.5]));
    let encode = |format: image::ImageFormat| {
        let mut bytes = Cursor::new(Vec::new());
        picture.write_to(&mut bytes, format).expect("encoded");
        bytes.into_inner()
    };
    [image::ImageFormat::Hdr, image::ImageFormat::OpenExr].map(encode).to_vec()
}

/// Gives the chunks of a PNG file the checksums of what they hold now, so that more than the checksums is tried.
fn repair_checksums(png: &mut [u8]) {
    let mut at = 8;
    while let Some(length) = png.get(at..at + 4).map(|b| u32::from_be_bytes([b[0], b[1], b[2], b[3]]) as usize) {
        let Some(end) = at.checked_add(8).and_then(|start| start.checked_add(length)) else { return };
        let Some(content) = png.get(at + 4..end) else { return };
        let sum = crc32(content);
        let Some(place) = png.get_mut(end..end + 4) else { return };
        place.copy_from_slice(&sum.to_be_bytes());
        at = end + 4;
    }
}

/// The checksum of PNG (ISO 3309).
fn crc32(bytes: &[u8]) -> u32 {
    let of_bit = |sum: u32| if sum & 1 == 1 { sum >> 1 ^ 0xEDB8_8320 } else { sum >> 1 };
    let of_byte = |sum: u32, byte: &u8| (0..8).fold(sum ^ u32::from(*byte), |sum, _| of_bit(sum));
    !bytes.iter().fold(!0, of_byte)
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

/// The same as a binary file.
fn glb() -> Vec<u8> {
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

/// Small models from the folder of models, if it is given.
fn small_models() -> Vec<Vec<u8>> {
    let Some(folder) = folder_from_env("LIGHTWELL_MODELS") else { return Vec::new() };
    let mut pending = vec![folder];
    let mut models = Vec::new();
    while let Some(folder) = pending.pop() {
        for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
            let path = entry.path();
            let is_model = path.extension().is_some_and(|ending| ending == "glb");
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

#[test]
fn the_seeds_are_valid() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("a.prefab.ron"), PREFAB).expect("written");
    std::fs::write(folder.path().join("a.gltf"), gltf_text()).expect("written");
    std::fs::write(folder.path().join("a.scene.ron"), SCENE).expect("written");
    let path = folder.path().join("a.scene.ron");
    load_scene(&path, &mut AssetLibrary::new(), &LoadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    Gltf::from_bytes(Path::new("a.glb"), &glb()).unwrap_or_else(|e| panic!("{e}"));
    for bytes in pictures_of_all_kinds() {
        let path = folder.path().join("picture");
        std::fs::write(&path, bytes).expect("written");
        AssetLibrary::new().texture(&path, true, Sampling::default()).unwrap_or_else(|e| panic!("{e}"));
    }
    for bytes in skies_of_all_kinds() {
        let path = folder.path().join("sky");
        std::fs::write(&path, bytes).expect("written");
        SkyMap::load(&path, 1.0, 0.0).unwrap_or_else(|e| panic!("{e}"));
    }
}

#[test]
fn scenes() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("a.prefab.ron"), PREFAB).expect("written");
    std::fs::write(folder.path().join("a.gltf"), gltf_text()).expect("written");
    let mut loader = Loader::new(folder, "a.scene.ron");
    fuzz("scene.ron", &[SCENE.into()], |input| loader.load(input));
}

#[test]
fn prefabs() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = r#"Scene(entities: [(name: "A", prefab: "a.prefab.ron")])"#;
    std::fs::write(folder.path().join("a.scene.ron"), scene).expect("written");
    let mut loader = Loader::new(folder, "a.prefab.ron");
    fuzz("prefab.ron", &[PREFAB.into()], |input| loader.load(input));
}

#[test]
fn models() {
    let mut seeds = vec![gltf_text().into_bytes(), glb()];
    seeds.extend(small_models());
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.glb");
    fuzz("model.glb", &seeds, |input| drop(Gltf::from_bytes(&path, input)));
}

#[test]
fn pictures() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.png");
    let mut turn = 0;
    fuzz("picture.png", &pictures_of_all_kinds(), |input| {
        let mut input = input.to_vec();
        turn += 1;
        if turn % 4 != 0 && input.starts_with(b"\x89PNG") {
            repair_checksums(&mut input);
        }
        std::fs::write(&path, input).expect("written");
        let _ = AssetLibrary::new().texture(&path, true, Sampling::default());
    });
}

#[test]
fn skies() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.exr");
    fuzz("sky.exr", &skies_of_all_kinds(), |input| {
        std::fs::write(&path, input).expect("written");
        let _ = SkyMap::load(&path, 1.0, 0.0);
        let _ = lightwell::measure::read_image(&path);
    });
}

#[test]
fn shaders() {
    const LIBRARY: &str = "#define_import_path lightwell::part\n\nstruct Part { a: vec3f, b: u32 }\n\nfn twice(x: f32) -> f32 {\n    return 2.0 * x;\n}\n";
    const SHADER: &str = "#import lightwell::part::{Part, twice}\n\n@group(0) @binding(0) var<uniform> part: Part;\n\
        @group(0) @binding(1) var<storage, read_write> values: array<f32>;\n#ifdef SIZE\nconst SIZE: u32 = #{SIZE}u;\n#else\n\
        const SIZE: u32 = 4u;\n#endif\n\n@compute @workgroup_size(64)\nfn main(@builtin(global_invocation_id) id: vec3u) {\n    \
        for (var i = 0u; i < SIZE; i++) {\n        values[id.x] += twice(part.a[i % 3u]) * f32(part.b);\n    }\n}\n";
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &[u8]| std::fs::write(folder.path().join(name), text).expect("written");
    write("part.wgsl", LIBRARY.as_bytes());
    write("a.wgsl", SHADER.as_bytes());
    let options = GpuOptions { adapter: None, shader_dir: folder.path().to_owned() };
    let gpu = Gpu::headless(&options).expect("a device");
    gpu.shaders.entry_points("a.wgsl").unwrap_or_else(|e| panic!("{e}"));
    // The shader, and what it imports. The library composes anew what depends on the one that changed.
    let add = |name: &str, text: &[u8]| gpu.shaders.add(name, &String::from_utf8_lossy(text));
    for (name, text) in [("a.wgsl", SHADER), ("part.wgsl", LIBRARY)] {
        fuzz(name, &[text.into()], |input| {
            add(name, input);
            let _ = gpu.shaders.entry_points("a.wgsl");
        });
        add(name, text.as_bytes());
    }
}

#[test]
fn command_lines() {
    let lines = [
        "lightwell render cornell -o a.png --size 64x64 --frames 0..3 --set clpv.steps=3 --only direct --gi reference --spp 4",
        "lightwell bench cornell -o out --quick --variant a: clpv.steps=3, spp=4 --sweep steps",
        "lightwell compare a.exr b.exr --max nrmse=0.1,bias=0.02 --metric nrmse --halves c.exr d.exr",
        "lightwell test --filter a --jobs 3 -o out --bless -v",
        "lightwell stress --full --method sweep,vpl -o out",
    ];
    let seeds: Vec<Vec<u8>> = lines.iter().map(|line| line.as_bytes().to_vec()).collect();
    fuzz("command line", &seeds, |input| {
        let text = String::from_utf8_lossy(input);
        let _ = Cli::try_parse_from(text.split(' '));
    });
}
