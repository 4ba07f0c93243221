//! What each crate takes with it: whoever writes a game compiles no editor, no plots, and nothing that measures.

use lightwell_tests::root;
use std::collections::BTreeSet;
use std::process::Command;

/// Names of a crate and of all crates that it is built with, in its default features, on this system.
fn built_with(package: &str) -> BTreeSet<String> {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let output = Command::new(cargo)
        .current_dir(root())
        .args(["tree", "-p", package, "-e", "normal", "--offline", "--locked", "--prefix", "none"])
        .output()
        .expect("cargo runs");
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let names: BTreeSet<_> =
        text.lines().filter_map(|line| line.split_whitespace().next()).map(str::to_owned).collect();
    assert!(names.contains(package) && names.contains("lightwell-core"), "{names:?}");
    names
}

fn assert_without(package: &str, unwanted: &[&str]) {
    let names = built_with(package);
    let found: Vec<_> = unwanted.iter().filter(|name| names.contains(**name)).collect();
    assert!(found.is_empty(), "{package} is built with {found:?}");
}

/// What draws plots, reads OpenEXR, compares images, asks for the machine or draws the editor's tiles.
const TOOLS: [&str; 8] = ["plotters", "egui_tiles", "exr", "jiff", "sysinfo", "indicatif", "nv-flip", "proptest"];

#[test]
fn a_game_takes_neither_editor_nor_tools() {
    assert_without("lightwell-game", &TOOLS);
    assert_without("lightwell-game", &["lightwell-editor", "lightwell-tools", "lightwell-program"]);
}

#[test]
fn arrows_point_one_way() {
    assert_without("lightwell-core", &["lightwell", "lightwell-gpu", "lightwell-world", "wgpu"]);
    assert_without("lightwell-gpu", &["lightwell", "lightwell-world", "bevy_mikktspace", "gltf"]);
    assert_without("lightwell-world", &["lightwell", "lightwell-gpu", "wgpu"]);
    assert_without("lightwell", &["lightwell-runtime"]);
    assert_without("lightwell-runtime", &TOOLS);
    assert_without(
        "lightwell-runtime",
        &["lightwell-game", "lightwell-editor", "lightwell-tools", "lightwell-program"],
    );
    assert_without(
        "lightwell-editor",
        &["lightwell-game", "lightwell-tools", "lightwell-program", "plotters", "nv-flip"],
    );
    assert_without("lightwell-tools", &["lightwell-game", "lightwell-editor", "lightwell-program", "egui_tiles"]);
    assert_without("lightwell-program", &["lightwell-game"]);
}
