//! Skins, morph targets and animations.

use super::*;

#[test]
fn joints_and_weights() {
    let weights = |rows: [[f32; 4]; 4]| Bytes(WEIGHTS, floats(&rows.concat()));
    const FIRST: [f32; 4] = [1., 0., 0., 0.];
    let two =
        |accessor: usize, at: &'static str, values: &[f32]| vec![Set(at, "\"VEC2\""), Bytes(accessor, floats(values))];
    let set = "/meshes/0/primitives/0/attributes/";
    let at = |name: &str| -> &'static str { Box::leak(format!("{set}{name}").into_boxed_str()) };
    check(vec![
        (
            "weights that sum to two",
            vec![weights([[1., 1., 0., 0.], [2., 0., 0., 0.], FIRST, FIRST])],
            Mended(&[], &["2 of 4 vertices", "do not sum to 1"]),
        ),
        (
            "weights of zero",
            vec![weights([[0.5, 0.5, 0., 0.], [0.; 4], FIRST, FIRST])],
            Mended(&[], &["1 of 4 vertices", "first joint"]),
        ),
        (
            "negative weights",
            vec![weights([[0.5, 0.5, 0., 0.], [1., -1., 0., 0.], FIRST, FIRST])],
            Mended(&[], &["1 of 4 vertices"]),
        ),
        (
            "weights that are no number",
            vec![weights([[0.5, 0.5, 0., 0.], [1., f32::NAN, 0., 0.], FIRST, FIRST])],
            Mended(&[], &["1 of 4 vertices"]),
        ),
        (
            "weights in bytes that are not marked as normalised",
            vec![
                Set("/accessors/6/componentType", "5121"),
                Bytes(WEIGHTS, [[128u8, 128, 0, 0], [255, 0, 0, 0], [255, 0, 0, 0], [255, 0, 0, 0]].concat()),
            ],
            Mended(&[], &["accessor 6", "taken as normalised"]),
        ),
        (
            "weights of two joints",
            two(WEIGHTS, "/accessors/6/type", &[0.5, 0.5, 1., 0., 1., 0., 1., 0.]),
            Mended(&[], &["accessor 6", "2 components where 4"]),
        ),
        (
            "two joints in floats",
            [
                two(JOINTS, "/accessors/5/type", &[0., 1., 1., 0., 0., 0., 0., 0.]),
                vec![Set("/accessors/5/componentType", "5126")],
            ]
            .concat(),
            Mended(&[], &["accessor 5", "unsigned bytes or shorts"]),
        ),
        (
            "joints in words",
            vec![
                Set("/accessors/5/componentType", "5125"),
                Bytes(JOINTS, words(&[[0, 1, 0, 0], [1, 0, 0, 0], [0; 4], [0; 4]].concat())),
            ],
            Mended(&[], &["accessor 5", "unsigned bytes or shorts"]),
        ),
        (
            "normalised joints",
            vec![Set("/accessors/5/normalized", "true")],
            Mended(&[], &["accessor 5", "taken as such"]),
        ),
        (
            "joints with fractions",
            vec![Set("/meshes/0/primitives/0/attributes/JOINTS_0", "6")],
            Warned(&["JOINTS_0", "0.5", "no joint"]),
        ),
        (
            "joints beyond the skin",
            vec![
                Bytes(JOINTS, [[0u8, 1, 9, 0], [1, 0, 0, 0], [0, 9, 0, 0], [0; 4]].concat()),
                weights([[0.25, 0.25, 0.5, 0.], FIRST, FIRST, FIRST]),
            ],
            Mended(&[], &["node 0", "joint 9", "the skin has 2"]),
        ),
        (
            "joints beyond the skin, without weight",
            vec![Bytes(JOINTS, [[0u8, 1, 9, 9], [1, 9, 9, 9], [0, 9, 9, 9], [0, 9, 9, 9]].concat())],
            Read(&[]),
        ),
        (
            "the second set alone",
            vec![
                Set(at("JOINTS_0"), "null"),
                Set(at("WEIGHTS_0"), "null"),
                Set(at("JOINTS_1"), "5"),
                Set(at("WEIGHTS_1"), "6"),
            ],
            Read(&[]),
        ),
        (
            "a second set without weights",
            vec![Set(at("JOINTS_1"), "5")],
            Mended(&[], &["JOINTS_1 and WEIGHTS_1", "together"]),
        ),
    ]);
}

