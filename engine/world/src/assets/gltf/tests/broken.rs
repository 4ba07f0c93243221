//! A fault costs its part: what is broken is mended or left out with a warning that names it. What makes the whole file
//! unreadable is refused.

use super::*;
use proptest::prelude::*;

/// Loads what has a fault, with a fault that has all these words.
fn mended(json: &str, words: &[&str]) -> Gltf {
    let model = load(json).unwrap_or_else(|error| panic!("{words:?}: {error}"));
    let is_said = model.faults.iter().any(|fault| words.iter().all(|word| fault.contains(word)));
    assert!(is_said, "{words:?} are not in {:#?}", model.faults);
    assert!(model.faults.iter().all(|fault| model.warnings.contains(fault)));
    model
}

/// A whole square beside which something is broken.
fn beside(rest: &str) -> String {
    document(&square_bytes(), &[VIEWS, ACCESSORS, MESH, rest])
}

#[test]
fn unreadable_files_are_refused() {
    let needs = r#""extensionsUsed":["EXT_x"],"extensionsRequired":["EXT_x"]"#;
    refuse(&beside(needs), &["EXT_x", "not supported"]);
    refuse(r#"{"asset":{"version":"1.0"}}"#, &["asset.version", "1.0"]);
    refuse("{", &["JSON, line 1"]);
    refuse("[]", &["JSON", "no object"]);
    refuse("{}", &["asset.version"]);
    // Without its geometry there is no model; nothing outside of the folder is read for it.
    let with = |uri: &str| {
        let buffer = format!(r#""buffers":[{{"byteLength":92,"uri":"{uri}"}}]"#);
        format!(r#"{{"asset":{{"version":"2.0"}},{buffer},{VIEWS},{ACCESSORS},{MESH},{NODES}}}"#)
    };
    for uri in ["https://example.org/a.bin", "../a.bin", "/etc/hostname", "gone.bin"] {
        refuse(&with(uri), &["buffer 0", uri]);
    }
    let unused = r#"{"asset":{"version":"2.0"},"buffers":[{"byteLength":4,"uri":"gone.bin"}]}"#;
    mended(unused, &["buffer 0", "gone.bin"]);
}

#[test]
fn broken_geometry_costs_its_triangles_or_its_primitive() {
    let bytes = square_bytes();
    let doc =
        |bytes: &[u8], views: &str, accessors: &str, mesh: &str| document(bytes, &[views, accessors, mesh, NODES]);
    let mut out_of_range = bytes.clone();
    out_of_range[80] = 9;
    let model = mended(&doc(&out_of_range, VIEWS, ACCESSORS, MESH), &["square", "accessor 2", "index 9", "1 of 2"]);
    assert_eq!(model.triangle_count(), 1);
    let mut not_a_number = bytes.clone();
    // Of the vertex 1, which one triangle has.
    not_a_number[12..16].copy_from_slice(&f32::NAN.to_le_bytes());
    let model = mended(&doc(&not_a_number, VIEWS, ACCESSORS, MESH), &["square", "accessor 0", "NaN"]);
    assert_eq!(model.triangle_count(), 1);
    let sound =
        |model: &Gltf| model.nodes[0].primitives[0].0.vertices.iter().all(|v| Vec3::from(v.position).is_finite());
    assert!(sound(&model));
    for (views, accessors, mesh, words) in [
        (
            VIEWS.replace("\"byteLength\":48", "\"byteLength\":40"),
            ACCESSORS.into(),
            MESH.into(),
            ["accessor 0", "do not fit"],
        ),
        (
            VIEWS.into(),
            ACCESSORS.replace("\"count\":6", "\"count\":18446744073709551615"),
            MESH.into(),
            ["accessor 2", "too large"],
        ),
        (VIEWS.into(), ACCESSORS.replace("\"count\":6", "\"count\":0"), MESH.into(), ["accessor 2", "at least 1"]),
        (VIEWS.into(), ACCESSORS.replace("5123", "5126"), MESH.into(), ["accessor 2", "do not fit"]),
        (
            VIEWS.into(),
            ACCESSORS.replace("6,\"type\":\"SCALAR", "1,\"type\":\"VEC2"),
            MESH.into(),
            ["accessor 2", "indices must be"],
        ),
        (
            VIEWS.into(),
            ACCESSORS.into(),
            MESH.replace("POSITION\":0,", "POSITION\":7,"),
            ["mesh 0 \"square\"", "accessor 7"],
        ),
        (
            VIEWS.into(),
            ACCESSORS.into(),
            MESH.replace("\"indices\":2", "\"indices\":\"2\""),
            ["primitives 0", "whole number"],
        ),
    ] {
        let model = mended(&doc(&bytes, &views, &accessors, &mesh), &words);
        assert_eq!(model.triangle_count(), 0, "{words:?}");
        mended(&doc(&bytes, &views, &accessors, &mesh), &["nothing of them can be drawn"]);
    }
    // What is beside the positions is left out alone.
    for (mesh, words) in [
        (MESH.replace("\"TEXCOORD_0\":1", "\"NORMAL\":1"), ["accessor 1", "Vec2"]),
        (MESH.replace("\"TEXCOORD_0\":1", "\"TEXCOORD_0\":2"), ["accessor 2", "Scalar"]),
        (MESH.replace("\"TEXCOORD_0\":1", "\"TEXCOORD\":1"), ["TEXCOORD", "glTF 1.0"]),
        (MESH.replace("\"TEXCOORD_0\":1", "\"JOINTS_0\":1"), ["JOINTS_0", "together"]),
        (MESH.replace("\"TEXCOORD_0\":1", "\"BATCH\":1"), ["BATCH", "no attribute"]),
        (MESH.replace("\"indices\"", "\"material\":3,\"indices\""), ["material 3", "there are 0"]),
    ] {
        assert_eq!(mended(&doc(&bytes, VIEWS, ACCESSORS, &mesh), &words).triangle_count(), 2, "{words:?}");
    }
}

#[test]
fn broken_hierarchies_are_cut() {
    let drawn = |nodes: &str, words: &[&str]| mended(&beside(nodes), words);
    let cycle = r#""nodes":[{"children":[1]},{"name":"b","children":[0]},{"children":[1]}]"#;
    drawn(cycle, &["node 1 \"b\"", "first counts"]);
    drawn(r#""nodes":[{"children":[1]},{"name":"b","children":[0]}]"#, &["cycle"]);
    drawn(r#""nodes":[{"children":[0],"mesh":0}]"#, &["cycle"]);
    let two = drawn(
        r#""nodes":[{"children":[2]},{"children":[2]},{"name":"c","mesh":0}]"#,
        &["node 2 \"c\"", "first counts"],
    );
    assert_eq!((two.triangle_count(), two.nodes[2].parent), (2, Some(0)));
    drawn(r#""nodes":[{"mesh":3}]"#, &["node 0", "mesh 3"]);
    drawn(r#""nodes":[{"children":[5,1]},{"mesh":0}]"#, &["node 0", "node 5"]);
    drawn(r#""nodes":[{"scale":[1e39,1,1],"mesh":0}]"#, &["node 0", "not finite"]);
    drawn(r#""nodes":[{"rotation":[0,0,0,0],"mesh":0}]"#, &["node 0", "no direction"]);
    drawn(r#""nodes":[{"translation":[0,1],"mesh":0}]"#, &["node 0", "2 numbers"]);
    drawn(r#""nodes":[{"mesh":0},7]"#, &["node 1", "object"]);
    for (scenes, words) in [
        (r#""scenes":[{"nodes":[0,0]}],"nodes":[{"mesh":0}]"#, ["node 0", "twice"]),
        (r#""scenes":[{"nodes":[0,1]}],"nodes":[{"children":[1]},{"mesh":0}]"#, ["node 1", "child of node 0"]),
        (r#""scenes":[{"nodes":[1]}],"nodes":[{"children":[1]},{"mesh":0}]"#, ["node 1", "without its parent"]),
        (r#""scenes":[{"nodes":[0,9]}],"nodes":[{"mesh":0}]"#, ["scene 0", "node 9"]),
        (r#""scene":4,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}]"#, ["scene", "scene 4"]),
    ] {
        assert_eq!(drawn(scenes, &words).triangle_count(), 2, "{words:?}");
    }
}

fn punctual(lights: &str) -> String {
    format!(
        r#""extensionsUsed":["KHR_lights_punctual"],"extensions":{{"KHR_lights_punctual":{{"lights":[{lights}]}}}},
        "nodes":[{{"mesh":0,"extensions":{{"KHR_lights_punctual":{{"light":0}}}}}}]"#
    )
}

#[test]
fn broken_lights_and_cameras_are_mended_or_left_out() {
    for (light, words, is_kept) in [
        (r#"{"type":"spot"}"#, None, true),
        (r#"{"type":"spot","spot":{"innerConeAngle":0.4,"outerConeAngle":0.4}}"#, Some("hard edge"), true),
        (r#"{"type":"spot","spot":{"innerConeAngle":0.5,"outerConeAngle":0.4}}"#, Some("cone angles"), true),
        (r#"{"type":"spot","spot":{"innerConeAngle":-1,"outerConeAngle":9}}"#, Some("cone angles"), true),
        (r#"{"type":"spot","spot":{"innerConeAngle":0,"outerConeAngle":0}}"#, Some("cone angles"), true),
        (r#"{"type":"point","range":0}"#, Some("range 0"), true),
        (r#"{"type":"point","color":[1,-1,0]}"#, Some("negative"), true),
        (r#"{"type":"point","color":"red"}"#, Some("color"), true),
        (r#"{"type":"point","intensity":-1}"#, Some("intensity -1"), false),
        (r#"{"type":"point","intensity":1e39}"#, Some("intensity"), false),
        (r#"{"type":"area"}"#, Some("area"), false),
        ("3", Some("object"), false),
    ] {
        let json = beside(&punctual(light));
        let model = match words {
            Some(words) => mended(&json, &["light 0", words]),
            None => load(&json).unwrap(),
        };
        assert_eq!((model.nodes[0].light.is_some(), model.triangle_count()), (is_kept, 2), "{light}");
        if let Some(LightKind::Spot { inner, outer }) = model.nodes[0].light.as_ref().map(|light| light.kind) {
            assert!(0.0 <= inner && inner < outer && outer <= 90.0, "{light}: {inner} {outer}");
        }
    }
    for (camera, words, is_kept) in [
        (r#"{"type":"orthographic","perspective":{"yfov":1,"znear":0.1}}"#, "no `orthographic`", false),
        (r#"{"type":"fisheye","perspective":{"yfov":1,"znear":0.1}}"#, "fisheye", false),
        (r#"{"type":"perspective","perspective":{"yfov":4,"znear":0.1}}"#, "yfov 4", false),
        (r#"{"type":"perspective","perspective":{"yfov":1,"znear":0}}"#, "znear 0", true),
        (r#"{"type":"perspective","perspective":{"yfov":1,"znear":2,"zfar":1}}"#, "zfar 1", true),
        (r#"{"type":"orthographic","orthographic":{"xmag":1,"ymag":0,"znear":0,"zfar":1}}"#, "ymag 0", false),
        (r#"{"type":"orthographic","orthographic":{"xmag":1,"ymag":1,"znear":2,"zfar":1}}"#, "zfar 1", true),
    ] {
        let json = beside(&format!(r#""cameras":[{camera}],"nodes":[{{"mesh":0,"camera":0}}]"#));
        let model = mended(&json, &["camera 0", words]);
        assert_eq!((model.nodes[0].camera.is_some(), model.triangle_count()), (is_kept, 2), "{camera}");
    }
}

#[test]
fn broken_images_and_textures_leave_the_material() {
    let mesh = MESH.replace("\"indices\"", "\"material\":0,\"indices\"");
    let textured = |rest: &str| {
        let material = r#""materials":[{"name":"m","pbrMetallicRoughness":{"baseColorFactor":[0,1,0,1],"baseColorTexture":{"index":0}}}]"#;
        document(&square_bytes(), &[VIEWS, ACCESSORS, &mesh, NODES, material, rest])
    };
    for (rest, words) in [
        (r#""images":[{"uri":"gone.png"}],"textures":[{"source":0}]"#, ["gone.png", "drawn without it"]),
        (r#""images":[{"uri":"../../secret.png"}],"textures":[{"source":0}]"#, ["image 0", "leads out"]),
        (r#""images":[{"uri":"https://example.org/a.png"}],"textures":[{"source":0}]"#, ["image 0", "scheme"]),
        (r#""images":[{"uri":"data:image/png;base64,AAAA"}],"textures":[{"source":0}]"#, ["image 0", "neither PNG"]),
        (r#""images":[{"bufferView":9}],"textures":[{"source":0}]"#, ["image 0", "buffer view 9"]),
        (r#""images":[{}],"textures":[{"source":0}]"#, ["image 0", "neither a URI"]),
        (r#""textures":[{"source":0}]"#, ["texture 0", "image 0"]),
        (r#""textures":[{"extensions":{"EXT_texture_avif":{"source":0}}}]"#, ["texture 0", "no image"]),
        (r#""textures":[]"#, ["material 0 \"m\"", "texture 0"]),
        (r#""textures":[{"sampler":4,"source":0}],"images":[{"uri":"gone.png"}]"#, ["texture 0", "sampler 4"]),
    ] {
        let model = mended(&textured(rest), &words);
        let material = &model.nodes[0].primitives[0].1;
        assert_eq!((material.base_color.y, material.base_color_texture.is_none()), (1.0, true), "{rest}");
    }
}

/// A square that one track moves.
fn moved(times: &[f32], values: &[[f32; 3]], channel: &str) -> String {
    let mut bytes = square_bytes();
    bytes.extend(floats(times));
    bytes.extend(floats(values.as_flattened()));
    let (times_bytes, values_bytes) = (4 * times.len(), 12 * values.len());
    let at = 92 + times_bytes;
    let more = format!(
        r#"12}},{{"buffer":0,"byteOffset":92,"byteLength":{times_bytes}}},{{"buffer":0,"byteOffset":{at},"byteLength":{values_bytes}}}]"#
    );
    let accessors = ACCESSORS.replace(
        "\"SCALAR\"}]",
        &format!(
            r#""SCALAR"}},{{"bufferView":3,"componentType":5126,"count":{},"type":"SCALAR"}},
            {{"bufferView":4,"componentType":5126,"count":{},"type":"VEC3"}}]"#,
            times.len(),
            values.len()
        ),
    );
    let animation = format!(r#""animations":[{{"channels":[{channel}],"samplers":[{{"input":3,"output":4}}]}}]"#);
    document(&bytes, &[&VIEWS.replace("12}]", &more), &accessors, MESH, NODES, &animation])
}

const TRACK: &str = r#"{"sampler":0,"target":{"node":0,"path":"translation"}}"#;

#[test]
fn broken_tracks_are_mended_or_left_out() {
    let values = [[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [3.0, 0.0, 0.0]];
    let x_at = |model: &Gltf, time: f64| model.clips[0].nodes[&0].translation.as_ref().unwrap().at(time)[0];
    // Of two keys at one time the first counts before it and the second after it.
    let jump = mended(&moved(&[0.0, 1.0, 1.0, 2.0], &values, TRACK), &["animation 0", "several keys at 1"]);
    assert!((x_at(&jump, 0.5) - 0.5).abs() < 1e-3 && (x_at(&jump, 1.5) - 2.5).abs() < 1e-3);
    let sorted = mended(&moved(&[0.0, 2.0, 1.0, 3.0], &values, TRACK), &["animation 0", "sorted"]);
    assert!((x_at(&sorted, 1.0) - 2.0).abs() < 1e-3 && (x_at(&sorted, 2.0) - 1.0).abs() < 1e-3);
    let holed = mended(&moved(&[0.0, f32::NAN, 1.0, 2.0], &values, TRACK), &["animation 0", "not finite"]);
    assert!((x_at(&holed, 0.5) - 1.0).abs() < 1e-3);
    let short = mended(&moved(&[0.0, 1.0, 2.0, 3.0], &values[..3], TRACK), &["animation 0", "9 numbers for 4 keys"]);
    assert_eq!(short.clips[0].duration, 2.0);
    for (channel, words) in [
        (r#"{"sampler":0,"target":{"node":0,"path":"trenslation"}}"#, ["channels 0", "trenslation"]),
        (r#"{"sampler":5,"target":{"node":0,"path":"translation"}}"#, ["channels 0", "sampler 5"]),
        (r#"{"sampler":0,"target":{"node":8,"path":"translation"}}"#, ["channels 0", "node 8"]),
        (r#"{"sampler":0,"target":{"node":0,"path":"rotation"}}"#, ["channel 0", "has 12"]),
        (r#"{"target":{"node":0,"path":"translation"}}"#, ["channels 0", "sampler"]),
    ] {
        let model = mended(&moved(&[0.0, 1.0, 2.0, 3.0], &values, channel), &words);
        assert_eq!(model.triangle_count(), 2, "{channel}");
    }
    let twice = format!("{TRACK},{TRACK}");
    mended(&moved(&[0.0, 1.0, 2.0, 3.0], &values, &twice), &["channel 1", "already"]);
    // Valid, and ignored as the specification says.
    for target in
        [r#""path":"translation""#, r#""path":"pointer","extensions":{"KHR_animation_pointer":{"pointer":"/x"}}"#]
    {
        let channel = format!(r#"{{"sampler":0,"target":{{{target}}}}}"#);
        let model = load(&moved(&[0.0, 1.0, 2.0, 3.0], &values, &channel)).unwrap();
        assert!(model.faults.is_empty() && model.warnings[0].contains("moves no node"), "{:?}", model.warnings);
    }
}

#[test]
fn broken_skins_leave_the_mesh() {
    let nodes = |skin: &str| format!(r#""skins":[{skin}],"nodes":[{{"mesh":0,"skin":0}},{{}}]"#);
    for (skin, words) in [
        (r#"{"joints":[]}"#, ["skin 0", "no joints"]),
        (r#"{"joints":[7]}"#, ["skin 0", "node 7"]),
        (r#"{}"#, ["skin 0", "joints"]),
        (r#"{"joints":[1],"inverseBindMatrices":9}"#, ["skin 0", "accessor 9"]),
        (r#"{"joints":[1],"inverseBindMatrices":0}"#, ["skin 0", "4×4"]),
    ] {
        assert_eq!(mended(&beside(&nodes(skin)), &words).triangle_count(), 2, "{skin}");
    }
}

#[test]
fn texts_that_exporters_write_are_read() {
    let whole = beside(NODES);
    let bytes = |text: &[u8]| Gltf::from_bytes(Path::new("folder/test.gltf"), text);
    let mut latin = whole.replace("\"a\"", "\"caf#\"").into_bytes();
    let at = latin.iter().position(|b| *b == b'#').unwrap();
    latin[at] = 0xE9;
    for (text, word) in [
        ([b"\xEF\xBB\xBF", whole.as_bytes()].concat(), "byte order mark"),
        ([whole.as_bytes(), b"\0\0"].concat(), "zeros"),
        (latin, "UTF-8"),
        (whole.replace("\"max\":[1,1,0]", "\"max\":[NaN,-Infinity,0]").into_bytes(), "NaN"),
        (whole.replace("\"count\":4", "\"count\":4.0").into_bytes(), "real number"),
        (whole.replace("\"scenes\":[", "\"extensionsUsed\":5,\"scenes\":[").into_bytes(), "extensionsUsed"),
        (whole.replace("\"scenes\":[", "\"skins\":{},\"scenes\":[").into_bytes(), "skins"),
        (
            whole
                .replace("\"scenes\":[", "\"extensionsRequired\":[\"KHR_texture_transform\"],\"scenes\":[")
                .into_bytes(),
            "not listed",
        ),
    ] {
        let model = bytes(&text).unwrap();
        assert_eq!(model.triangle_count(), 2, "{word}");
        assert!(model.faults.iter().any(|fault| fault.contains(word)), "{word}: {:?}", model.faults);
    }
    // Valid, and not worth a word.
    let plain = load(&whole.replace("\"min\":[0,0,0],\"max\":[1,1,0]", "\"name\":\"p\"")).unwrap();
    assert!(plain.warnings.is_empty(), "{:?}", plain.warnings);
}

/// The library refuses what it would warn of, if it is asked to.
#[test]
fn strict_loads_refuse_faults() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("m.gltf");
    std::fs::write(&path, beside(&punctual(r#"{"type":"point","range":-1}"#))).unwrap();
    let open = |strict| {
        let mut library = AssetLibrary::new();
        library.begin_load(&crate::assets::LoadBudget::default(), strict);
        library.gltf(&path).map(|_| library.warnings().count())
    };
    assert_eq!(open(false).unwrap(), 1);
    let message = open(true).unwrap_err().to_string();
    assert!(message.contains("m.gltf") && message.contains("range -1"), "{message}");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 256, failure_persistence: None, ..ProptestConfig::default() })]

    /// Any cone gives a spot, and a warning unless it is valid.
    #[test]
    fn any_cone_is_a_spot(inner in -1.0f32..4.0, outer in -1.0f32..4.0, is_equal: bool) {
        let inner = if is_equal { outer } else { inner };
        let spot = format!(r#"{{"type":"spot","spot":{{"innerConeAngle":{inner},"outerConeAngle":{outer}}}}}"#);
        let model = load(&beside(&punctual(&spot))).unwrap();
        let LightKind::Spot { inner: a, outer: b } = model.nodes[0].light.as_ref().unwrap().kind else { panic!() };
        prop_assert!(0.0 <= a && a < b && b <= 90.001, "{a} {b}");
        let is_valid = inner >= 0.0 && inner < outer && outer <= std::f32::consts::FRAC_PI_2;
        prop_assert_eq!(model.faults.is_empty(), is_valid, "{:?}", model.faults);
    }

    /// Any times give a curve that is finite everywhere, and a warning unless they grow.
    #[test]
    fn any_times_make_a_curve(times in prop::collection::vec(prop_oneof![
        8 => (-2i8..6).prop_map(f32::from), 1 => Just(f32::NAN), 1 => Just(f32::INFINITY)], 1..9)) {
        let values: Vec<[f32; 3]> = (0..times.len()).map(|i| [i as f32; 3]).collect();
        let model = load(&moved(&times, &values, TRACK)).unwrap();
        let grow = times.windows(2).all(|pair| pair[0] < pair[1]);
        let is_valid = grow && times.iter().all(|time| time.is_finite() && *time >= 0.0);
        prop_assert_eq!(model.faults.is_empty(), is_valid, "{:?}", model.faults);
        if let Some(curve) = model.clips[0].nodes.get(&0).and_then(|node| node.translation.as_ref()) {
            prop_assert!(curve.times.windows(2).all(|pair| pair[0] < pair[1]));
            let is_sound = |time: f64| curve.at(time).iter().all(|value| value.is_finite());
            prop_assert!((-30..70).all(|step| is_sound(0.1 * f64::from(step))));
        }
    }
}

#[test]
fn every_truncation_of_a_binary_file_is_refused() {
    let mut json = format!(
        r#"{{"asset":{{"version":"2.0"}},"buffers":[{{"byteLength":92}}],{VIEWS},{ACCESSORS},{MESH},{NODES}}}"#
    );
    while json.len() % 4 != 0 {
        json.push(' ');
    }
    let bin = square_bytes();
    let words = |list: &[u32]| list.iter().flat_map(|w| w.to_le_bytes()).collect::<Vec<u8>>();
    let total = 12 + 8 + json.len() + 8 + bin.len();
    let mut glb = words(&[0x4654_6C67, 2, total as u32, json.len() as u32, 0x4E4F_534A]);
    glb.extend(json.as_bytes());
    glb.extend(words(&[bin.len() as u32, 0x004E_4942]));
    glb.extend(&bin);
    let path = Path::new("test.glb");
    assert_eq!(Gltf::from_bytes(path, &glb).unwrap().triangle_count(), 2);
    for length in 0..glb.len() {
        assert!(Gltf::from_bytes(path, &glb[..length]).is_err(), "{length} bytes");
        // The same with a header that fits.
        if length >= 12 {
            let mut cut = glb[..length].to_vec();
            cut[8..12].copy_from_slice(&(length as u32).to_le_bytes());
            assert!(Gltf::from_bytes(path, &cut).is_err(), "{length} bytes");
        }
    }
    // No change of a byte may panic.
    for at in 0..glb.len() {
        let mut changed = glb.clone();
        changed[at] ^= 0x55;
        let _ = Gltf::from_bytes(path, &changed);
        changed[at] = 255;
        let _ = Gltf::from_bytes(path, &changed);
    }
}
