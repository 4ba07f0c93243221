//! Which scene tests there are.

use anyhow::{Context, Result, bail};
use lightwell::files::suggestion;
use std::path::{Path, PathBuf};

/// The ending of a scene test's file name.
const ENDING: &str = ".test.ron";

/// A scene test that was found.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TestCase {
    /// Its name: the file's without the ending, after its folder below the one that was searched.
    pub name: String,
    /// The file.
    pub path: PathBuf,
}

impl TestCase {
    /// The folder that its relative paths start from.
    pub fn folder(&self) -> &Path {
        self.path.parent().unwrap_or(Path::new("."))
    }

    /// The file's name without its ending.
    pub fn stem(&self) -> &str {
        self.name.rsplit('/').next().unwrap_or(&self.name)
    }

    /// The golden image of a time.
    pub fn golden(&self, time: f64) -> PathBuf {
        self.folder().join("goldens").join(format!("{}_{time}s.png", self.stem()))
    }
}

/// The tests in files and folders, folders with all below them, in the order of the paths and then of names.
///
/// # Errors
/// If a path is not there, a file is no scene test, or a folder cannot be read.
pub fn discover(paths: &[PathBuf]) -> Result<Vec<TestCase>> {
    let mut cases: Vec<TestCase> = Vec::new();
    for path in paths {
        let mut found = Vec::new();
        if path.is_dir() {
            search(path, "", &mut found)?;
        } else if path.is_file() {
            found.push(
                case_of(path, "").with_context(|| {
                    format!("{} is no scene test: its name does not end in {ENDING}", path.display())
                })?,
            );
        } else {
            bail!("{}: there is no such file or folder", path.display());
        }
        found.sort_by(|a, b| a.name.cmp(&b.name));
        found.retain(|case| cases.iter().all(|known| known.path != case.path));
        cases.append(&mut found);
    }
    Ok(cases)
}

fn search(folder: &Path, prefix: &str, found: &mut Vec<TestCase>) -> Result<()> {
    let unreadable = || format!("the folder {} cannot be read", folder.display());
    for entry in std::fs::read_dir(folder).with_context(unreadable)? {
        let path = entry.with_context(unreadable)?.path();
        if path.is_dir() {
            let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
            search(&path, &format!("{prefix}{name}/"), found)?;
        } else {
            found.extend(case_of(&path, prefix));
        }
    }
    Ok(())
}

fn case_of(path: &Path, prefix: &str) -> Option<TestCase> {
    let name = path.file_name()?.to_str()?.strip_suffix(ENDING)?;
    Some(TestCase { name: format!("{prefix}{name}"), path: path.to_owned() })
}

/// The folder `tests/scenes` in the current folder or above it, else in the source tree.
///
/// # Errors
/// If there is none.
pub fn default_folder() -> Result<PathBuf> {
    let current = std::env::current_dir().ok();
    let above = current.iter().flat_map(|dir| dir.ancestors().map(|dir| dir.join("tests/scenes")));
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/scenes");
    let found = above.chain([source]).find(|folder| folder.is_dir());
    found.context("there is no folder tests/scenes here or above; name a file or folder of scene tests")
}

/// Keeps the tests whose name holds one of the texts; all if there are none.
///
/// # Errors
/// If none is left.
pub fn select(cases: Vec<TestCase>, filters: &[String]) -> Result<Vec<TestCase>> {
    if cases.is_empty() {
        bail!("there are no scene tests (files that end in {ENDING})");
    }
    let names: Vec<String> = cases.iter().map(|case| case.name.clone()).collect();
    let wanted = |case: &TestCase| filters.is_empty() || filters.iter().any(|text| case.name.contains(text.as_str()));
    let selected: Vec<TestCase> = cases.into_iter().filter(wanted).collect();
    if selected.is_empty() {
        let help = filters.first().and_then(|text| suggestion(text, names.iter().map(String::as_str)));
        bail!("no scene test has `{}` in its name; {}", filters.join("` or `"), help.unwrap_or_default());
    }
    Ok(selected)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn folder() -> tempfile::TempDir {
        let dir = tempfile::tempdir().unwrap();
        std::fs::create_dir_all(dir.path().join("deep")).unwrap();
        for file in ["b.test.ron", "a.test.ron", "deep/c.test.ron", "no test.ron", "a.scene.ron"] {
            std::fs::write(dir.path().join(file), "").unwrap();
        }
        dir
    }

    #[test]
    fn folders_are_searched_and_files_taken() {
        let dir = folder();
        let names =
            |paths: &[PathBuf]| -> Vec<String> { discover(paths).unwrap().into_iter().map(|case| case.name).collect() };
        assert_eq!(names(&[dir.path().to_owned()]), ["a", "b", "deep/c"]);
        assert_eq!(names(&[dir.path().join("b.test.ron"), dir.path().to_owned()]), ["b", "a", "deep/c"]);
        let no_test = discover(&[dir.path().join("a.scene.ron")]).unwrap_err().to_string();
        assert!(no_test.contains(".test.ron"), "{no_test}");
        assert!(discover(&[dir.path().join("nothing")]).is_err());
    }

    #[test]
    fn filters_choose_by_name() {
        let dir = folder();
        let cases = discover(&[dir.path().to_owned()]).unwrap();
        assert_eq!(select(cases.clone(), &[]).unwrap().len(), 3);
        assert_eq!(select(cases.clone(), &["eep".into(), "b".into()]).unwrap().len(), 2);
        let none = select(cases, &["depe/c".into()]).unwrap_err().to_string();
        assert!(none.contains("did you mean `deep/c`?"), "{none}");
        assert!(select(Vec::new(), &[]).is_err());
    }

    #[test]
    fn goldens_lie_beside_the_test() {
        let case = TestCase { name: "deep/c".into(), path: "t/deep/c.test.ron".into() };
        assert_eq!(case.golden(1.5), Path::new("t/deep/goldens/c_1.5s.png"));
        assert_eq!(case.golden(0.0), Path::new("t/deep/goldens/c_0s.png"));
    }
}
