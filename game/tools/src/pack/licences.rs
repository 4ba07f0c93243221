//! The licences of all libraries that a program is made of.

use super::program::{self, Program, bare_cargo, cargo, output};
use crate::cli::PackArgs;
use anyhow::{Context, Result};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Beginnings of the names of files that hold licences.
const NAMES: [&str; 8] = ["licen", "copying", "copyright", "notice", "unlicense", "ofl", "ufl", "authors"];
/// Endings of such files.
const ENDINGS: [&str; 3] = ["txt", "md", "rst"];

/// A library.
struct Library {
    name: String,
    version: String,
    licence: String,
    folder: PathBuf,
    /// Whether it lies in a source tree, whose top may hold the licence.
    is_local: bool,
}

/// The table of libraries, and after it each text once.
///
/// # Errors
/// If cargo cannot tell what the program is made of.
pub fn text(args: &PackArgs, program: &Program) -> Result<String> {
    let libraries = libraries(args)?;
    let mut text = format!("{} is made of these libraries. The texts of their licences follow.\n\n", program.name);
    let mut texts = BTreeMap::<String, BTreeSet<&str>>::new();
    for library in &libraries {
        text += &format!("{} {}: {}\n", library.name, library.version, library.licence);
        for found in texts_of(library) {
            texts.entry(found).or_default().insert(&library.name);
        }
    }
    for (licence, names) in &texts {
        let names: Vec<&str> = names.iter().copied().collect();
        text += &format!("\n{}\n{}\n\n{}\n", "=".repeat(80), names.join(", "), licence.trim_end());
    }
    Ok(text)
}

/// All libraries within the program, on this system.
fn libraries(args: &PackArgs) -> Result<Vec<Library>> {
    let mut tree = cargo(args, "tree");
    tree.args(["--edges", "normal,no-proc-macro", "--prefix", "none", "--format", "{p}"]);
    let package = args.package.clone().map_or_else(|| owner(args), |name| Ok(Some(name)))?;
    if let Some(package) = package {
        tree.args(["--package", &package]);
    }
    if let Some(features) = &args.features {
        tree.args(["--features", features]);
    }
    let tree = output(&mut tree)?;
    let used: BTreeSet<(&str, &str)> = tree
        .lines()
        .filter_map(|line| line.split_once(' '))
        .map(|(name, rest)| (name, rest.split(' ').next().unwrap_or_default().trim_start_matches('v')))
        .collect();
    // Libraries for other systems need not be here.
    let host = output(bare_cargo("--version").arg("--verbose"))?;
    let host = host.lines().find_map(|line| line.strip_prefix("host: ")).context("cargo does not name this system")?;
    let mut all = cargo(args, "metadata");
    all.args(["--format-version", "1", "--filter-platform", host]);
    if let Some(features) = &args.features {
        all.args(["--features", features]);
    }
    let all = output(&mut all)?;
    let all: Value = serde_json::from_str(&all).context("cargo metadata cannot be read")?;
    let packages = all["packages"].as_array().map(Vec::as_slice).unwrap_or_default();
    let mut libraries: Vec<Library> = packages
        .iter()
        .filter_map(library)
        .filter(|library| used.contains(&(library.name.as_str(), library.version.as_str())))
        .collect();
    libraries.sort_by(|a, b| (&a.name, &a.version).cmp(&(&b.name, &b.version)));
    Ok(libraries)
}

/// The package that holds the example or program that is packed.
fn owner(args: &PackArgs) -> Result<Option<String>> {
    let Some(target) = args.example.as_ref().or(args.bin.as_ref()) else { return Ok(None) };
    let workspace = program::workspace(args)?;
    let holds = |package: &&Value| {
        package["targets"].as_array().into_iter().flatten().any(|found| found["name"] == target.as_str())
    };
    let package = workspace["packages"].as_array().into_iter().flatten().find(holds);
    Ok(package.and_then(|package| package["name"].as_str()).map(str::to_owned))
}

fn library(package: &Value) -> Option<Library> {
    let text = |key: &str| package[key].as_str().map(str::to_owned);
    let folder = Path::new(package["manifest_path"].as_str()?).parent()?.to_owned();
    Some(Library {
        name: text("name")?,
        version: text("version")?,
        licence: text("license").unwrap_or_else(|| "see its text".to_owned()),
        folder,
        is_local: package["source"].is_null(),
    })
}

/// The texts in the folder of a library and in those below it, or else, within a source tree, above it.
fn texts_of(library: &Library) -> Vec<String> {
    let mut found = Vec::new();
    collect(&library.folder, 2, &mut found);
    if found.is_empty() && library.is_local {
        for folder in library.folder.ancestors().skip(1).take(3) {
            collect(folder, 0, &mut found);
            if !found.is_empty() {
                break;
            }
        }
    }
    found
}

fn collect(folder: &Path, depth: usize, found: &mut Vec<String>) {
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    let mut paths: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
    paths.sort();
    for path in paths {
        if path.is_dir() {
            let is_built = path.file_name().is_some_and(|name| name == "target" || name == ".git");
            if depth > 0 && !is_built {
                collect(&path, depth - 1, found);
            }
        } else if is_licence(&path) {
            found.extend(std::fs::read(&path).ok().map(|bytes| String::from_utf8_lossy(&bytes).replace("\r\n", "\n")));
        }
    }
}

fn is_licence(path: &Path) -> bool {
    let name = path.file_name().map(|name| name.to_string_lossy().to_lowercase()).unwrap_or_default();
    let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase()).unwrap_or_default();
    // As of `LICENSE-2.0`.
    let is_number = ending.chars().all(|c| c.is_ascii_digit());
    (is_number || ENDINGS.contains(&ending.as_str())) && NAMES.iter().any(|start| name.starts_with(start))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn licences_are_known_by_their_names() {
        for name in ["LICENSE", "LICENSE-MIT", "LICENSE.md", "licence.txt", "COPYING", "OFL.txt", "LICENSE-2.0"] {
            assert!(is_licence(Path::new(name)), "{name}");
        }
        for name in ["license.rs", "src", "README.md", "notice.json"] {
            assert!(!is_licence(Path::new(name)), "{name}");
        }
    }
}
