//! README, contributor's guide and book hold together: every page is listed, every link, anchor and image is there, and
//! every block of Rust is compiled somewhere.

use lightwell_tests::root;
use pulldown_cmark::{CodeBlockKind, Event, Options, Parser, Tag, TagEnd};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// What stands beside the book.
const OUTSIDE: [&str; 3] = ["README.md", "CONTRIBUTING.md", "CHANGELOG.md"];
/// Folders whose Rust files `cargo test` compiles.
const COMPILED: [&str; 4] = ["engine/tests", "game/tests", "game/examples", "tests"];

fn read(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// All files with that ending below a folder.
fn files(folder: &Path, ending: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            found.extend(files(&path, ending));
        } else if path.extension().is_some_and(|extension| extension == ending) {
            found.push(path);
        }
    }
    found.sort();
    found
}

/// The pages of the book, without its summary and without what mdBook has built.
fn pages() -> Vec<PathBuf> {
    let docs = root().join("docs");
    let found = files(&docs, "md");
    found.into_iter().filter(|path| *path != docs.join("SUMMARY.md") && !path.starts_with(docs.join("build"))).collect()
}

/// What a Markdown text holds.
#[derive(Default)]
struct Page {
    /// Where links and images lead.
    targets: Vec<String>,
    /// Names that links can jump to.
    anchors: BTreeSet<String>,
    /// Blocks of code, with the words after their fence.
    code: Vec<(String, String)>,
}

impl Page {
    fn parse(text: &str) -> Self {
        let mut page = Self::default();
        let (mut heading, mut code): (Option<String>, Option<(String, String)>) = (None, None);
        let mut count = BTreeMap::<String, usize>::new();
        for event in Parser::new_ext(text, Options::ENABLE_TABLES) {
            match event {
                Event::Start(Tag::Link { dest_url, .. } | Tag::Image { dest_url, .. }) => {
                    page.targets.push(dest_url.into_string());
                }
                Event::Start(Tag::Heading { .. }) => heading = Some(String::new()),
                Event::End(TagEnd::Heading(_)) => {
                    let name = anchor(&heading.take().unwrap_or_default());
                    let before = count.entry(name.clone()).or_default();
                    page.anchors.insert(if *before == 0 { name } else { format!("{name}-{before}") });
                    *before += 1;
                }
                Event::Start(Tag::CodeBlock(kind)) => {
                    let words =
                        if let CodeBlockKind::Fenced(words) = kind { words.into_string() } else { String::new() };
                    code = Some((words, String::new()));
                }
                Event::End(TagEnd::CodeBlock) => page.code.extend(code.take()),
                Event::Text(text) | Event::Code(text) => {
                    if let Some((_, code)) = &mut code {
                        code.push_str(&text);
                    } else if let Some(heading) = &mut heading {
                        heading.push_str(&text);
                    }
                }
                _ => {}
            }
        }
        page
    }
}

/// The name of a heading in links, as mdBook and GitHub make it.
fn anchor(heading: &str) -> String {
    let name = heading.trim().to_lowercase();
    let kept = name.chars().filter(|c| c.is_alphanumeric() || c.is_whitespace() || ['-', '_'].contains(c));
    kept.map(|c| if c.is_whitespace() { '-' } else { c }).collect()
}

#[test]
fn the_summary_lists_every_page_once() {
    let summary = Page::parse(&read(&root().join("docs/SUMMARY.md")));
    let listed: Vec<PathBuf> = summary.targets.iter().map(|target| root().join("docs").join(target)).collect();
    let once: BTreeSet<&PathBuf> = listed.iter().collect();
    assert_eq!(once.len(), listed.len(), "a page is listed twice");
    let pages = pages();
    let pages: BTreeSet<&PathBuf> = pages.iter().collect();
    let missing: Vec<_> = pages.difference(&once).collect();
    let lost: Vec<_> = once.difference(&pages).collect();
    assert!(missing.is_empty() && lost.is_empty(), "not in SUMMARY.md: {missing:?}; not there: {lost:?}");
}