#[test]
fn skins_and_morph_targets() {
    let identity = Mat4::IDENTITY.to_cols_array();
    check(vec![
        ("no inverse bind matrices", vec![Set("/skins/0/inverseBindMatrices", "null")], Read(&[])),
        (
            "too few of them",
            vec![Set("/accessors/9/count", "1")],
            Mended(&[], &["skin 0", "1 inverse bind matrices for 2"]),
        ),
        (
            "one that is no number",
            vec![Bytes(BIND, floats(&[[f32::NAN; 16], identity].concat()))],
            Mended(&[], &["skin 0", "1 inverse bind matrices are not finite"]),
        ),
        (
            "one without volume",
            vec![Bytes(BIND, floats(&[[0.; 16], identity].concat()))],
            Warned(&["skin 0", "project"]),
        ),
        ("a skeleton that is not there", vec![Set("/skins/0/skeleton", "77")], Mended(&[], &["skin 0", "node 77"])),
        ("a skeleton that is no ancestor", vec![Set("/skins/0/skeleton", "3")], Read(&[])),
        ("a joint that is not there", vec![Set("/skins/0/joints", "[1, 77]")], Warned(&["skin 0", "node 77"])),
        ("a skin of -1", vec![Set("/nodes/3/skin", "-1")], Mended(&[], &["node 3", "none"])),
        ("a bone of size zero", vec![Set("/nodes/2/scale", "[0, 0, 0]")], Read(&[Set("/nodes/2/scale", "[0, 0, 0]")])),
        (
            "joints outside of the scene",
            vec![Set("/scenes/0/nodes", "[0, 3]")],
            Read(&[Set("/scenes/0/nodes", "[0, 3]")]),
        ),
        (
            "more weights than targets",
            vec![Set("/meshes/0/weights", "[0.5, 0.1]")],
            Mended(&[], &["body", "2 weights for 1"]),
        ),
        (
            "no weights for the targets",
            vec![Set("/meshes/0/weights", "[]")],
            Mended(&[Set("/meshes/0/weights", "[0]")], &["0 weights"]),
        ),
        (
            "targets of nothing",
            vec![Set("/meshes/0/primitives/0/targets", "[{}]")],
            Read(&[Set("/meshes/0/primitives/0/targets", "[{}]")]),
        ),
    ]);
}

