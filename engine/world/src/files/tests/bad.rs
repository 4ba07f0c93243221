//! Every kind of bad input gives its place, what is wrong and what to do.

use super::*;
use crate::files::format::validate::Validator;
use crate::files::ron::document::Document;
use FileErrorKind as Kind;
use proptest::prelude::*;

/// A scene whose wrong part begins at `‸`, the kind of error, part of its message, and part of its help.
const BAD_SCENES: &[(&str, Kind, &str, &str)] = &[
    (
        "Scene(\n  entities: [\n    (name: \"A\", ‸tranform: ()),\n  ],\n)",
        Kind::UnknownField,
        "`tranform`",
        "`transform`",
    ),
    ("(entities: [(name: \"A\", transform: (‸lookat: (0, 0, 0)))])", Kind::UnknownField, "`lookat`", "`look_at`"),
    ("(‸entity: [])", Kind::UnknownField, "`entity` of Scene", "`entities`"),
    ("(gi: ‸Clvp)", Kind::UnknownVariant, "`Clvp`", "`Clpv`"),
    ("(entities: [(name: \"A\", material: (‸metalic: 1))])", Kind::UnknownField, "`metalic`", "`metallic`"),
    ("(entities: [(name: \"A\", mesh: ‸Spere(radius: 1))])", Kind::UnknownVariant, "`Spere`", "`Sphere`"),
    (
        "(entities: [(name: \"A\", light: (kind: ‸Sport(inner: 1, outer: 2), intensity: 1))])",
        Kind::UnknownVariant,
        "`Sport`",
        "`Spot`",
    ),
    ("(entities: [(name: \"A\", light: (kind: Point‸))])", Kind::MissingField, "`intensity`", "add `intensity"),
    ("(entities: [(‸)])", Kind::MissingField, "`name`", "add `name"),
    ("(entities: [(name: \"A\", camera: (fov: ‸\"wide\"))])", Kind::WrongType, "float", "number"),
    ("(entities: [(name: ‸7)])", Kind::WrongType, "string", "double quotes"),
    ("(entities: [(name: \"A\", camera: (primary: ‸1))])", Kind::WrongType, "boolean", "true or false"),
    ("(entities: ‸{})", Kind::WrongType, "[", "list"),
    ("(settings: (frame_rate: ‸-3))", Kind::BadValue, "out of bounds", "negative"),
    ("(entities: [(name: \"A\", ‸name: \"B\")])", Kind::DuplicateName, "`name`", "keep one"),
    ("(\n entities: [\n  (name: \"A\"),\n  (name: ‸\"A\"),\n ],\n)", Kind::DuplicateName, "`A`", "own name"),
    ("(entities: [(name: \"P\", children: [(name: \"A\"), (name: ‸\"A\")])])", Kind::DuplicateName, "`A`", "own name"),
    ("(entities: [(name: ‸\"\")])", Kind::BadValue, "empty", "name every entity"),
    ("(entities: [(name: ‸\"a/b\")])", Kind::BadValue, "`/`", "another sign"),
    ("(entities: [(name: \"A\", transform: (translation: ‸(0, NaN, 0)))])", Kind::BadValue, "translation", "finite"),
    ("(entities: [(name: \"A\", transform: (rotation: ‸(0, 0, 0, 0)))])", Kind::BadValue, "quaternion", "(0, 0, 0, 1)"),
    ("(entities: [(name: \"A\", transform: (scale: ‸inf))])", Kind::BadValue, "scale", "finite"),
    ("(entities: [(name: \"A\", transform: (look_at: ‸(0, 0, 0)))])", Kind::BadValue, "own place", "another point"),
    (
        "(entities: [(name: \"A\", transform: (rotation: (0, 1, 0), look_at: ‸(0, 0, 1)))])",
        Kind::BadValue,
        "both",
        "keep one",
    ),
    ("(entities: [(name: \"A\", mesh: Box(size: ‸(1, -2, 1)))])", Kind::BadValue, "size", ""),
    (
        "(entities: [(name: \"A\", mesh: Box(size: (1, 1, 1)), material: ‸\"rde\")], materials: {\"red\": ()})",
        Kind::UnknownName,
        "`rde`",
        "`red`",
    ),
    (
        "(entities: [(name: \"A\", mesh: Box(size: (1, 1, 1)), material: ‸\"red\")])",
        Kind::UnknownName,
        "`red`",
        "materials",
    ),
    ("(materials: {\"red\": (color: ‸(1, -1, 0))})", Kind::BadValue, "color", "use 0 to 1"),
    ("(materials: {\"red\": (roughness: ‸1.5)})", Kind::BadValue, "roughness", "use 0 to 1"),
    ("(materials: {\"g\": (transmission: ‸1.5)})", Kind::BadValue, "transmission", "use 0 to 1"),
    ("(materials: {\"g\": (ior: ‸0.5)})", Kind::BadValue, "ior", "use 1 to 10"),
    ("(materials: {\"g\": (volume: (distance: ‸0))})", Kind::BadValue, "distance", "use"),
    ("(materials: {\"g\": (volume: (color: ‸(0, 2, 0)))})", Kind::BadValue, "color", "use 0 to 1"),
    ("(materials: {\"c\": (clearcoat: (factor: ‸2))})", Kind::BadValue, "factor", "use 0 to 1"),
    ("(materials: {\"c\": (clearcoat: (roughness: ‸NaN))})", Kind::BadValue, "roughness", "use 0 to 1"),
    ("(materials: {\"s\": (sheen: (color: ‸(0, 2, 0)))})", Kind::BadValue, "color", "use 0 to 1"),
    ("(materials: {\"b\": (anisotropy: (strength: ‸-1))})", Kind::BadValue, "strength", "use 0 to 1"),
    ("(materials: {\"b\": (anisotropy: (rotation: ‸inf))})", Kind::BadValue, "rotation", "finite"),
    ("(materials: {\"f\": (iridescence: (ior: ‸0.9))})", Kind::BadValue, "ior", "use 1 to 10"),
    ("(materials: {\"f\": (iridescence: (thickness: ‸-5))})", Kind::BadValue, "thickness", "use 0 to 100000"),
    ("(materials: {\"g\": (dispersion: ‸101)})", Kind::BadValue, "dispersion", "use 0 to 100"),
    ("(entities: [(name: \"A\", light: (kind: Point, intensity: ‸-1))])", Kind::BadValue, "intensity", "zero up"),
    (
        "(entities: [(name: \"A\", light: (kind: ‸Spot(inner: 40, outer: 30), intensity: 1))])",
        Kind::BadValue,
        "40",
        "inner < outer",
    ),
    (
        "(entities: [(name: \"A\", light: (kind: ‸Rectangle(width: 1, height: 0), intensity: 1))])",
        Kind::BadValue,
        "height",
        "Point",
    ),
    ("(entities: [(name: \"A\", light: (kind: ‸Sun(angle: 120), intensity: 1))])", Kind::BadValue, "120", "0.53"),
    (
        "(entities: [(name: \"A\", light: (kind: Point, intensity: 1, rsm_size: ‸0))])",
        Kind::BadValue,
        "rsm_size",
        "4 to 2048",
    ),
    (
        "(entities: [(name: \"A\", clpv: (ambient_occlusion: ‸NaN))])",
        Kind::BadValue,
        "ambient_occlusion",
        "0 to 1000000",
    ),
    (
        "(entities: [(name: \"A\", clpv: (ambient_occlusion: ‸-1))])",
        Kind::BadValue,
        "ambient_occlusion",
        "0 to 1000000",
    ),
    (
        "(entities: [(name: \"A\", clpv: (ambient_occlusion: ‸1e9))])",
        Kind::BadValue,
        "ambient_occlusion",
        "0 to 1000000",
    ),
    ("(entities: [(name: \"A\", clpv: (rsm_samples: ‸1000000000))])", Kind::BadValue, "rsm_samples", "1 to 65536"),
    ("(entities: [(name: \"A\", clpv: (rsm_samples: ‸-1))])", Kind::BadValue, "out of bounds", ""),
    ("(entities: [(name: \"A\", clpv: (gradient_damping: ‸NaN))])", Kind::BadValue, "gradient_damping", "0 to 1000000"),
    ("(entities: [(name: \"A\", camera: (fov: ‸180))])", Kind::BadValue, "fov", "180"),
    ("(entities: [(name: \"A\", camera: (near: 1, far: ‸0.5))])", Kind::BadValue, "far", "behind"),
    (
        "(entities: [(name: \"A\", camera: (lens: (exposure: ‸Photographic(f_number: 0, shutter: 0.01, iso: 100))))])",
        Kind::BadValue,
        "`f_number` is 0",
        "use 0.1 to 10000",
    ),
    (
        "(entities: [(name: \"A\", camera: (lens: (exposure: ‸Photographic(f_number: 2, shutter: NaN, iso: 100))))])",
        Kind::BadValue,
        "`shutter` is NaN",
        "s",
    ),
    ("(entities: [(name: \"A\", camera: (lens: (bloom: ‸(scatter: 2))))])", Kind::BadValue, "`scatter` is 2", "0 to 1"),
    (
        "(entities: [(name: \"A\", camera: (lens: (depth_of_field: ‸(focus: 0))))])",
        Kind::BadValue,
        "`focus` is 0",
        "use 0.001 to 1000000000 m",
    ),
    (
        "(entities: [(name: \"A\", camera: (lens: (depth_of_field: ‸(f_number: inf))))])",
        Kind::BadValue,
        "`f_number` is inf",
        "0.1 to 10000",
    ),
    ("(entities: [(name: \"A\", camera: (lens: (vignette: ‸1)))])", Kind::BadValue, "`vignette` is 1", "0 to 0.99"),
    ("(entities: [(name: \"A\", camera: (lens: (sharpening: ‸-1)))])", Kind::BadValue, "`sharpening` is -1", "0 to 1"),
    ("(entities: [(name: \"A\", camera: (lens: (grain: ‸NaN)))])", Kind::BadValue, "`grain` is NaN", "0 to 0.5"),
    ("(entities: [(name: \"A\", camera: (lens: (tone_map: ‸Agx2)))])", Kind::UnknownVariant, "`Agx2`", "`AgX`"),
    ("(entities: [(name: \"A\", camera: (near: ‸0))])", Kind::BadValue, "near", "above zero"),
    (
        "(entities: [(name: \"A\", camera: (projection: ‸Orthographic(height: 0)))])",
        Kind::BadValue,
        "height",
        "1e-6 to 1e9",
    ),
    (
        "(entities: [(name: \"A\", camera: (projection: Orthographic(height: 2), near: ‸-1))])",
        Kind::BadValue,
        "near",
        "zero up",
    ),
    (
        "(entities: [(name: \"A\", camera: (projection: ‸Ortographic(height: 2)))])",
        Kind::UnknownVariant,
        "Ortographic",
        "`Orthographic`",
    ),
    ("(entities: [(name: \"A\", clpv: (cells: (8, ‸0, 8)))])", Kind::BadValue, "along y", "1 to 128"),
    ("(entities: [(name: \"A\", clpv: (bounces: ‸Count(0)))])", Kind::BadValue, "bounces", "Converged"),
    ("(entities: [(name: \"A\", clpv: (cascades: ‸5))])", Kind::BadValue, "cascades", "1 to 4"),
    ("(entities: [(name: \"A\", clpv: (cell_size: ‸Meters(0)))])", Kind::BadValue, "cell size", "Auto"),
    (
        "(entities: [(name: \"A\", fog: (extinction: ‸-0.1))])",
        Kind::BadValue,
        "`extinction` is -0.1",
        "use 0 to 1e6 [1/m]",
    ),
    ("(entities: [(name: \"A\", fog: (extinction: ‸inf))])", Kind::BadValue, "`extinction` is inf", "10 m"),
    ("(entities: [(name: \"A\", fog: (extinction: ‸NaN))])", Kind::BadValue, "`extinction` is NaN", "10 m"),
    (
        "(entities: [(name: \"A\", fog: (albedo: ‸(0.9, 1.1, 0.9)))])",
        Kind::BadValue,
        "`albedo` is (0.9, 1.1, 0.9)",
        "use 0 to 1",
    ),
    ("(entities: [(name: \"A\", fog: (albedo: ‸(0, -0.1, 0)))])", Kind::BadValue, "albedo", "use 0 to 1"),
    ("(entities: [(name: \"A\", fog: (anisotropy: ‸1))])", Kind::BadValue, "`anisotropy` is 1", "-0.95 to 0.95"),
    ("(entities: [(name: \"A\", fog: (anisotropy: ‸-0.96))])", Kind::BadValue, "-0.96", "all sides alike"),
    ("(entities: [(name: \"A\", fog: (falloff: ‸-1))])", Kind::BadValue, "`falloff` is -1", "use 0 to 1e6 [1/m]"),
    (
        "(entities: [(name: \"A\", fog: (shape: ‸Box(size: (4, 0, 4))))])",
        Kind::BadValue,
        "`size` is (4, 0, 4)",
        "1e-6 to 1e6 m, or Everywhere",
    ),
    ("(entities: [(name: \"A\", fog: (shape: ‸Sphere(radius: 2e6)))])", Kind::BadValue, "`radius` is 2", "Everywhere"),
    ("(entities: [(name: \"A\", fog: (shape: ‸Sphere(radius: NaN)))])", Kind::BadValue, "`radius` is NaN", "1e6 m"),
    ("(entities: [(name: \"A\", fog: (shape: ‸Ball(radius: 1)))])", Kind::UnknownVariant, "`Ball`", "`Sphere`"),
    ("(entities: [(name: \"A\", fog: (‸density: 1))])", Kind::UnknownField, "`density`", "`extinction`"),
    (
        "(entities: [(name: \"A\", particles: (rate: ‸1e9))])",
        Kind::BadValue,
        "`rate` is 1000000000",
        "use 0 to 1e6 [1/s]",
    ),
    (
        "(entities: [(name: \"A\", particles: (rate: ‸1e6, life: 2))])",
        Kind::BadValue,
        "are 2000000 particles at once",
        "a source has at most 65536: use a `rate` of at most 32768",
    ),
    ("(entities: [(name: \"A\", particles: (life: ‸0))])", Kind::BadValue, "`life` is 0", "use 0.001 to 1e4 s"),
    ("(entities: [(name: \"A\", particles: (life: ‸NaN))])", Kind::BadValue, "`life` is NaN", "use 0.001 to 1e4 s"),
    ("(entities: [(name: \"A\", particles: (radius: ‸-0.1))])", Kind::BadValue, "`radius` is -0.1", "use 0 to 1e3 m"),
    ("(entities: [(name: \"A\", particles: (end_radius: ‸inf))])", Kind::BadValue, "`end_radius` is inf", "1e3 m"),
    ("(entities: [(name: \"A\", particles: (spread: ‸181))])", Kind::BadValue, "`spread` is 181", "all directions"),
    (
        "(entities: [(name: \"A\", particles: (velocity: ‸(0, NaN, 0)))])",
        Kind::BadValue,
        "`velocity` is (0, NaN, 0)",
        "use -1e4 to 1e4 m/s",
    ),
    ("(entities: [(name: \"A\", particles: (source: ‸(0, -1, 0)))])", Kind::BadValue, "`source`", "0 is a point"),
    ("(entities: [(name: \"A\", particles: (end_color: ‸(0, 2, 0)))])", Kind::BadValue, "`end_color`", "use 0 to 1"),
    ("(entities: [(name: \"A\", particles: (radiance: ‸-1))])", Kind::BadValue, "`radiance` is -1", "W/(m² sr)"),
    ("(entities: [(name: \"A\", particles: (‸radus: 1))])", Kind::UnknownField, "`radus`", "`radius`"),
    (
        "(entities: [(name: \"A\", animation: (tracks: [Spin(axis: (0, 1, 0), degrees_per_second: 9), Spin(axis: ‸(0, 0, 0), degrees_per_second: 1)]))])",
        Kind::BadValue,
        "axis",
        "",
    ),
    (
        "(entities: [(name: \"A\", animation: (tracks: [Keys(target: Translation, keys: [(0, (0, 0, 0)), ‸(0, (1, 0, 0))])]))])",
        Kind::BadValue,
        "time 0",
        "",
    ),
    ("(settings: (duration: ‸0))", Kind::BadValue, "duration", "above zero"),
    ("(settings: (frame_rate: ‸0))", Kind::BadValue, "frame_rate", "1 to 1000"),
    ("(entities: [(name: \"A\", overrides: ‸{\"B\": ()})])", Kind::BadValue, "without a prefab", "prefab"),
    ("(entities: [(name: \"A\", prefab: ‸\"nothing.prefab.ron\")])", Kind::MissingFile, "nothing.prefab.ron", "folder"),
    ("(entities: [(name: \"A\", prefab: ‸\"lmp.prefab.ron\")])", Kind::MissingFile, "lmp", "lamp.prefab.ron"),
    (
        "(entities: [(name: \"A\", prefab: \"lamp.prefab.ron\", overrides: {\"Blub\": ‸()})])",
        Kind::UnknownName,
        "`Blub`",
        "`Bulb`",
    ),
    (
        "(entities: [(name: \"A\", prefab: \"lamp.prefab.ron\", children: [(name: ‸\"Bulb\")])])",
        Kind::DuplicateName,
        "`Bulb`",
        "overrides",
    ),
    (
        "(entities: [(name: \"A\", model: ‸(path: \"x.glb\", source: \"SOURCE\", stand_in: \"STAND\"))])",
        Kind::MissingModel,
        "x.glb",
        "SOURCE",
    ),
    (
        "(entities: [(name: \"A\", model: ‸(path: \"x.glb\", source: \"SOURCE\", stand_in: \"STAND\"))])",
        Kind::MissingModel,
        "x.glb",
        "--models DIR",
    ),
    (
        "(entities: [(name: \"A\", model: ‸(path: \"x.glb\", stand_in: \"STAND\"))])",
        Kind::MissingFile,
        "x.glb",
        "STAND",
    ),
    (
        "(entities: [(name: \"A\", material: (color_texture: ‸\"no.png\"), mesh: Box(size: (1, 1, 1)))])",
        Kind::MissingFile,
        "no.png",
        "--models",
    ),
];

