//! Broken files are refused with the place of the fault.

use super::*;

#[test]
fn broken_data_is_refused_with_its_place() {
    let bytes = square_bytes();
    let doc =
        |views: &str, accessors: &str, mesh: &str, nodes: &str| document(&bytes, &[views, accessors, mesh, nodes]);
    let mut out_of_range = bytes.clone();
    out_of_range[80] = 9;
    refuse(&document(&out_of_range, &[VIEWS, ACCESSORS, MESH, NODES]), &["square", "accessor 2", "index 9"]);
    let mut not_a_number = bytes.clone();
    not_a_number[..4].copy_from_slice(&f32::NAN.to_le_bytes());
    refuse(&document(&not_a_number, &[VIEWS, ACCESSORS, MESH, NODES]), &["square", "accessor 0", "NaN"]);
    refuse(
        &doc(&VIEWS.replace("\"byteLength\":48", "\"byteLength\":40"), ACCESSORS, MESH, NODES),
        &["accessor 0", "do not fit"],
    );
    refuse(
        &doc(&VIEWS.replace("\"byteLength\":12", "\"byteLength\":9999"), ACCESSORS, MESH, NODES),
        &["buffer view 2", "beyond the end"],
    );
    let huge = ACCESSORS.replace("\"count\":6", "\"count\":18446744073709551615");
    refuse(&doc(VIEWS, &huge, MESH, NODES), &["accessor 2"]);
    refuse(&doc(VIEWS, &ACCESSORS.replace("\"count\":6", "\"count\":0"), MESH, NODES), &["accessor 2", "no elements"]);
    refuse(&doc(VIEWS, &ACCESSORS.replace("5123", "5126"), MESH, NODES), &["accessor 2"]);
    refuse(&doc(VIEWS, ACCESSORS, &MESH.replace(":0,", ":7,"), NODES), &["mesh 0", "accessor 7"]);
    refuse(&doc(VIEWS, ACCESSORS, &MESH.replace("\"TEXCOORD_0\":1", "\"NORMAL\":1"), NODES), &["accessor 1", "Vec2"]);
    let cycle = r#""nodes":[{"children":[1]},{"name":"b","children":[0]}]"#;
    refuse(&doc(VIEWS, ACCESSORS, MESH, cycle), &["cycle"]);
    refuse(&doc(VIEWS, ACCESSORS, MESH, r#""nodes":[{"children":[0]}]"#), &["cycle"]);
    let two = r#""nodes":[{"children":[2]},{"children":[2]},{"name":"c"}]"#;
    refuse(&doc(VIEWS, ACCESSORS, MESH, two), &["node 2 \"c\"", "one parent"]);
    refuse(&doc(VIEWS, ACCESSORS, MESH, r#""nodes":[{"mesh":3}]"#), &["nodes[0].mesh", "not in the file"]);
    refuse(&doc(VIEWS, ACCESSORS, MESH, r#""nodes":[{"scale":[1e39,1,1]}]"#), &["test.gltf"]);
    let needs = r#""extensionsUsed":["EXT_x"],"extensionsRequired":["EXT_x"]"#;
    refuse(&doc(VIEWS, ACCESSORS, MESH, needs), &["EXT_x", "not supported"]);
    refuse(r#"{"asset":{"version":"1.0"}}"#, &["asset.version", "1.0"]);
    refuse("{", &["JSON, line 1"]);
    for uri in ["https://example.org/a.bin", "../a.bin", "/etc/hostname"] {
        refuse(
            &format!(r#"{{"asset":{{"version":"2.0"}},"buffers":[{{"byteLength":4,"uri":"{uri}"}}]}}"#),
            &["buffer 0", uri],
        );
    }
    refuse(r#"{"asset":{"version":"2.0"},"buffers":[{"byteLength":4,"uri":"gone.bin"}]}"#, &["buffer 0", "gone.bin"]);
}

/// Faults that the parser takes and stumbles over later.
#[test]
fn kinds_without_their_parameters_are_refused() {
    let punctual = |lights: &str| {
        format!(
            r#""extensionsUsed":["KHR_lights_punctual"],"extensions":{{"KHR_lights_punctual":{{"lights":[{lights}]}}}}"#
        )
    };
    let lit = r#","nodes":[{"extensions":{"KHR_lights_punctual":{"light":1}}}]"#;
    let curve = |path: &str| {
        format!(
            r#""nodes":[{{}}],"animations":[{{"samplers":[{{"input":0,"output":0}}],
            "channels":[{{"sampler":0,"target":{{"node":0,"path":"{path}"}}}}]}}]"#
        )
    };
    for (rest, words) in [
        (
            r#""cameras":[{"type":"orthographic","perspective":{"yfov":1,"znear":0.1}}]"#.into(),
            ["camera 0", "orthographic"],
        ),
        (
            r#""cameras":[{"type":"perspective","orthographic":{"xmag":1,"ymag":1,"znear":0,"zfar":1}}]"#.into(),
            ["camera 0", "perspective"],
        ),
        (r#""cameras":[{"type":"fisheye","perspective":{"yfov":1,"znear":0.1}}]"#.into(), ["cameras[0]", "not allow"]),
        (
            r#""cameras":[{"type":"orthographic","orthographic":{"xmag":1,"ymag":0,"znear":0,"zfar":1}}]"#.into(),
            ["camera 0", "ymag 0"],
        ),
        (
            r#""cameras":[{"type":"orthographic","orthographic":{"xmag":1,"ymag":1,"znear":2,"zfar":1}}]"#.into(),
            ["camera 0", "zfar 1"],
        ),
        (punctual(r#"{"type":"spot"}"#), ["light 0", "spot"]),
        (punctual(r#"{"type":"point"}"#) + lit, ["node 0", "light 1"]),
        (curve("trenslation"), ["animation 0, channel 0", "none of translation"]),
    ] {
        refuse(&document(&square_bytes(), &[VIEWS, ACCESSORS, &rest]), &words);
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
