//! Data flows one way through the stages of a frame, from geometry to post. The list below names the parts of the renderer
//! from the ground up; a file may import from those that stand before its own.

use std::path::{Path, PathBuf};

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

fn source() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("src")
}

/// All sources below a folder, with the path of their module.
fn modules(folder: &Path, module: &[String]) -> Vec<(Vec<String>, String)> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).expect("the sources") {
        let path = entry.expect("an entry").path();
        let name = path.file_stem().and_then(|name| name.to_str()).expect("a name").to_owned();
        let below = [module, std::slice::from_ref(&name)].concat();
        if path.is_dir() {
            found.extend(modules(&path, &below));
        } else if path.extension().is_some_and(|ending| ending == "rs") && !name.ends_with("tests") {
            let text = std::fs::read_to_string(&path).expect("a source");
            let of = if ["mod", "lib"].contains(&name.as_str()) { module.to_vec() } else { below };
            found.push((of, text));
        }
    }
    found
}

/// The text without comments, and without the tests at its end.
fn code(text: &str) -> String {
    let text = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
    text.lines().map(|line| line.split("//").next().unwrap_or_default()).collect::<Vec<_>>().join("\n")
}

/// Reads a path that may end in a list, and puts all that it names into `found`.
fn read_path<'t>(mut rest: &'t str, prefix: &[String], found: &mut Vec<Vec<String>>) -> &'t str {
    let mut path = prefix.to_vec();
    loop {
        rest = rest.trim_start();
        if let Some(list) = rest.strip_prefix('{') {
            rest = list;
            while let Some(item) = rest.trim_start().chars().next().filter(|c| *c != '}') {
                rest = match item {
                    ',' | '*' => &rest.trim_start()[1..],
                    _ => read_path(rest, &path, found),
                };
            }
            return rest.trim_start().strip_prefix('}').unwrap_or(rest);
        }
        let end = rest.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(rest.len());
        if end == 0 {
            found.push(path);
            return rest.strip_prefix(|_: char| true).unwrap_or(rest);
        }
        path.push(rest[..end].to_owned());
        rest = rest[end..].trim_start();
        // An alias, as in `a as b`, names nothing more.
        match rest.strip_prefix("::") {
            Some(more) => rest = more,
            None => {
                found.push(path);
                let alias = rest.strip_prefix("as ").map(|rest| rest.trim_start_matches(|c: char| c.is_alphanumeric()));
                return alias.unwrap_or(rest);
            }
        }
    }
}

/// What a module imports from its own crate, as paths from the crate's root.
fn imports(module: &[String], text: &str) -> Vec<Vec<String>> {
    let (code, mut found) = (code(text), Vec::new());
    for start in ["crate::", "super::"] {
        for (at, _) in code.match_indices(start) {
            let before = code[..at].chars().next_back();
            if before.is_some_and(|c| c.is_alphanumeric() || c == '_' || c == ':') {
                continue;
            }
            let mut rest = &code[at..];
            let mut base = if start == "crate::" { Vec::new() } else { module.to_vec() };
            rest = rest.strip_prefix("crate::").unwrap_or(rest);
            while let Some(more) = rest.strip_prefix("super::") {
                base.pop();
                rest = more;
            }
            read_path(rest, &base, &mut found);
        }
    }
    found
}

/// Imports against the order of the rooms that lie in `folder`, and rooms that the order does not know.
fn against(order: &[&str], folder: &[&str]) -> Vec<String> {
    let depth = folder.len();
    let place = |path: &[String]| order.iter().position(|room| path.get(depth).is_some_and(|name| name == room));
    let mut wrong = Vec::new();
    for (module, text) in modules(&source(), &[]) {
        let lies_in = |path: &[String]| path.len() > depth && path.iter().zip(folder).all(|(a, b)| a == b);
        if !lies_in(&module) {
            continue;
        }
        let Some(own) = place(&module) else {
            wrong.push(format!("{} is in no list of this test", module.join("::")));
            continue;
        };
        for import in imports(&module, &text).into_iter().filter(|import| lies_in(import)) {
            if place(&import).is_some_and(|other| other > own) {
                wrong.push(format!("{} imports {}", module.join("::"), import.join("::")));
            }
        }
    }
    wrong.sort();
    wrong.dedup();
    wrong
}

#[test]
fn stages_of_a_frame_import_from_those_before() {
    let wrong = against(&RENDER, &["render"]);
    assert!(wrong.is_empty(), "against {RENDER:?}:\n{}", wrong.join("\n"));
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

#[test]
fn paths_are_read_as_rust_reads_them() {
    let module = ["render", "indirect", "gloss"].map(str::to_owned);
    let text = "use crate::gpu::{Binding, graph::{Graph as G, Handle}};\nuse super::super::frame::Frame; // super::no\n\
                fn f() { crate::render::post::mlaa::declare(super::sky_reflection::map()) }\n#[cfg(test)]\nmod tests {\nuse crate::x;";
    let found: Vec<String> = imports(&module, text).iter().map(|path| path.join("::")).collect();
    let expected = [
        "gpu::Binding",
        "gpu::graph::Graph",
        "gpu::graph::Handle",
        "render::post::mlaa::declare",
        "render::frame::Frame",
        "render::indirect::sky_reflection::map",
    ];
    assert_eq!(found, expected);
}
