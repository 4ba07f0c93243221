//! Every room imports downwards. A room is a folder or file at the top of a crate; the lists below name the rooms from the
//! ground up, and a room may import only from those before it. The engine's rooms are in four crates and share one list:
//! the crates' sources are read as those of one. Within the engine the same holds of the floors of `files` and the
//! stages of a frame in `render`. Files within a room import each other in no cycle, but for those that `cycles.txt` lists.

mod imports;
mod rules;

use imports::Sources;
use rules::{against, changed_cycles, read_cycles};
use std::path::Path;

/// The rooms of each crate, and of two rooms of the engine, by the folder that holds them.
const ROOMS: [(&str, &str, &[&str]); 8] = [
    ("engine", "", &ENGINE),
    ("engine", "files", &["error", "ron", "format", "load", "save", "edit"]),
    ("engine", "render", &RENDER),
    ("game/src", "", &["app", "prelude"]),
    ("game/runtime/src", "", &RUNTIME),
    ("game/editor/src", "", &["comparison", "editor", "play"]),
    ("game/tools/src", "", &TOOLS),
    ("game/program/src", "", &["shipped", "cli", "play", "main"]),
];

/// Sources of the crates that the engine consists of.
const ENGINE_SOURCES: [&str; 4] = ["engine/core/src", "engine/gpu/src", "engine/world/src", "engine/src"];

/// From what all share up to games and frames.
const ENGINE: [&str; 13] = [
    "core", "packed", "profile", "measure", "bvh", "gpu", "graph", "assets", "world", "files", "scene", "game",
    "render",
];

/// From what prints and names scenes up to whole sessions.
const RUNTIME: [&str; 14] = [
    "logging",
    "output",
    "progress",
    "scene_path",
    "writer",
    "watch",
    "window_figures",
    "frame_budget",
    "window",
    "steps",
    "set",
    "cli",
    "session",
    "probe_light",
];

/// From single images up to commands.
const TOOLS: [&str; 12] = [
    "cli",
    "jitter",
    "capture",
    "still",
    "shot",
    "sequence",
    "scene_test",
    "bench",
    "sheet",
    "stress",
    "pack",
    "commands",
];

/// The parts of a frame: what is shared, the stages in their order, and what puts them together.
const RENDER: [&str; 27] = [
    "debug_settings",
    "settings",
    "scene_gpu",
    "rays",
    "error",
    "views",
    "motion",
    "pixel_shift",
    "surfaces",
    "light_steps",
    "history",
    "zero_texture",
    "frame",
    "geometry",
    "shadows",
    "direct",
    "indirect",
    "sky",
    "haze",
    "transparency",
    "post",
    "debug",
    "probe_light",
    "custom_passes",
    "frame_graph",
    "renderer",
    "layout_tests",
];

fn sources(folder: &str) -> Sources {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let folders = if folder == "engine" { &ENGINE_SOURCES[..] } else { &[folder] };
    Sources::read(folders.iter().map(|folder| root.join(folder)))
}

#[test]
fn rooms_import_from_those_before() {
    for (folder, within, order) in ROOMS {
        let wrong = against(order, within, &sources(folder));
        assert!(wrong.is_empty(), "{folder}/{within}, whose order is {order:?}:\n{}", wrong.join("\n"));
    }
}

#[test]
fn cycles_of_files_only_become_fewer() {
    let listed = read_cycles(include_str!("architecture/cycles.txt"));
    let mut folders: Vec<&str> = ROOMS.map(|(folder, ..)| folder).to_vec();
    folders.dedup();
    let changed: Vec<String> = folders
        .into_iter()
        .flat_map(|folder| {
            let listed = listed.iter().filter(|(crate_of, _)| crate_of == folder).map(|(_, files)| files.clone());
            let changed = changed_cycles(&sources(folder), &listed.collect::<Vec<_>>());
            changed.into_iter().map(move |change| format!("{folder}: {change}"))
        })
        .collect();
    assert!(changed.is_empty(), "engine/tests/interfaces/architecture/cycles.txt:\n{}", changed.join("\n"));
}

#[test]
fn the_page_that_shows_the_way_names_what_is_there() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    for page in ["docs/find-your-way.md", "docs/frame.md", "docs/tests.md"] {
        let text = std::fs::read_to_string(root.join(page)).expect("the page");
        let quoted = text.split('`').skip(1).step_by(2);
        let tops = ["engine", "game", "shaders", "scenes", "prefabs", "tests", "docs"];
        let named = quoted.filter(|name| tops.contains(&name.split('/').next().unwrap_or_default()));
        let missing: Vec<&str> = named.filter(|name| !root.join(name).exists()).collect();
        assert!(missing.is_empty(), "{page} names what is not there: {missing:?}");
    }
}

/// Files of tests: those beside Cargo's targets, and the modules of targets that are folders.
fn files_of_tests(root: &Path) -> Vec<String> {
    let names = |folder: &str| -> Vec<String> {
        let entries = std::fs::read_dir(root.join(folder)).expect("tests");
        entries.map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned()).collect()
    };
    let mut found = Vec::new();
    for folder in ["engine/tests", "game/tests", "game/program/tests", "tests"] {
        for name in names(folder) {
            let path = format!("{folder}/{name}");
            if name.ends_with(".rs") {
                found.push(path);
            } else if let Ok(main) = std::fs::read_to_string(root.join(&path).join("main.rs")) {
                let inside = names(&path);
                // The folder of a module's own modules goes with its file.
                let is_module = |name: &&String| {
                    let is_declared = main.contains(&format!("\nmod {};", name.trim_end_matches(".rs")));
                    is_declared && (name.ends_with(".rs") || !inside.contains(&format!("{name}.rs")))
                };
                found.extend(inside.iter().filter(is_module).map(|name| format!("{path}/{name}")));
            }
        }
    }
    found
}

/// Every file of tests has a row in `docs/tests.md`.
#[test]
fn the_page_of_tests_names_all_files() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let page = std::fs::read_to_string(root.join("docs/tests.md")).expect("the page");
    let (files, named) = (files_of_tests(&root), |path: &String| page.contains(&format!("`{path}`")));
    assert!(files.len() > 50, "{files:?}");
    let missing: Vec<&String> = files.iter().filter(|path| !named(path) && !path.starts_with("tests/fuzz/")).collect();
    assert!(missing.is_empty(), "docs/tests.md has no row for {missing:?}");
}
