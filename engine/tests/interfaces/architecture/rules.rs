//! What imports may not do, tried on sources that are made up for it.

use super::imports::{Import, Module, Sources, cycles};
use std::collections::BTreeSet;

/// Imports against the order of the rooms in a folder (empty: that of the crate), and rooms that the order does not know.
pub fn against(order: &[&str], folder: &str, sources: &Sources) -> Vec<String> {
    let above: Module = folder.split("::").filter(|name| !name.is_empty()).map(str::to_owned).collect();
    let room_of = |module: &Module| module.strip_prefix(&above[..]).and_then(|rest| rest.first()).cloned();
    let place = |room: &String| order.iter().position(|known| known == room);
    let unknown = sources.modules().filter_map(room_of).filter(|room| place(room).is_none());
    let mut wrong: BTreeSet<String> = unknown.map(|room| format!("{room} is in no list of this test")).collect();
    for (from, to) in sources.imports() {
        let (Some(own), Some(other)) = (room_of(&from), room_of(&to)) else { continue };
        if place(&other) > place(&own) {
            wrong.insert(format!("{} imports {}", from.join("::"), to.join("::")));
        }
    }
    wrong.into_iter().collect()
}

/// Reads a list of cycles: a line without indent names a crate's folder, each line below it the files of a cycle.
pub fn read_cycles(text: &str) -> Vec<(String, BTreeSet<String>)> {
    let (mut folder, mut listed) = (String::new(), Vec::new());
    for line in text.lines().filter(|line| !line.is_empty() && !line.starts_with('#')) {
        match line.strip_prefix(' ') {
            Some(files) => listed.push((folder.clone(), files.split_whitespace().map(str::to_owned).collect())),
            None => line.clone_into(&mut folder),
        }
    }
    listed
}

/// Cycles of files within rooms that are not, or not as they are, in the list.
pub fn changed_cycles(sources: &Sources, listed: &[BTreeSet<String>]) -> Vec<String> {
    let within = sources.imports().into_iter().filter(|(from, to)| from.first() == to.first());
    let found = cycles(&within.collect::<BTreeSet<Import>>());
    let found: Vec<BTreeSet<String>> =
        found.into_iter().map(|cycle| cycle.iter().map(|module| module.join("::")).collect()).collect();
    let line = |cycle: &BTreeSet<String>| cycle.iter().cloned().collect::<Vec<_>>().join(" ");
    let new = found.iter().filter(|cycle| !listed.iter().any(|known| cycle.is_subset(known)));
    let new = new.map(|cycle| format!("a new cycle, which must go: {}", line(cycle)));
    let shorter = listed.iter().filter(|known| !found.contains(known)).map(|known| {
        let left = found.iter().filter(|cycle| cycle.is_subset(known)).map(|cycle| format!("\n  {}", line(cycle)));
        format!(
            "fewer files are in the cycle\n  {}\nWrite in place of that line:{}",
            line(known),
            left.collect::<String>()
        )
    });
    new.chain(shorter).collect()
}

/// Sources from paths of modules and their texts.
fn made_up(texts: &[(&str, &str)]) -> Sources {
    let module = |path: &str| path.split("::").filter(|name| !name.is_empty()).map(str::to_owned).collect();
    Sources::of(texts.iter().map(|(path, text)| (module(path), (*text).to_owned())).collect())
}

fn named(imports: &BTreeSet<Import>) -> Vec<String> {
    imports.iter().map(|(from, to)| format!("{} > {}", from.join("::"), to.join("::"))).collect()
}

#[test]
fn an_upward_import_is_found() {
    let ground = ("ground", "use crate::roof::Tile;\npub struct Stone;");
    let texts =
        [("", "pub mod ground;\npub mod roof;"), ground, ("roof", "use crate::ground::Stone;\npub struct Tile;")];
    assert_eq!(against(&["ground", "roof"], "", &made_up(&texts)), ["ground imports roof"]);
    assert_eq!(against(&["roof", "ground"], "", &made_up(&texts)), ["roof imports ground"]);
    assert_eq!(against(&["ground"], "", &made_up(&texts))[1], "roof is in no list of this test");
}

/// A name that a room hands on from above is an import of that room, and one of whoever takes it from there.
#[test]
fn names_that_are_handed_on_count_where_they_are_defined() {
    let texts = [
        ("ground", "pub use crate::roof::Tile;"),
        ("middle", "use crate::ground::Tile;"),
        ("roof", "mod tile;\npub use tile::Tile;"),
        ("roof::tile", "pub struct Tile;"),
    ];
    let sources = made_up(&texts);
    assert_eq!(named(&sources.imports()), ["ground > roof::tile", "middle > roof::tile"]);
    assert_eq!(
        against(&["ground", "middle", "roof"], "", &sources),
        ["ground imports roof::tile", "middle imports roof::tile"]
    );
}

#[test]
fn floors_of_a_room_are_told_apart() {
    let texts = [
        ("house", "mod cellar;\nmod attic;\npub use attic::*;"),
        ("house::cellar", "fn f() { super::Roof; }"),
        ("house::attic", "pub struct Roof;"),
    ];
    assert_eq!(against(&["cellar", "attic"], "house", &made_up(&texts)), ["house::cellar imports house::attic"]);
}

#[test]
fn a_cycle_is_found_and_may_only_shrink() {
    let sources = made_up(&[
        ("room", "mod a;\nmod b;\nmod c;\npub use a::A;"),
        ("room::a", "use super::b::B;\npub struct A;"),
        ("room::b", "use super::A;\npub struct B;\n#[cfg(test)]\nmod tests {\nuse super::super::c::C;\n}"),
        ("room::c", "use super::b::B; // super::a\npub struct C;"),
    ]);
    let cycle = |files: &[&str]| files.iter().map(|file| (*file).to_owned()).collect::<BTreeSet<_>>();
    assert!(changed_cycles(&sources, &[])[0].ends_with("must go: room::a room::b"));
    assert!(changed_cycles(&sources, &[cycle(&["room::a", "room::b"])]).is_empty());
    let shorter = changed_cycles(&sources, &[cycle(&["room::a", "room::b", "room::c"])]);
    assert!(shorter[0].ends_with("in place of that line:\n  room::a room::b"), "{shorter:?}");
    let listed = read_cycles("# why\nengine\n  room::a room::b\n");
    assert_eq!(listed, [("engine".to_owned(), cycle(&["room::a", "room::b"]))]);
}

#[test]
fn paths_are_read_as_rust_reads_them() {
    let sources = made_up(&[
        ("gpu", "pub struct Binding;"),
        ("gpu::graph", "pub struct Graph;"),
        ("render", "use self::indirect::gloss;\nmod tests_of_it;"),
        ("render::frame", "pub struct Frame;"),
        ("render::post", "pub mod mlaa { pub fn declare() {} }"),
        ("render::indirect::sky", "pub use self::Map as Chart;\npub fn map() {}\npub struct Map;"),
        (
            "render::indirect::gloss",
            "use crate::gpu::{Binding, graph::{Graph as G, Handle}};\nuse super::super::frame::Frame; // super::no\n\
             fn f() { crate::render::post::mlaa::declare(super::sky::Chart) }\n#[cfg(test)]\nmod tests {\nuse crate::x;",
        ),
    ]);
    let expected = [
        "render > render::indirect::gloss",
        "render::indirect::gloss > gpu",
        "render::indirect::gloss > gpu::graph",
        "render::indirect::gloss > render::frame",
        "render::indirect::gloss > render::indirect::sky",
        "render::indirect::gloss > render::post",
    ];
    assert_eq!(named(&sources.imports()), expected);
}
