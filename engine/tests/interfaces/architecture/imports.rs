//! The imports of one or more crates, read from their sources: which file takes a name from which.
//!
//! A path is followed through re-exports to the file that defines its last name, so that a `mod.rs` that hands a name
//! on counts for nothing. Tests within the sources are left out.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// A module's path from the root of its crate; the root itself is empty.
pub type Module = Vec<String>;

/// An import: the module that has it, and the module that defines what is imported.
pub type Import = (Module, Module);

/// A source file, read.
struct Source {
    /// Text without comments and tests.
    code: String,
    /// Child modules of tests.
    tests: BTreeSet<String>,
    /// Paths of `use` lines by the name that they give; `*` holds those of whole modules.
    uses: BTreeMap<String, Vec<Module>>,
    /// Names that the file defines itself.
    defined: BTreeSet<String>,
}

/// Sources of one crate, or of several as if they were one.
pub struct Sources(BTreeMap<Module, Source>);

fn is_of_name(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// The text without comments, and without the tests at its end.
fn code(text: &str) -> String {
    let text = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
    text.lines().map(|line| line.split("//").next().unwrap_or_default()).collect::<Vec<_>>().join("\n")
}

/// Reads a path that may end in a list. Puts the names that it gives and the paths of these into `found`.
fn read_path<'t>(mut rest: &'t str, prefix: &[String], found: &mut Vec<(String, Module)>) -> &'t str {
    let mut path = prefix.to_vec();
    loop {
        rest = rest.trim_start();
        if let Some(list) = rest.strip_prefix('{') {
            rest = list;
            while let Some(item) = rest.trim_start().chars().next().filter(|c| *c != '}') {
                rest = match item {
                    ',' => &rest.trim_start()[1..],
                    _ => read_path(rest, &path, found),
                };
            }
            return rest.trim_start().strip_prefix('}').unwrap_or(rest);
        }
        let end = rest.find(|c: char| !is_of_name(c)).unwrap_or(rest.len());
        if end == 0 {
            let is_glob = rest.starts_with('*');
            let name = if is_glob { "*" } else { path.last().map_or("", String::as_str) };
            found.push((name.to_owned(), path));
            return rest.strip_prefix(|c: char| c != '}' && c != ',').unwrap_or(rest);
        }
        // `self` in a list is the module before the list.
        if &rest[..end] != "self" {
            path.push(rest[..end].to_owned());
        }
        rest = rest[end..].trim_start();
        match rest.strip_prefix("::") {
            Some(more) => rest = more,
            None => {
                let mut name = path.last().cloned().unwrap_or_default();
                if let Some(alias) = rest.strip_prefix("as ") {
                    let end = alias.find(|c: char| !is_of_name(c)).unwrap_or(alias.len());
                    name = alias[..end].to_owned();
                    rest = &alias[end..];
                }
                found.push((name, path));
                return rest;
            }
        }
    }
}

/// Reads a path that begins with `crate`, `super` or `self`; `None` for another.
fn read_rooted(module: &[String], text: &str, found: &mut Vec<(String, Module)>) -> Option<()> {
    let mut base = module.to_vec();
    let mut rest = text;
    if let Some(more) = rest.strip_prefix("crate::") {
        base.clear();
        rest = more;
    } else if let Some(more) = rest.strip_prefix("self::") {
        rest = more;
    } else if !rest.starts_with("super::") {
        return None;
    }
    while let Some(more) = rest.strip_prefix("super::") {
        base.pop();
        rest = more;
    }
    read_path(rest, &base, found);
    Some(())
}

/// Positions at which a path begins with `start`.
fn starts<'t>(code: &'t str, start: &'t str) -> impl Iterator<Item = usize> + 't {
    let begins = |at: &usize| {
        let before = &code[..*at];
        let is_inside = before.chars().next_back().is_some_and(|c| is_of_name(c) || c == ':' || c == '$');
        // The module that a visibility names is no import.
        !is_inside && !before.ends_with("pub(in ")
    };
    code.match_indices(start).map(|(at, _)| at).filter(begins)
}

