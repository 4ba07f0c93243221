//! The language of comments and pages: lines that match one of the patterns below are counted by folder and compared
//! with `words.baseline`, whose counts may only fall.
//!
//! `LIGHTWELL_BLESS=1` rewrites the baseline where counts have fallen. A line that ends in `words: allow` and a reason is
//! not counted.

use lightwell_tests::root;
use regex::Regex;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use std::path::PathBuf;
use std::process::Command;

/// Folders that are scanned for Rust and WGSL.
const SOURCES: [&str; 4] = ["engine", "game", "shaders", "tests"];
/// Marks a line that is excused; a reason follows.
const ALLOW: &str = "words: allow";
/// Letters and digits that a reason has at least.
const MIN_REASON: usize = 8;
/// Lines that a failure quotes for each count that has risen.
const MAX_QUOTED: usize = 20;
const BASELINE: &str = "tests/structure/words.baseline";
const BASELINE_HEAD: &str = "\
# Lines of comments and pages that use wording listed in tests/structure/words.rs, by folder and kind.
# Counts may only fall. LIGHTWELL_BLESS=1 cargo test --release --workspace --test structure words:: lowers them.
";

/// A kind of wording that readers stumble over.
struct Kind {
    /// Its column in the baseline.
    letter: char,
    /// Matched against a comment, or a line of Markdown.
    pattern: &'static str,
    /// Whether lines of Markdown are not searched: it is about where a comment begins, or about `Option`.
    only_comments: bool,
    /// Replacement shown in failures.
    instead: &'static str,
}

const KINDS: [Kind; 9] = [
    Kind {
        letter: 'A',
        pattern: r"^\s*//[/!]?\s*What ",
        only_comments: true,
        instead: "begin with a noun, or with a verb in -s: \"Renderer: …\", \"Returns …\"",
    },
    Kind {
        letter: 'B',
        pattern: r"^\s*//[/!]?\s*(Of|As|The same|Likewise)\b|, likewise\.",
        only_comments: false,
        instead: "name the thing: \"Statistics of `times`\", \"Like [`run`], with …\"",
    },
    Kind {
        letter: 'C',
        pattern: r";? ?\bnone(:| if| where| unless)",
        only_comments: true,
        instead: "say `None`: \"`None` if the list is empty\"",
    },
    Kind {
        letter: 'D',
        pattern: r"\banew\b|\b(go|goes|going|gone|went) on\b",
        only_comments: false,
        instead: "again, recompute, rebuild, reload; continue",
    },
    Kind {
        letter: 'E',
        pattern: r"one's own|\bof (its|their|his) own\b",
        only_comments: false,
        instead: "custom, separate, or leave it out",
    },
    Kind {
        letter: 'F',
        // A stand-in is a term.
        pattern: r"\b(stands?|standing|stood|hangs?)([^\w-]|$)",
        only_comments: false,
        instead: "is, has a position, belongs to, descends from",
    },
    Kind {
        letter: 'G',
        pattern: r"\b(met|meets?|brings?|brought)\b|on (its|their|the) way",
        only_comments: false,
        instead: "hit, contribute, load, return; in flight",
    },
    Kind {
        letter: 'H',
        pattern: concat!(
            r"\bso many\b|from (which|there|here|now|then) on\b|\bbut for\b",
            r"|\b(others?|another) than\b|the \w+er the (more|less)",
        ),
        only_comments: false,
        instead: "name the quantity: `count`, above which, except, differs from, grows with",
    },
    Kind {
        letter: 'I',
        pattern: r"\b(told|tells?|shall)\b|\bsays? so\b|\bwants?\b",
        only_comments: false,
        instead: "reports, returns, requests; must, can",
    },
];

/// The compiled patterns of all kinds.
struct Patterns(Vec<Regex>);

impl Patterns {
    fn new() -> Self {
        Self(KINDS.iter().map(|kind| Regex::new(kind.pattern).expect("a valid pattern")).collect())
    }

    /// Indices of the kinds that a comment or a line of Markdown matches.
    fn kinds(&self, text: &str, is_markdown: bool) -> Vec<usize> {
        let applies = |index: &usize| !(is_markdown && KINDS[*index].only_comments);
        (0..KINDS.len()).filter(applies).filter(|index| self.0[*index].is_match(text)).collect()
    }
}

