//! A game that is asked what it loads.

use anyhow::{Context, Result, bail};
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A game's program, and how it is called.
pub struct Game<'a> {
    pub program: &'a Path,
    /// The folder that it is started in; none: the current one.
    pub folder: Option<PathBuf>,
    pub script: Option<&'a Path>,
}

impl Game<'_> {
    /// The files that the game loads, its first scene first, with some that it loads later and what those name.
    ///
    /// # Errors
    /// If the game says that one is missing or faulty.
    pub fn files(&self, also: &[PathBuf], more: &[OsString]) -> Result<Vec<PathBuf>> {
        self.ask(Command::new(super::absolute(self.program)?).args(more), also)
    }

    /// The same without this process's environment, which other machines do not have.
    ///
    /// # Errors
    /// As [`Game::files`].
    pub fn files_alone(&self, also: &[PathBuf]) -> Result<Vec<PathBuf>> {
        let mut command = Command::new(super::absolute(self.program)?);
        command.env_clear();
        // Windows finds its own libraries by this.
        command.envs(std::env::var_os("SystemRoot").map(|root| ("SystemRoot", root)));
        self.ask(&mut command, also)
    }

    fn ask(&self, command: &mut Command, also: &[PathBuf]) -> Result<Vec<PathBuf>> {
        command.arg("--list-files");
        if let Some(script) = self.script {
            command.arg("--script").arg(super::absolute(script)?);
        }
        for path in also.iter().filter(|path| names_others(path)) {
            command.arg("--also").arg(path);
        }
        if let Some(folder) = &self.folder {
            command.current_dir(folder);
        }
        let output = command.output().with_context(|| format!("cannot start {}", self.program.display()))?;
        let errors = String::from_utf8_lossy(&output.stderr);
        match output.status.code() {
            Some(0) => {}
            Some(2) => bail!(
                "{} does not know --list-files: it is no game of this version of lightwell-game\n{}",
                self.program.display(),
                errors.trim_end()
            ),
            _ => bail!("{}", errors.trim_end().trim_start_matches("error: ")),
        }
        let lines = String::from_utf8(output.stdout).context("the game names a file whose name is not Unicode")?;
        Ok(lines.lines().map(PathBuf::from).collect())
    }
}

/// Whether a file may name others.
fn names_others(path: &Path) -> bool {
    let name = path.to_string_lossy().to_lowercase();
    [".scene.ron", ".prefab.ron", ".gltf", ".glb"].iter().any(|ending| name.ends_with(ending))
}
