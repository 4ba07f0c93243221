//! Scenes, nodes, cameras and lights.

use super::*;

#[test]
fn scenes() {
    check(vec![
        ("no default scene", vec![Set("/scene", "null")], Read(&[])),
        ("a default scene of -1", vec![Set("/scene", "-1")], Mended(&[], &["scene", "none"])),
        ("a default scene that is not there", vec![Set("/scene", "7")], Mended(&[], &["scene 7"])),
        ("no scenes", vec![Set("/scene", "null"), Set("/scenes", "null")], Read(&[])),
        ("a list of no scenes", vec![Set("/scene", "null"), Set("/scenes", "[]")], Read(&[])),
        ("a scene without nodes", vec![Set("/scenes", "[{}]")], Mended(&[], &["scene 0", "all nodes are shown"])),
        (
            "an empty scene before a full one",
            vec![Set("/scenes", r#"[{"nodes": []}, {"nodes": [0, 1, 3]}]"#)],
            Mended(&[], &["scene 0", "scene 1 is shown"]),
        ),
        (
            "a scene of a node that is not there",
            vec![Set("/scenes/0/nodes/-", "77")],
            Mended(&[], &["scene 0", "node 77"]),
        ),
        (
            "a scene that lists a child",
            vec![Set("/scenes/0/nodes/-", "2")],
            Mended(&[], &["node 2", "child of node 1"]),
        ),
    ]);
}

#[test]
fn nodes() {
    check(vec![
        ("no children", vec![Set("/nodes/3/children", "[]")], Read(&[])),
        ("a child twice", vec![Set("/nodes/1/children", "[2, 2]")], Mended(&[], &["node 2", "first counts"])),
        ("a child of two", vec![Set("/nodes/3/children", "[2]")], Mended(&[], &["node 2", "first counts"])),
        (
            "a camera and a mesh of -1",
            vec![Set("/nodes/1/camera", "-1"), Set("/nodes/1/mesh", "-1")],
            Mended(&[], &["node 1", "none"]),
        ),
        (
            "a matrix and parts",
            vec![Set("/nodes/1/matrix", "[1,0,0,0, 0,1,0,0, 0,0,1,0, 4,0,0,1]"), Set("/nodes/1/scale", "[2,2,2]")],
            Mended(&[Set("/nodes/1/translation", "[4,0,0]")], &["node 1", "the matrix counts"]),
        ),
        (
            "a matrix that does nothing, and parts",
            vec![Set("/nodes/2/matrix", "[1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]")],
            Mended(&[], &["node 2", "the others count"]),
        ),
        (
            "a translation of four numbers",
            vec![Set("/nodes/2/translation", "[0,0,1,1]")],
            Mended(&[], &["node 2", "4 numbers"]),
        ),
        ("extensions that are a list", vec![Set("/nodes/2/extensions", "[]")], Mended(&[], &["node 2", "extensions"])),
        ("extensions of nothing", vec![Set("/nodes/2/extensions", "{}")], Read(&[])),
        ("a name that is a number", vec![Set("/cameras/0/name", "5")], Mended(&[], &["camera 0", "text"])),
    ]);
}

#[test]
fn cameras_and_lights() {
    const LIGHTS: &str =
        r#"{"KHR_lights": {"lights": [{"type": "point", "intensity": 2}, {"type": "ambient", "color": [1, 1, 1]}]}}"#;
    check(vec![
        (
            "lights of the draft",
            vec![
                Set("/extensionsUsed", r#"["KHR_lights", "KHR_texture_transform"]"#),
                Set("/extensions", LIGHTS),
                Set("/nodes/3/extensions", r#"{"KHR_lights": {"light": 0}}"#),
            ],
            Mended(&[], &["KHR_lights", "draft"]),
        ),
        ("an extension that is not listed", vec![Set("/extensionsUsed", "null")], Read(&[])),
        (
            "lights that are not there",
            vec![Set("/extensions", "null")],
            Mended(&[Set("/extensions", "null"), Set("/nodes/3/extensions", "null")], &["node 3", "light 0"]),
        ),
        (
            "a light of -1",
            vec![Set("/nodes/1/extensions", r#"{"KHR_lights_punctual": {"light": -1}}"#)],
            Mended(&[], &["node 1", "light"]),
        ),
        (
            "a colour with alpha",
            vec![Set("/extensions/KHR_lights_punctual/lights/0/color", "[1, 1, 1, 1]")],
            Mended(&[], &["light 0", "4 numbers"]),
        ),
        (
            "a kind in another case",
            vec![Set("/extensions/KHR_lights_punctual/lights/0/type", "\"Point\"")],
            Mended(&[], &["light 0", "point"]),
        ),
        ("an aspect ratio of zero", vec![Set("/cameras/0/perspective/aspectRatio", "0")], Read(&[])),
        (
            "a field of view of zero",
            vec![Set("/cameras/0/perspective/yfov", "0")],
            Mended(&[Set("/nodes/3/camera", "null")], &["camera 0", "yfov 0"]),
        ),
        (
            "the projection of another kind beside its own",
            vec![Set("/cameras/0/orthographic", "{}")],
            Warned(&["camera 0"]),
        ),
    ]);
}