/// The comment of a line of Rust or WGSL with its slashes. Slashes in strings and addresses are not comments.
fn comment(line: &str) -> Option<&str> {
    let mut is_quoted = false;
    let bytes = line.as_bytes();
    for (at, byte) in bytes.iter().enumerate() {
        let before = at.checked_sub(1).map_or(b' ', |at| bytes[at]);
        match byte {
            b'"' if before != b'\\' && before != b'\'' => is_quoted = !is_quoted,
            b'/' if !is_quoted && before != b':' && bytes.get(at + 1) == Some(&b'/') => return line.get(at..),
            _ => {}
        }
    }
    None
}

/// A line that matches a kind.
#[derive(Clone, Debug, PartialEq)]
struct Found {
    kind: usize,
    /// Path from the root.
    file: String,
    /// Counted from 1.
    line: usize,
    text: String,
}

/// Matching lines of a file. Code blocks of Markdown are skipped. An excuse without a reason is an error.
fn scan(patterns: &Patterns, file: &str, text: &str) -> Result<Vec<Found>, String> {
    let is_markdown = file.ends_with(".md");
    let (mut found, mut is_code) = (Vec::new(), false);
    for (number, line) in text.lines().enumerate().map(|(index, line)| (index + 1, line)) {
        if is_markdown && line.trim_start().starts_with("```") {
            is_code = !is_code;
        }
        let prose = if is_markdown { (!is_code).then_some(line) } else { comment(line) };
        let Some(prose) = prose else { continue };
        let kinds = patterns.kinds(prose, is_markdown);
        if kinds.is_empty() {
            continue;
        }
        if let Some((_, reason)) = prose.split_once(ALLOW) {
            if reason.chars().filter(|c| c.is_alphanumeric()).count() < MIN_REASON {
                return Err(format!("{file}:{number}: `{ALLOW}` needs a reason behind it"));
            }
            continue;
        }
        let hit = |kind| Found { kind, file: file.to_owned(), line: number, text: line.trim().to_owned() };
        found.extend(kinds.into_iter().map(hit));
    }
    Ok(found)
}

/// The folder under which a file is counted: a room of the engine's sources, a crate of the game, a folder of shaders.
fn folder(file: &str) -> String {
    let parts: Vec<&str> = file.split('/').collect();
    let depth = match parts[0] {
        "engine" if parts[1] == "src" => 3,
        "engine" if parts.get(2) == Some(&"src") => 4,
        "engine" | "game" | "shaders" => 2,
        _ => 1,
    };
    // A file that is alone beside folders is counted with the folder above it.
    let depth = if depth > 1 && parts.len() <= depth { parts.len() - 1 } else { depth };
    parts[..depth].join("/")
}

/// Files below a folder whose names end so, as paths from the root.
fn files(folder: &str, endings: &[&str]) -> Vec<String> {
    let (mut found, mut open) = (Vec::new(), vec![PathBuf::from(folder)]);
    while let Some(path) = open.pop() {
        let entries =
            std::fs::read_dir(root().join(&path)).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        for entry in entries {
            let entry = entry.expect("an entry");
            let below = path.join(entry.file_name());
            if entry.path().is_dir() {
                open.push(below);
            } else if endings.iter().any(|ending| below.extension().is_some_and(|found| found == *ending)) {
                found.push(
                    below.components().map(|part| part.as_os_str().to_string_lossy()).collect::<Vec<_>>().join("/"),
                );
            }
        }
    }
    found.sort();
    found
}