#[test]
fn links_anchors_and_pictures_lead_somewhere() {
    let docs = root().join("docs");
    let mut wrong = Vec::new();
    let mut count = 0;
    for path in OUTSIDE.iter().map(|name| root().join(name)).chain([docs.join("SUMMARY.md")]).chain(pages()) {
        let page = Page::parse(&read(&path));
        for target in page.targets.iter().filter(|target| !target.contains("://")) {
            count += 1;
            let (file, name) = target.split_once('#').unwrap_or((target, ""));
            let to = if file.is_empty() { path.clone() } else { path.parent().unwrap_or(&docs).join(file) };
            // The built book holds nothing but what lies in its folder.
            let leaves = path.starts_with(&docs) && (file.starts_with("..") || file.starts_with('/'));
            let knows = |to: &Path| name.is_empty() || Page::parse(&read(to)).anchors.contains(name);
            if leaves || !to.exists() || !knows(&to) {
                wrong.push(format!("{}: {target}", path.display()));
            }
        }
    }
    assert!(count > 50, "{count} links");
    assert!(wrong.is_empty(), "these lead nowhere:\n{}", wrong.join("\n"));
}

#[test]
fn every_picture_of_the_book_is_shown() {
    let docs = root().join("docs");
    let shown: BTreeSet<PathBuf> = OUTSIDE
        .iter()
        .map(|name| root().join(name))
        .chain(pages())
        .flat_map(|path| {
            let folder = path.parent().unwrap_or(&docs).to_owned();
            Page::parse(&read(&path)).targets.into_iter().map(move |target| folder.join(target))
        })
        .collect();
    let lost: Vec<_> = files(&docs, "png")
        .into_iter()
        .filter(|path| !path.starts_with(docs.join("build")) && !shown.contains(path))
        .collect();
    assert!(lost.is_empty(), "no page shows {lost:?}");
}

#[test]
fn the_readme_is_short() {
    let readme = read(&root().join("README.md"));
    let lines = readme.lines().count();
    assert!(lines <= 200, "README.md has {lines} lines");
    let guide = read(&root().join("CONTRIBUTING.md")).lines().count();
    assert!(guide <= 80, "CONTRIBUTING.md has {guide} lines");
    let wide = readme.lines().filter(|line| line.chars().count() > 120).collect::<Vec<_>>();
    assert!(wide.is_empty(), "more than 120 columns: {wide:?}");
}

/// Lines without what stands before and behind them: code in a test is indented.
fn bare(text: &str) -> String {
    text.trim().lines().map(|line| format!("{}\n", line.trim())).collect()
}

/// A block that is fenced as `rust` stands in a file that is compiled, line by line. What cannot be compiled is fenced as
/// `rust,ignore`, and what is no Rust otherwise.
#[test]
fn rust_of_readme_and_book_is_compiled() {
    let compiled: Vec<String> =
        COMPILED.iter().flat_map(|folder| files(&root().join(folder), "rs")).map(|path| bare(&read(&path))).collect();
    let (mut wrong, mut count) = (Vec::new(), 0);
    for path in OUTSIDE.iter().map(|name| root().join(name)).chain(pages()) {
        for (words, code) in Page::parse(&read(&path)).code {
            if words.is_empty() {
                wrong.push(format!("{}: a block without a language: {}", path.display(), code.trim()));
            }
            if words == "rust" {
                count += 1;
                if !compiled.iter().any(|file| file.contains(&bare(&code))) {
                    wrong.push(format!("{}: no compiled file holds\n{code}", path.display()));
                }
            }
        }
    }
    assert!(count >= 4, "{count} blocks");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn the_history_names_all_results() {
    let page = read(&root().join("docs/results.md"));
    let results = root().join("tests/results");
    let named: BTreeSet<String> = page
        .lines()
        .filter_map(|line| line.strip_prefix("| `"))
        .filter_map(|line| line.split_once('`'))
        .map(|(name, _)| name.to_owned())
        .collect();
    let there = std::fs::read_dir(results).expect("results").map(|entry| entry.expect("an entry"));
    let there: BTreeSet<String> = there
        .filter(|entry| entry.path().is_dir())
        .map(|entry| entry.file_name().to_string_lossy().into_owned())
        .collect();
    assert_eq!(named, there, "docs/results.md has a row for each folder in tests/results");
}

#[test]
fn pages_are_read_as_markdown_has_them() {
    let page = Page::parse(
        "# A `b` c!\n\n[x](y.md#z) ![p](p.png)\n\n```rust,ignore\nf();\n```\n\n`[no](link)`\n\n## Same\n\n## Same\n",
    );
    assert_eq!(page.targets, ["y.md#z", "p.png"]);
    assert_eq!(page.anchors.iter().map(String::as_str).collect::<Vec<_>>(), ["a-b-c", "same", "same-1"]);
    assert_eq!(page.code, [("rust,ignore".to_owned(), "f();\n".to_owned())]);
}