#[test]
fn tracks() {
    let sampler = |index: usize, field: &str| -> &'static str {
        Box::leak(format!("/animations/0/samplers/{index}/{field}").into_boxed_str())
    };
    let turns = [0i16, 0, 0, 32767, 0, 0, 32767, 0, 0, 32767, 0, 0];
    check(vec![
        (
            "a spline without tangents",
            vec![Set(sampler(0, "interpolation"), "\"CUBICSPLINE\"")],
            Mended(&[], &["channel 0", "without tangents"]),
        ),
        (
            "an interpolation in another case",
            vec![Set(sampler(1, "interpolation"), "\"Linear\"")],
            Mended(&[], &["LINEAR"]),
        ),
        (
            "an interpolation of a draft",
            vec![Set(sampler(1, "interpolation"), "\"CATMULLROMSPLINE\"")],
            Mended(&[], &["CATMULLROMSPLINE"]),
        ),
        (
            "times in bytes",
            vec![Set("/accessors/10/componentType", "5121"), Bytes(TIMES, vec![0, 1, 2])],
            Mended(&[], &["channel 0", "times must be floats"]),
        ),
        (
            "turns in shorts",
            vec![
                Set("/accessors/12/componentType", "5122"),
                Set("/accessors/12/normalized", "true"),
                Bytes(TURNS, shorts(&turns)),
            ],
            Read(&[]),
        ),
        (
            "turns in shorts that are not marked as normalised",
            vec![Set("/accessors/12/componentType", "5122"), Bytes(TURNS, shorts(&turns))],
            Mended(&[], &["channel 1", "taken as normalised"]),
        ),
        (
            "moves in shorts",
            vec![Set("/accessors/11/componentType", "5122"), Bytes(MOVES, shorts(&[0, 0, 0, 1, 0, 0, 2, 0, 0]))],
            Mended(&[], &["channel 0", "as they are"]),
        ),
        (
            "weights of two targets",
            vec![Set("/accessors/13/count", "6"), Bytes(MORPHS, floats(&[0., 7., 1., 7., 0., 7.]))],
            Mended(&[], &["channel 2", "of 2 weights a key"]),
        ),
        (
            "a key too many",
            vec![
                Set("/accessors/11/count", "4"),
                Bytes(MOVES, floats(&[0., 0., 0., 1., 0., 0., 2., 0., 0., 9., 9., 9.])),
            ],
            Mended(&[], &["channel 0", "12 numbers for 3 keys"]),
        ),
        ("values of another type", vec![Set(sampler(1, "output"), "11")], Warned(&["channel 1", "Vec3"])),
        (
            "a target that is not there",
            vec![Set("/animations/0/channels/0/target/node", "77")],
            Warned(&["channels 0", "node 77"]),
        ),
        (
            "an animation of nothing",
            vec![Set("/animations/-", r#"{"channels": [], "samplers": []}"#)],
            Read(&[Set("/animations/-", r#"{"channels": [], "samplers": []}"#)]),
        ),
    ]);
}

/// A spline that is called linear goes through its values.
#[test]
fn splines_under_another_name() {
    let spline: Vec<f32> = [0., 1., 2.].iter().flat_map(|x| [[0.; 3], [*x, 0., 0.], [0.; 3]].concat()).collect();
    let model = load_edited(&[Set("/accessors/11/count", "9"), Bytes(MOVES, floats(&spline))]).unwrap();
    says("spline", &model, &["channel 0", "taken for a spline"]);
    let curve = model.clips[0].nodes[&1].translation.as_ref().unwrap();
    assert_eq!([0.0, 1.0, 2.0].map(|time| curve.at(time)[0]), [0.0, 1.0, 2.0]);
}

/// Turns that are not of unit length are the same turns.
#[test]
fn turns_of_any_length() {
    let long = load_edited(&[Bytes(TURNS, floats(&[0., 0., 0., 2., 0., 0., 3., 0., 0., 0., 0.5, 0.]))]).unwrap();
    let short = load_edited(&[Bytes(TURNS, floats(&[0., 0., 0., 1., 0., 0., 1., 0., 0., 0., 1., 0.]))]).unwrap();
    let at = |model: &Gltf, time: f64| model.clips[0].nodes[&1].rotation.as_ref().unwrap().at(time);
    for time in [0.0, 0.3, 0.5, 1.0, 1.5, 2.0] {
        let (a, b) = (at(&long, time), at(&short, time));
        assert!(a.iter().zip(&b).all(|(a, b)| (a - b).abs() < 1e-6), "{time}: {a:?} {b:?}");
    }
    let tilted = load_edited(&[Set("/nodes/2/rotation", "[0, 0, 2, 2]")]).unwrap();
    let level = load_edited(&[Set("/nodes/2/rotation", "[0, 0, 0.70710678, 0.70710678]")]).unwrap();
    assert!(tilted.nodes[2].local.rotation.angle_between(level.nodes[2].local.rotation) < 1e-3);
}