/// All matching lines of the tree, in the order of files.
fn scan_tree() -> Vec<Found> {
    let patterns = Patterns::new();
    let sources = SOURCES.iter().flat_map(|folder| files(folder, &["rs", "wgsl"]));
    let pages = files("docs", &["md"]).into_iter().filter(|file| !file.starts_with("docs/build/"));
    let (mut found, mut wrong) = (Vec::new(), Vec::new());
    for file in sources.chain(pages).chain(["README.md".to_owned()]) {
        let text = std::fs::read_to_string(root().join(&file)).unwrap_or_else(|error| panic!("{file}: {error}"));
        match scan(&patterns, &file, &text) {
            Ok(lines) => found.extend(lines),
            Err(error) => wrong.push(error),
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    found
}

/// Lines of each kind by folder.
type Counts = BTreeMap<String, [usize; KINDS.len()]>;

fn count(found: &[Found]) -> Counts {
    let mut counts = Counts::new();
    for line in found {
        counts.entry(folder(&line.file)).or_default()[line.kind] += 1;
    }
    counts
}

/// The baseline's text: a table with a row for each folder and a column for each kind.
fn table(counts: &Counts) -> String {
    let width = counts.keys().map(String::len).max().unwrap_or_default().max("folder".len());
    let row = |name: &str, cells: Vec<String>| {
        let cells: String = cells.iter().map(|cell| format!("{cell:>5}")).collect();
        format!("{name:width$}{cells}\n")
    };
    let mut text = format!("{BASELINE_HEAD}\n");
    text += &row("folder", KINDS.iter().map(|kind| kind.letter.to_string()).collect());
    for (folder, counts) in counts {
        text += &row(folder, counts.iter().map(usize::to_string).collect());
    }
    text
}

/// Reads what [`table`] writes; an error names the line that is no row.
fn read_table(text: &str) -> Result<Counts, String> {
    let mut counts = Counts::new();
    let rows = text.lines().filter(|line| !line.starts_with('#') && !line.is_empty() && !line.starts_with("folder"));
    for line in rows {
        let mut words = line.split_whitespace();
        let folder = words.next().ok_or_else(|| format!("no folder in `{line}`"))?;
        let cells: Result<Vec<usize>, _> = words.map(str::parse).collect();
        let cells = cells.ok().and_then(|cells| cells.try_into().ok());
        let cells = cells.ok_or_else(|| format!("`{line}`: not a folder and {} counts", KINDS.len()))?;
        if counts.insert(folder.to_owned(), cells).is_some() {
            return Err(format!("`{folder}` has two rows"));
        }
    }
    Ok(counts)
}

/// Counts that differ, as folder, kind, baseline and present count.
fn differences(baseline: &Counts, present: &Counts) -> Vec<(String, usize, usize, usize)> {
    let folders: BTreeSet<&String> = baseline.keys().chain(present.keys()).collect();
    let of = |counts: &Counts, folder: &String, kind: usize| counts.get(folder).map_or(0, |counts| counts[kind]);
    folders
        .into_iter()
        .flat_map(|folder| (0..KINDS.len()).map(move |kind| (folder, kind)))
        .map(|(folder, kind)| (folder.clone(), kind, of(baseline, folder, kind), of(present, folder, kind)))
        .filter(|(_, _, before, now)| before != now)
        .collect()
}

/// Whether no kind has more lines in all folders together, and no folder has more because of new lines: files may move
/// from folder to folder. A baseline without rows is written whatever is found.
fn may_bless(baseline: &Counts, found: &[Found], added: Option<&BTreeSet<(String, usize)>>) -> bool {
    let present = count(found);
    let total = |counts: &Counts, kind: usize| counts.values().map(|counts| counts[kind]).sum::<usize>();
    let is_new = |line: &Found| added.is_some_and(|added| added.contains(&(line.file.clone(), line.line)));
    let has_new = |name: &str, kind: usize| {
        found.iter().any(|line| line.kind == kind && folder(&line.file) == name && is_new(line))
    };
    let may_rise = |(name, kind, before, now): &(String, usize, usize, usize)| now <= before || !has_new(name, *kind);
    baseline.is_empty()
        || (0..KINDS.len()).all(|kind| total(&present, kind) <= total(baseline, kind))
            && differences(baseline, &present).iter().all(may_rise)
}

/// Output of git in the root; `None` without git, or if it fails.
fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").current_dir(root()).args(arguments).output().ok()?;
    output.status.success().then(|| String::from_utf8_lossy(&output.stdout).into_owned())
}

/// Files and numbers of the lines that were added since the baseline was last committed; `None` outside a repository.
fn added_lines() -> Option<BTreeSet<(String, usize)>> {
    let commit = git(&["log", "-1", "--format=%H", "--", BASELINE])?;
    let diff = git(&["diff", "--unified=0", "--find-renames", "--no-color", "--no-ext-diff", commit.trim()])?;
    let mut added = parse_diff(&diff);
    for file in git(&["ls-files", "--others", "--exclude-standard"])?.lines() {
        let lines = std::fs::read_to_string(root().join(file)).map_or(0, |text| text.lines().count());
        added.extend((1..=lines).map(|line| (file.to_owned(), line)));
    }
    Some(added)
}

/// Files and numbers of the lines that a diff without context adds.
fn parse_diff(diff: &str) -> BTreeSet<(String, usize)> {
    let (mut added, mut file) = (BTreeSet::new(), "");
    for line in diff.lines() {
        if let Some(path) = line.strip_prefix("+++ b/") {
            file = path;
        } else if let Some(range) = line.strip_prefix("@@ ").and_then(|rest| rest.split(['+', ' ']).nth(2)) {
            let (start, count) = range.split_once(',').unwrap_or((range, "1"));
            let (Ok(start), Ok(count)) = (start.parse::<usize>(), count.parse::<usize>()) else { continue };
            added.extend((start..start + count).map(|line| (file.to_owned(), line)));
        }
    }
    added
}

/// Quotes the lines of a kind in a folder: those that are new, or all if that is unknown.
fn quote(found: &[Found], folder_name: &str, kind: usize, added: Option<&BTreeSet<(String, usize)>>) -> String {
    let of_kind = || found.iter().filter(|line| line.kind == kind && folder(&line.file) == folder_name);
    let is_new = |line: &&Found| added.is_some_and(|added| added.contains(&(line.file.clone(), line.line)));
    let mut lines: Vec<&Found> = of_kind().filter(is_new).collect();
    if lines.is_empty() {
        lines = of_kind().collect();
    }
    let mut text = String::new();
    for line in lines.iter().take(MAX_QUOTED) {
        let _ = writeln!(text, "  {}:{}: {}", line.file, line.line, line.text);
    }
    if lines.len() > MAX_QUOTED {
        let _ = writeln!(text, "  and {} more", lines.len() - MAX_QUOTED);
    }
    text
}

/// The failure's message: each count that has risen with its new lines, and each that has fallen.
fn report(found: &[Found], differences: &[(String, usize, usize, usize)]) -> String {
    let added = added_lines();
    let mut text = String::new();
    for (folder, kind, before, now) in differences.iter().filter(|(_, _, before, now)| now > before) {
        let Kind { letter, pattern, instead, .. } = &KINDS[*kind];
        let _ = writeln!(text, "{folder}: {now} lines of kind {letter}, at most {before}: `{pattern}`");
        let _ = writeln!(text, "  write in its place: {instead}");
        text += &quote(found, folder, *kind, added.as_ref());
    }
    for (folder, kind, before, now) in differences.iter().filter(|(_, _, before, now)| now < before) {
        let letter = KINDS[*kind].letter;
        let _ = writeln!(text, "{folder}: kind {letter} has fallen from {before} to {now}: lower the baseline");
    }
    text
}

#[test]
fn wording_gets_no_worse() {
    let found = scan_tree();
    let present = count(&found);
    let path = root().join(BASELINE);
    let text = std::fs::read_to_string(&path).unwrap_or_default();
    let baseline = read_table(&text).unwrap_or_else(|error| panic!("{BASELINE}: {error}"));
    let differences = differences(&baseline, &present);
    if std::env::var_os("LIGHTWELL_BLESS").is_some() && may_bless(&baseline, &found, added_lines().as_ref()) {
        std::fs::write(&path, table(&present)).expect("the baseline is written");
        return;
    }
    assert!(
        differences.is_empty(),
        "{}\nWhere a count has risen, change the lines, or end them with `{ALLOW}` and a reason. LIGHTWELL_BLESS=1 \
         rewrites {BASELINE} where counts have fallen or files have moved.",
        report(&found, &differences)
    );
    assert_eq!(text, table(&present), "{BASELINE} is not written as LIGHTWELL_BLESS=1 writes it");
}

/// Asserts that a comment matches the kind of that letter, and that its plain form matches nothing.
fn assert_found(letter: char, found: &str, better: &str) {
    let patterns = Patterns::new();
    let letters = |text: &str| -> String {
        patterns.kinds(&format!("/// {text}"), false).into_iter().map(|kind| KINDS[kind].letter).collect()
    };
    assert!(letters(found).contains(letter), "{letter} is not found in `{found}`, only `{}`", letters(found));
    assert_eq!(letters(better), "", "`{better}`");
}

#[test]
fn each_kind_is_found_and_its_plain_form_is_not() {
    for (letter, found, better) in [
        ('A', "What redo would do again.", "Label of the step that redo would apply."),
        ('A', "What a camera makes of the light that it sees.", "Lens and display response of a camera."),
        ('A', "What the other cameras see.", "Frusta of the other cameras."),
        ('B', "Of that, what hides what lies behind.", "Selects opaque batches in the frustum."),
        ('B', "Of a set of times; none of an empty one.", "Statistics of `times`; `None` if it is empty."),
        ('B', "The text of a prefab file, likewise.", "Serializes a prefab file."),
        ('B', "As they are.", "Uncompressed 32-bit corners."),
        ('B', "The same with a command line of one's own.", "Like [`run`], with explicit arguments."),
        ('C', "Tone map in place of the camera's; none: the camera's.", "Overrides the camera's tone map."),
        ('C', "alpha if it is blended; none if that is none.", "…; `None` if that share is zero."),
        ('D', "without haze: rays find that anew.", "without haze, which refracted rays evaluate themselves."),
        ('D', "Rays that always go on.", "Bounces before Russian roulette."),
        ('E', "A game of one's own: components and a scene", "A game: components, systems, a scene"),
        ('E', "moving boxes with a hierarchy of their own", "moving boxes with a separate hierarchy"),
        ('F', "Whether it stands somewhere.", "Whether it has a position."),
        ('F', "one node with what hangs on it", "one node with its descendants"),
        ('G', "of which each brings what it emits", "each returns the radiance leaving its hit point"),
        ('G', "what a ray of the visible surface has met", "MIS weight of a light sample at the hit point"),
        ('G', "How precisely light is kept on its way", "Number format of radiance in flight"),
        ('H', "That triangle in so many parts.", "Splits the triangle into `parts`."),
        ('H', "reflects from which on light says little.", "Specular share above which it is a poor estimate."),
        ('H', "where surfels are others than before", "Incremented when indices of surfels change meaning."),
        ('H', "it is the narrower the more there are", "more images narrow it"),
        ('H', "slow, and right but for noise", "slow; unbiased"),
        ('I', "Shear is not kept, and the library tells so", "Shear is dropped with a warning"),
        ('I', "A file that shall take its place.", "Writes the replacement with the original's permissions."),
        ('I', "What the panels are told of it.", "Data for the panels."),
    ] {
        assert_found(letter, found, better);
    }
    let letters: String = KINDS.iter().map(|kind| kind.letter).collect();
    assert_eq!(letters, "ABCDEFGHI");
}

#[test]
fn comments_are_separated_from_code_and_strings() {
    for (line, expected) in [
        ("    /// Doc.", Some("/// Doc.")),
        ("let x = 1; // Why.", Some("// Why.")),
        ("let x = \"// no\"; // Why.", Some("// Why.")),
        ("let x = \"\\\"// no\";", None),
        ("let quote = '\"'; // Why.", Some("// Why.")),
        ("https://example.org", None),
        ("let meets = half / 2;", None),
    ] {
        assert_eq!(comment(line), expected, "{line}");
    }
}

#[test]
fn lines_are_found_with_their_place() {
    let patterns = Patterns::new();
    let places = |file: &str, text: &str| -> Vec<(char, usize)> {
        let found = scan(&patterns, file, text).expect("no excuse without a reason");
        found.iter().map(|line| (KINDS[line.kind].letter, line.line)).collect()
    };
    let rust = "fn met() {}\n/// What met it.\nlet told = 1; // It stands.\n";
    assert_eq!(places("a.rs", rust), [('A', 2), ('G', 2), ('F', 3)]);
    let page = "What stands here\n```rust\n// It hangs.\n```\n// What is it\nIt goes on.\n";
    assert_eq!(places("a.md", page), [('F', 1), ('D', 6)]);
    assert_eq!(places("a.wgsl", "// It meets. words: allow: lines meet in geometry\n"), []);
    assert!(
        scan(&patterns, "a.wgsl", "// It meets. words: allow\n").is_err_and(|error| error.starts_with("a.wgsl:1:"))
    );
}

#[test]
fn files_are_counted_by_folder() {
    for (file, expected) in [
        ("engine/src/render/post/bloom.rs", "engine/src/render"),
        ("engine/src/lib.rs", "engine/src"),
        ("engine/world/src/files/load/mod.rs", "engine/world/src/files"),
        ("engine/gpu/src/lib.rs", "engine/gpu/src"),
        ("engine/tests/invariants/main.rs", "engine/tests"),
        ("game/editor/src/ui/mod.rs", "game/editor"),
        ("shaders/build.rs", "shaders"),
        ("shaders/post/bloom.wgsl", "shaders/post"),
        ("tests/structure/words.rs", "tests"),
        ("docs/frame.md", "docs"),
        ("README.md", "README.md"),
    ] {
        assert_eq!(folder(file), expected);
    }
}

#[test]
fn tables_are_read_back_and_compared() {
    let counts = |rows: &[(&str, usize, usize)]| -> Counts {
        let mut counts = Counts::new();
        rows.iter().for_each(|(folder, kind, count)| counts.entry((*folder).to_owned()).or_default()[*kind] = *count);
        counts
    };
    let baseline = counts(&[("docs", 0, 3), ("docs", 8, 12), ("engine/src/a", 1, 2)]);
    assert_eq!(read_table(&table(&baseline)), Ok(baseline.clone()));
    assert!(read_table("docs 1 2\n").is_err());
    assert!(differences(&baseline, &baseline).is_empty());
    let present = counts(&[("docs", 0, 4), ("docs", 8, 12), ("new", 2, 1)]);
    let expected = [("docs", 0, 3, 4), ("engine/src/a", 1, 2, 0), ("new", 2, 0, 1)];
    assert_eq!(differences(&baseline, &present), expected.map(|(folder, kind, a, b)| (folder.to_owned(), kind, a, b)));
}

#[test]
fn baselines_are_rewritten_where_counts_fall_or_files_move() {
    let line = |file: &str| Found { kind: 0, file: file.into(), line: 3, text: String::new() };
    let baseline = count(&[line("docs/a.md"), line("docs/b.md")]);
    let added = BTreeSet::from([("game/src/b.rs".to_owned(), 3)]);
    assert!(may_bless(&baseline, &[line("docs/a.md")], Some(&added)), "fewer lines");
    assert!(!may_bless(&baseline, &[line("docs/a.md"), line("docs/b.md"), line("docs/c.md")], None), "more lines");
    let moved = [line("docs/a.md"), line("game/src/b.rs")];
    assert!(may_bless(&baseline, &moved, None) && may_bless(&baseline, &moved, Some(&BTreeSet::new())));
    assert!(!may_bless(&baseline, &moved, Some(&added)), "a new line in place of one elsewhere");
    assert!(may_bless(&Counts::new(), &moved, Some(&added)), "there is no baseline");
}

#[test]
fn failures_quote_new_lines_with_their_place_and_the_words_to_use() {
    let line = |line: usize| Found { kind: 5, file: "docs/a.md".into(), line, text: format!("It stands {line}.") };
    let found = [line(1), line(7)];
    let diff = "--- a/docs/a.md\n+++ b/docs/a.md\n@@ -6,0 +7,2 @@ head\n+It stands 7.\n@@ -9 +11 @@\n";
    let added = parse_diff(diff);
    let expected = [7, 8, 11].map(|line| ("docs/a.md".to_owned(), line));
    assert_eq!(added.iter().cloned().collect::<Vec<_>>(), expected);
    assert_eq!(quote(&found, "docs", 5, Some(&added)), "  docs/a.md:7: It stands 7.\n");
    assert_eq!(quote(&found, "docs", 5, None).lines().count(), 2);
    let text = report(&found, &[("docs".into(), 5, 1, 2), ("tests".into(), 0, 3, 1)]);
    assert!(text.contains("docs: 2 lines of kind F, at most 1") && text.contains("has a position"), "{text}");
    assert!(text.contains("tests: kind A has fallen from 3 to 1: lower the baseline"), "{text}");
}