impl Source {
    fn new(module: &[String], text: &str) -> Self {
        let code = code(text);
        let (mut uses, mut defined) = (BTreeMap::<String, Vec<Module>>::new(), BTreeSet::new());
        for at in starts(&code, "use ") {
            let (text, mut found) = (code[at + 4..].trim_start(), Vec::new());
            if read_rooted(module, text, &mut found).is_none() {
                read_path(text, module, &mut found);
            }
            found.into_iter().for_each(|(name, path)| uses.entry(name).or_default().push(path));
        }
        for word in ["struct", "enum", "union", "trait", "type", "fn", "const", "static", "mod", "macro_rules!"] {
            for at in starts(&code, word) {
                let rest = &code[at + word.len()..];
                let name = rest.trim_start();
                let end = name.find(|c: char| !is_of_name(c)).unwrap_or(name.len());
                let is_file = word == "mod" && name[end..].starts_with(';');
                if name.len() < rest.len() && end > 0 && !is_file {
                    defined.insert(name[..end].to_owned());
                }
            }
        }
        let mut tests = BTreeSet::new();
        for (at, start) in code.match_indices("#[cfg(test)]\n") {
            let line = code[at + start.len()..].lines().next().unwrap_or_default();
            if let Some((_, name)) = line.split_once("mod ").filter(|(_, name)| name.ends_with(';')) {
                tests.insert(name.trim_end_matches(';').to_owned());
            }
        }
        Self { code, tests, uses, defined }
    }

    /// Paths that the file names, besides names that it hands on from its children.
    fn paths(&self, module: &[String], children: &[String]) -> Vec<Module> {
        let mut found = Vec::new();
        for start in ["crate::", "super::", "self::"] {
            for at in starts(&self.code, start) {
                let mut named = Vec::new();
                read_rooted(module, &self.code[at..], &mut named);
                let is_own = |path: &Module| path.starts_with(module) && is_handed_on(&self.code[..at]);
                found.extend(named.into_iter().map(|(_, path)| path).filter(|path| !is_own(path)));
            }
        }
        for child in children {
            for at in starts(&self.code, &format!("{child}::")).filter(|at| !is_handed_on(&self.code[..*at])) {
                let mut named = Vec::new();
                read_path(&self.code[at..], module, &mut named);
                found.extend(named.into_iter().map(|(_, path)| path));
            }
        }
        found
    }
}

/// Whether the code before a path makes it a re-export.
fn is_handed_on(before: &str) -> bool {
    let line = before.rsplit(['\n', ';']).next().unwrap_or_default().trim_start();
    line.starts_with("pub") && line.trim_end().ends_with("use")
}

impl Sources {
    /// Reads all sources below the folders, as if they were one crate.
    pub fn read(folders: impl Iterator<Item = PathBuf>) -> Self {
        let mut texts = Vec::new();
        folders.for_each(|folder| read_folder(&folder, &[], &mut texts));
        Self::of(texts)
    }

    /// Sources from the paths of their modules and their texts.
    pub fn of(texts: Vec<(Module, String)>) -> Self {
        let mut sources: BTreeMap<Module, Source> =
            texts.into_iter().map(|(module, text)| (module.clone(), Source::new(&module, &text))).collect();
        let of_tests: Vec<Module> = sources
            .iter()
            .flat_map(|(module, source)| source.tests.iter().map(|name| [module, &[name.clone()][..]].concat()))
            .collect();
        sources.retain(|module, _| !of_tests.iter().any(|tests| module.starts_with(tests)));
        // Paths without a root may also begin with the name of another crate.
        let modules: BTreeSet<Module> = sources.keys().cloned().collect();
        for (module, source) in &mut sources {
            let is_own = |path: &Module| match path.strip_prefix(&module[..]) {
                Some([first, ..]) => source.defined.contains(first) || modules.contains(&path[..=module.len()]),
                _ => true,
            };
            source.uses.values_mut().for_each(|paths| paths.retain(is_own));
        }
        Self(sources)
    }

    /// The modules that are files.
    pub fn modules(&self) -> impl Iterator<Item = &Module> {
        self.0.keys()
    }