const LAMP: &str = "Prefab(entities: [(name: \"Bulb\", light: (kind: Point, intensity: 1))])";

#[test]
fn bad_scenes_give_place_and_suggestion() {
    let folder = Folder::new(&[("lamp.prefab.ron", LAMP)]);
    let mut wrong = Vec::new();
    for (marked, kind, message, help) in BAD_SCENES {
        let text = marked.replace('‸', "");
        let place = Place::of(&text, marked.find('‸').unwrap());
        folder.write("bad.scene.ron", text.as_bytes());
        match folder.load("bad.scene.ron") {
            Ok(_) => wrong.push(format!("accepted: {text}")),
            Err(e) => {
                let shown = e.to_string();
                let good = e.kind == *kind
                    && e.place == Some(place)
                    && e.message.to_lowercase().contains(&message.to_lowercase())
                    && e.help.clone().unwrap_or_default().contains(help)
                    && shown.contains(&format!("bad.scene.ron:{}:{}: ", place.line, place.column));
                if !good {
                    wrong.push(format!(
                        "expected {kind:?} at {place:?}, `{message}`, `{help}`, got {:?}\n{shown}",
                        e.kind
                    ));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n\n"));
}

#[test]
fn syntax_errors_give_a_place() {
    let folder = Folder::new(&[]);
    for text in [
        "",
        "(",
        "(entities: [",
        "(entities: [(name: \"A\" light: ())])",
        "Scene()x",
        "Sceen()",
        "[1]",
        "(a: 'x)",
        "/* open",
    ] {
        folder.write("bad.scene.ron", text.as_bytes());
        let error = folder.load("bad.scene.ron").err().unwrap_or_else(|| panic!("accepted {text:?}"));
        assert!(error.place.is_some(), "{error}");
    }
    folder.write("bad.scene.ron", b"(entities: [\n \xff])");
    let error = folder.load("bad.scene.ron").err().unwrap();
    assert_eq!(error.place, Some(Place { line: 2, column: 2 }), "{error}");
}

#[test]
fn missing_scene_names_a_similar_one() {
    let folder = Folder::new(&[("cornell.scene.ron", "()")]);
    let error = folder.load("cornel.scene.ron").err().unwrap();
    assert_eq!(error.kind, Kind::MissingFile);
    assert!(error.to_string().contains("cornell.scene.ron"), "{error}");
    let error = folder.load("cornel.glb").err().unwrap();
    assert_eq!(error.kind, Kind::MissingFile);
}

#[test]
fn errors_in_prefabs_name_the_prefab() {
    let folder = Folder::new(&[
        ("a.scene.ron", "(entities: [(name: \"A\", prefab: \"p.prefab.ron\")])"),
        ("p.prefab.ron", "(entities: [\n (name: \"X\", clpv: (steps: 5000)),\n])"),
    ]);
    let error = folder.load("a.scene.ron").err().unwrap();
    assert!(error.file.ends_with("p.prefab.ron"), "{error}");
    assert_eq!(error.place, Some(Place { line: 2, column: 28 }), "{error}");
}

#[test]
fn cycles_of_prefabs_show_the_chain() {
    let folder = Folder::new(&[
        ("a.scene.ron", "(entities: [(name: \"A\", prefab: \"p.prefab.ron\")])"),
        ("p.prefab.ron", "(entities: [(name: \"X\", prefab: \"q.prefab.ron\")])"),
        ("q.prefab.ron", "(entities: [(name: \"Y\", prefab: \"p.prefab.ron\")])"),
    ]);
    let error = folder.load("a.scene.ron").err().unwrap();
    assert_eq!(error.kind, Kind::PrefabCycle);
    assert!(error.message.contains("p.prefab.ron → q.prefab.ron → p.prefab.ron"), "{error}");
    assert!(error.file.ends_with("q.prefab.ron"), "{error}");
}

#[test]
fn prefabs_that_multiply_are_stopped() {
    let folder = Folder::new(&[("a.scene.ron", "(entities: [(name: \"A\", prefab: \"0.prefab.ron\")])")]);
    for i in 0..20 {
        let next = format!("prefab: \"{}.prefab.ron\"", i + 1);
        let text = format!(
            "(entities: [(name: \"a\", {next}), (name: \"b\", {next}), (name: \"c\", {next}), (name: \"d\", {next})])"
        );
        folder.write(&format!("{i}.prefab.ron"), text.as_bytes());
    }
    folder.write("20.prefab.ron", b"()");
    let error = folder.load("a.scene.ron").err().unwrap();
    assert!(error.message.contains("200001 entities"), "{error}");
}

fn parses_or_errs(text: String) {
    if let Ok((_, file)) = Document::parse::<SceneFile>(Path::new("x.scene.ron"), text) {
        let _ = Validator::scene(&file);
    }
}

#[test]
fn mutated_scenes_never_panic() {
    let text = std::fs::read(shipped("scenes/cornell.scene.ron")).unwrap();
    let mut state = 0x9e37_79b9_7f4a_7c15u64;
    let mut random = move |n: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((state >> 33) as usize) % n.max(1)
    };
    let folder = Folder::new(&[]);
    for round in 0..3000 {
        let mut bytes = text.clone();
        for _ in 0..=random(4) {
            let at = random(bytes.len());
            match random(5) {
                0 => bytes[at] = random(256) as u8,
                1 => bytes[at] = b"()[]{},:\"/*-.0eN\\#r"[random(19)],
                2 => drop(bytes.remove(at)),
                3 => bytes.truncate(at.max(1)),
                _ => {
                    let end = (at + random(60)).min(bytes.len());
                    let piece = bytes[at..end].to_vec();
                    let to = random(bytes.len());
                    bytes.splice(to..to, piece);
                }
            }
            if bytes.is_empty() {
                bytes.push(b'(');
            }
        }
        if round % 10 == 0 {
            folder.write("m.scene.ron", &bytes);
            let _ = folder.load("m.scene.ron").map_err(|e| e.to_string());
        } else {
            parses_or_errs(String::from_utf8_lossy(&bytes).into_owned());
        }
    }
}

proptest! {
    #[test]
    fn any_text_gives_a_tree_and_an_answer(text in "[\\[\\](){}:,\"'/*#!rab1.\\\\\\- \n…]{0,80}") {
        let tree = crate::files::ron::tree::Node::parse(&text);
        let _ = tree.pretty();
        parses_or_errs(text);
    }
}
