//! Nothing outside the folder of a method of indirect light names it, except the registry: lines of code that do are
//! counted by file and compared with `methods.baseline`, whose counts may only fall.
//!
//! `LIGHTWELL_BLESS=1` rewrites the baseline where counts have fallen.

use lightwell_tests::root;
use regex::Regex;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

/// Folders whose Rust is searched. Tests may name methods.
const SOURCES: [&str; 9] = [
    "engine/core/src",
    "engine/gpu/src",
    "engine/world/src",
    "engine/src",
    "game/src",
    "game/runtime/src",
    "game/editor/src",
    "game/tools/src",
    "game/program/src",
];

/// The folders of methods, and where the list of them is.
const OWN: [&str; 7] = [
    "engine/core/src/core/gi_method.rs",
    "engine/src/render/indirect/instant_radiosity/",
    "engine/src/render/indirect/light_culling/",
    "engine/src/render/indirect/light_volumes/",
    "engine/src/render/indirect/methods.rs",
    "engine/src/render/indirect/none.rs",
    "engine/src/render/indirect/path_tracer/",
];

/// Names of methods, of their settings and of their modules.
const NAMES: &str = "\\b(Clpv|SceneClpv|ClpvPlacement|InstantRadiosity|StochasticLightCulling|LightCulling|clpv|vpl|slc|lpv|\
                     light_volumes|instant_radiosity|light_culling)\\b|GiMethod::(NONE|CLPV|VPL|SLC|REFERENCE)\\b";

const BASELINE: &str = "tests/structure/methods.baseline";
const BASELINE_HEAD: &str = "\
# Lines of code outside the folders of the methods of indirect light that name one, by file. Counts may only fall.
# LIGHTWELL_BLESS=1 cargo test --release --workspace --test structure methods:: lowers them.

";

/// Lines of code that name a method, by file.
fn counted() -> BTreeMap<String, usize> {
    let names = Regex::new(NAMES).expect("a pattern");
    let mut counts = BTreeMap::new();
    for folder in SOURCES {
        count_in(&root().join(folder), &names, &mut counts);
    }
    counts
}

fn count_in(folder: &Path, names: &Regex, counts: &mut BTreeMap<String, usize>) {
    for entry in std::fs::read_dir(folder).expect("a folder of sources").flatten() {
        let path = entry.path();
        if path.is_dir() {
            count_in(&path, names, counts);
            continue;
        }
        let name = path.strip_prefix(root()).unwrap_or(&path).to_string_lossy().replace('\\', "/");
        let is_test = name.contains("/tests/") || name.ends_with("tests.rs");
        if is_test || !name.ends_with(".rs") || OWN.iter().any(|own| name.starts_with(own)) {
            continue;
        }
        let text = std::fs::read_to_string(&path).expect("a source file");
        let code = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
        let lines = code.lines().filter(|line| !line.trim_start().starts_with("//") && names.is_match(line)).count();
        if lines > 0 {
            counts.insert(name, lines);
        }
    }
}

fn baseline(text: &str) -> BTreeMap<String, usize> {
    let lines = text.lines().filter(|line| !line.starts_with('#'));
    lines
        .filter_map(|line| line.split_once(' '))
        .filter_map(|(n, file)| Some((file.to_owned(), n.parse().ok()?)))
        .collect()
}

#[test]
fn only_its_folder_and_the_registry_name_a_method() {
    let path = root().join(BASELINE);
    let known = baseline(&std::fs::read_to_string(&path).unwrap_or_default());
    let counts = counted();
    let known_of = |file: &String| known.get(file).copied().unwrap_or(0);
    let risen: Vec<String> = counts
        .iter()
        .filter(|(file, count)| **count > known_of(file))
        .map(|(file, count)| format!("{file}: {count} lines, {} before", known_of(file)))
        .collect();
    assert!(risen.is_empty(), "ask the method by `IndirectMethod` in place of its name:\n{}", risen.join("\n"));
    if known == counts {
        return;
    }
    assert!(std::env::var_os("LIGHTWELL_BLESS").is_some(), "counts have fallen: LIGHTWELL_BLESS=1 writes {BASELINE}");
    let mut text = BASELINE_HEAD.to_owned();
    for (file, count) in &counts {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{count} {file}");
    }
    std::fs::write(&path, text).expect("the baseline is written");
}
