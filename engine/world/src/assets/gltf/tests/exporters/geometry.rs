//! Accessors, buffer views and primitives.

use super::*;

const ATTRIBUTES: &str = "/meshes/0/primitives/0/attributes/";

#[test]
fn accessors_and_buffer_views() {
    let base = "/bufferViews/8/byteLength";
    check(vec![
        ("no bounds", vec![Set("/accessors/0/min", "null"), Set("/accessors/0/max", "null")], Read(&[])),
        ("wrong bounds", vec![Set("/accessors/0/max", "[0.5, 0.5, 0.5]")], Read(&[])),
        ("bounds of a wrong length", vec![Set("/accessors/0/min", "[0]")], Read(&[])),
        (
            "bounds that are texts",
            vec![Set("/accessors/0/min", r#"["0", "0", "0"]"#)],
            Mended(&[], &["accessor 0, min"]),
        ),
        (
            "a stride of 0",
            vec![Set("/bufferViews/0/byteStride", "0")],
            Mended(&[], &["buffer view 0, byteStride", "none"]),
        ),
        (
            "a stride of indices",
            vec![Set("/bufferViews/8/byteStride", "2")],
            Mended(&[], &["buffer view 8", "stride 2"]),
        ),
        ("a stride of tracks", vec![Set("/bufferViews/11/byteStride", "12")], Read(&[])),
        ("a stride below the size", vec![Set("/bufferViews/1/byteStride", "8")], Warned(&["accessor 1", "stride 8"])),
        ("a target that is none", vec![Set("/bufferViews/0/target", "7")], Mended(&[], &["buffer view 0, target"])),
        ("a target of the other kind", vec![Set("/bufferViews/0/target", "34963")], Read(&[])),
        (
            "a view beyond its buffer",
            vec![Set("/bufferViews/14/byteLength", "99999")],
            Mended(&[], &["buffer view 14", "beyond the end"]),
        ),
        (
            "a view that ends early",
            vec![Set(base, "8")],
            Mended(&[Set("/meshes/0/primitives", "[]")], &["accessor 8", "do not fit"]),
        ),
        (
            "a buffer longer than it says",
            vec![Set("/buffers/0/byteLength", "99999")],
            Mended(&[], &["buffer 0", "byteLength"]),
        ),
        (
            "a type in another case",
            vec![Set("/accessors/0/type", "\"vec3\"")],
            Mended(&[], &["accessor 0, type", "VEC3"]),
        ),
        (
            "a view of -1",
            vec![Set("/accessors/7/bufferView", "-1")],
            Mended(&[Set("/accessors/7/bufferView", "null")], &["none"]),
        ),
        (
            "sparse values beyond the end",
            vec![
                Set(
                    "/accessors/0/sparse",
                    r#"{"count":1,"indices":{"bufferView":8,"byteOffset":12,"componentType":5121},"values":{"bufferView":1}}"#,
                ),
                Bytes(INDICES, [shorts(&[0, 1, 2, 0, 2, 3]), vec![9, 0, 0, 0]].concat()),
            ],
            Mended(&[], &["accessor 0", "sparse index 9"]),
        ),
    ]);
}

#[test]
fn formats_of_attributes() {
    let with = |accessor: usize, edits: &[Edit], bytes: Vec<u8>| [edits, &[Bytes(accessor, bytes)]].concat();
    let kind = |at: &'static str| Set(at, "\"VEC4\"");
    check(vec![
        (
            "positions of four numbers",
            with(
                POSITION,
                &[kind("/accessors/0/type"), Set("/accessors/0/min", "null"), Set("/accessors/0/max", "null")],
                floats(&[0., 0., 0., 1., 1., 0., 0., 1., 1., 1., 0., 1., 0., 1., 0., 1.]),
            ),
            Mended(&[], &["accessor 0", "4 components where 3"]),
        ),
        (
            "normals of four numbers",
            with(NORMAL, &[kind("/accessors/1/type")], floats(&[[0., 0., 1., 0.]; 4].concat())),
            Mended(&[], &["accessor 1", "4 components where 3"]),
        ),
        (
            "tangents without handedness",
            with(TANGENT, &[Set("/accessors/2/type", "\"VEC3\"")], floats(&[[1., 0., 0.]; 4].concat())),
            Mended(&[], &["accessor 2", "3 components where 4"]),
        ),
        (
            "texture coordinates of three numbers",
            with(
                UV,
                &[Set("/accessors/3/type", "\"VEC3\"")],
                floats(&[0., 1., 0., 1., 1., 0., 1., 0., 0., 0., 0., 0.]),
            ),
            Mended(&[], &["accessor 3", "3 components where 2"]),
        ),
        (
            "colours without alpha",
            with(
                COLOR,
                &[Set("/accessors/4/type", "\"VEC3\"")],
                floats(&[1., 0., 1., 0., 1., 0., 0., 0., 1., 1., 1., 0.]),
            ),
            Read(&[]),
        ),
        (
            "colours in bytes that are not marked as normalised",
            with(
                COLOR,
                &[Set("/accessors/4/componentType", "5121")],
                vec![255, 0, 255, 255, 0, 255, 0, 255, 0, 0, 255, 255, 255, 255, 0, 255],
            ),
            Mended(&[], &["accessor 4", "taken as normalised"]),
        ),
        (
            "texture coordinates in shorts that are not marked as normalised",
            with(UV, &[Set("/accessors/3/componentType", "5123")], shorts(&[0, 1, 1, 1, 1, 0, 0, 0])),
            Mended(&[], &["accessor 3", "KHR_mesh_quantization"]),
        ),
        (
            "positions in bytes without the extension",
            with(
                POSITION,
                &[Set("/accessors/0/componentType", "5120"), Set("/bufferViews/0/byteStride", "4")],
                vec![0, 0, 0, 0, 1, 0, 0, 0, 1, 1, 0, 0, 0, 1, 0, 0],
            ),
            Mended(&[], &["accessor 0", "KHR_mesh_quantization"]),
        ),
        ("normals of two numbers", vec![Set("/accessors/1/type", "\"VEC2\"")], Warned(&["accessor 1", "Vec2"])),
        ("normals longer than one", vec![Bytes(NORMAL, floats(&[[0., 0., 3.]; 4].concat()))], Read(&[])),
        ("normals of zero", vec![Bytes(NORMAL, floats(&[0.; 12]))], Mended(&[], &["square", "4 normals"])),
        (
            "normals that are no number",
            vec![Bytes(NORMAL, floats(&[f32::NAN; 12]))],
            Mended(&[], &["square", "4 normals"]),
        ),
        ("a handedness of zero", vec![Bytes(TANGENT, floats(&[[1., 0., 0., 0.]; 4].concat()))], Read(&[])),
        ("tangents of zero", vec![Bytes(TANGENT, floats(&[0.; 16]))], Mended(&[], &["tangents of 6 of 6", "computed"])),
        (
            "tangents that are no number",
            vec![Bytes(TANGENT, floats(&[f32::NAN; 16]))],
            Mended(&[], &["tangents", "computed"]),
        ),
        (
            "a texture coordinate that is no number",
            vec![Bytes(UV, floats(&[0., 1., 1., 1., 1., 0., f32::NAN, 0.]))],
            Mended(&[], &["accessor 3", "1 elements are not finite"]),
        ),
        (
            "colours above one",
            vec![Bytes(
                COLOR,
                floats(&[[9., 0., 1., 1.], [0., 1., -1., 1.], [0., 0., 1., 1.], [1., 1., 0., 1.]].concat()),
            )],
            Read(&[]),
        ),
        (
            "an offset that is no number",
            vec![Bytes(TARGET, floats(&[f32::NAN, 0., 0., 0., 0., 1., 0., 0., 1., 0., 0., 1.]))],
            Mended(&[], &["accessor 7", "1 elements are not finite"]),
        ),
        (
            "more normals than positions",
            with(NORMAL, &[Set("/accessors/1/count", "5")], floats(&[[0., 0., 1.]; 5].concat())),
            Mended(&[], &["accessor 1", "5 elements, but 4 positions"]),
        ),
        (
            "a count that is too small",
            vec![Set("/accessors/3/count", "2")],
            Mended(&[], &["accessor 3", "those that follow"]),
        ),
        (
            "less normals than positions",
            with(NORMAL, &[Set("/accessors/1/count", "3")], floats(&[[0., 0., 1.]; 3].concat())),
            Warned(&["accessor 1", "3 elements, but 4 positions"]),
        ),
    ]);
}

#[test]
fn attributes_that_are_missing_or_unknown() {
    let at = |name: &str| -> &'static str { Box::leak(format!("{ATTRIBUTES}{name}").into_boxed_str()) };
    check(vec![
        (
            "a name of glTF 1.0",
            vec![Set(at("TEXCOORD_0"), "null"), Set(at("TEXCOORD"), "3")],
            Mended(&[], &["glTF 1.0"]),
        ),
        ("a name without an underscore", vec![Set(at("BATCHID"), "3")], Mended(&[], &["BATCHID", "ignored"])),
        ("a name of one's own", vec![Set(at("_BATCHID"), "3")], Read(&[])),
        ("a second colour", vec![Set(at("COLOR_1"), "4")], Read(&[])),
        (
            "tangents without normals",
            vec![Set(at("NORMAL"), "null")],
            Read(&[Set("/meshes/0/primitives/0/attributes/NORMAL", "null")]),
        ),
        (
            "no texture coordinates for the textures",
            vec![Set(at("TEXCOORD_0"), "null")],
            Warned(&["square", "needs TEXCOORD_0", "has none"]),
        ),
        (
            "the second set where there is the first alone",
            vec![Set("/materials/0/pbrMetallicRoughness/baseColorTexture/texCoord", "1")],
            Warned(&["needs TEXCOORD_1", "TEXCOORD_0 is taken"]),
        ),
        (
            "no positions",
            vec![Set(at("POSITION"), "null")],
            Mended(&[Set("/meshes/0/primitives", "[]")], &["square", "no positions"]),
        ),
        ("names of morph targets", vec![Set("/meshes/0/extras", r#"{"targetNames": [1, null, "a"]}"#)], Read(&[])),
        ("extras that are no object", vec![Set("/meshes/0/extras", "[]"), Set("/nodes/0/extras", "7")], Read(&[])),
    ]);
}

#[test]
fn indices_and_modes() {
    let indices =
        |kind: &'static str, bytes: Vec<u8>| vec![Set("/accessors/8/componentType", kind), Bytes(INDICES, bytes)];
    let longer = shorts(&[0, 1, 2, 0, 2, 3, 1]);
    let strip = |bytes: Vec<u8>, count: &'static str| {
        vec![Set("/meshes/0/primitives/0/mode", "5"), Set("/accessors/8/count", count), Bytes(INDICES, bytes)]
    };
    check(vec![
        ("indices in bytes", indices("5121", vec![0, 1, 2, 0, 2, 3]), Read(&[])),
        ("indices in words", indices("5125", words(&[0, 1, 2, 0, 2, 3])), Read(&[])),
        ("indices with a sign", indices("5122", shorts(&[0, 1, 2, 0, 2, 3])), Mended(&[], &["accessor 8", "unsigned"])),
        (
            "indices in floats",
            indices("5126", floats(&[0., 1., 2., 0., 2., 3.])),
            Mended(&[], &["accessor 8", "unsigned"]),
        ),
        ("normalised indices", vec![Set("/accessors/8/normalized", "true")], Mended(&[], &["accessor 8", "unsigned"])),
        (
            "a corner too many",
            vec![Set("/accessors/8/count", "7"), Bytes(INDICES, longer)],
            Mended(&[], &["square", "last 1 corners"]),
        ),
        ("no mode", vec![Set("/meshes/0/primitives/0/mode", "4")], Read(&[])),
        (
            "a mode that is none",
            vec![Set("/meshes/0/primitives/0/mode", "9")],
            Mended(&[Set("/meshes/0/primitives", "[]")], &["mode"]),
        ),
        (
            "restarts in a strip",
            strip(shorts(&[0, 1, 2, -1, 0, 2, 3]), "7"),
            Mended(&[], &["accessor 8", "65535", "beginning of a strip"]),
        ),
        (
            "a restart after an even number of corners",
            strip(shorts(&[0, 1, -1, 0, 1, 2, -1, 0, 2, 3]), "10"),
            Mended(&[], &["accessor 8", "beginning of a strip"]),
        ),
        (
            "a restart in a list",
            vec![Set("/accessors/8/count", "9"), Bytes(INDICES, shorts(&[0, 1, 2, -1, 1, 2, 0, 2, 3]))],
            Mended(&[], &["index 65535", "1 of 3 triangles"]),
        ),
    ]);
}

/// Where a line strip begins anew, no line is drawn.
#[test]
fn restarts_part_lines() {
    let lines = |bytes: Vec<u8>, count: &'static str, mode: &'static str| {
        let edits = [Set("/meshes/0/primitives/0/mode", mode), Set("/accessors/8/count", count), Bytes(INDICES, bytes)];
        load_edited(&edits).unwrap()
    };
    let parted = lines(shorts(&[0, 1, -1, 2, 3]), "5", "3");
    says("restart", &parted, &["beginning of a strip"]);
    same("restart", &parted, &lines(shorts(&[0, 1, 2, 3]), "4", "1"));
    let lost = lines(shorts(&[0, 1, 9, 2, 3]), "5", "3");
    says("lost", &lost, &["index 9", "2 of 4 lines"]);
    same("lost", &lost, &parted);
}