    /// The file that defines what a path names.
    fn definer(&self, path: &[String], followed: &mut BTreeSet<Module>) -> Option<Module> {
        if !followed.insert(path.to_vec()) {
            return None;
        }
        let depth = (0..=path.len()).rev().find(|depth| self.0.contains_key(&path[..*depth]))?;
        let (module, rest) = path.split_at(depth);
        let source = &self.0[module];
        let Some(name) = rest.first().filter(|name| !source.defined.contains(*name)) else {
            return Some(module.to_vec());
        };
        let named = source.uses.get(name).into_iter().flatten().map(|path| [path, &rest[1..]].concat());
        let in_whole = source.uses.get("*").into_iter().flatten().map(|path| [path, rest].concat());
        named.chain(in_whole).find_map(|path| self.definer_that_knows(&path, followed))
    }

    /// [`Self::definer`] of a path that begins with a module of the crate.
    fn definer_that_knows(&self, path: &[String], followed: &mut BTreeSet<Module>) -> Option<Module> {
        let is_known = path.first().is_some_and(|room| self.0.contains_key(std::slice::from_ref(room)));
        if is_known { self.definer(path, followed) } else { None }
    }

    /// The imports between files, each once.
    pub fn imports(&self) -> BTreeSet<Import> {
        let mut imports = BTreeSet::new();
        for (module, source) in &self.0 {
            let is_child = |other: &&Module| other.len() == module.len() + 1 && other.starts_with(module);
            let children: Vec<String> =
                self.0.keys().filter(is_child).filter_map(|other| other.last().cloned()).collect();
            for path in source.paths(module, &children) {
                let defined = self.definer(&path, &mut BTreeSet::new());
                let other = defined.unwrap_or_else(|| self.deepest(&path));
                if other != *module {
                    imports.insert((module.clone(), other));
                }
            }
        }
        imports
    }

    /// The module of which a path is known to begin.
    fn deepest(&self, path: &[String]) -> Module {
        (0..=path.len()).rev().map(|depth| path[..depth].to_vec()).find(|m| self.0.contains_key(m)).unwrap_or_default()
    }
}

fn read_folder(folder: &Path, module: &[String], texts: &mut Vec<(Module, String)>) {
    for entry in std::fs::read_dir(folder).expect("the sources") {
        let path = entry.expect("an entry").path();
        let name = path.file_stem().and_then(|name| name.to_str()).expect("a name").to_owned();
        let below = [module, std::slice::from_ref(&name)].concat();
        if path.is_dir() {
            read_folder(&path, &below, texts);
        } else if path.extension().is_some_and(|ending| ending == "rs") {
            let text = std::fs::read_to_string(&path).expect("a source");
            let is_folder = ["mod", "lib"].contains(&name.as_str());
            texts.push((if is_folder { module.to_vec() } else { below }, text));
        }
    }
}

/// The cycles of imports: groups of files of which each reaches all others, in the order of their names.
pub fn cycles(imports: &BTreeSet<Import>) -> Vec<Vec<Module>> {
    let mut next: BTreeMap<&Module, Vec<&Module>> = BTreeMap::new();
    imports.iter().for_each(|(from, to)| next.entry(from).or_default().push(to));
    let reach = |from: &Module| {
        let (mut reached, mut open) = (BTreeSet::new(), vec![from]);
        while let Some(module) = open.pop() {
            for other in next.get(module).into_iter().flatten() {
                if reached.insert((*other).clone()) {
                    open.push(other);
                }
            }
        }
        reached
    };
    let reached: BTreeMap<&Module, BTreeSet<Module>> = next.keys().map(|module| (*module, reach(module))).collect();
    let mut found = BTreeSet::new();
    for (module, others) in reached.iter().filter(|(module, others)| others.contains(**module)) {
        let is_mutual = |other: &&Module| reached.get(other).is_some_and(|back| back.contains(*module));
        found.insert(others.iter().filter(is_mutual).cloned().collect::<Vec<_>>());
    }
    found.into_iter().filter(|group| group.len() > 1).collect()
}
