//! The folder that a game is packed into: written aside, and put in its place in one step.

use anyhow::{Context, Result, bail};
use lightwell::packed::{LIST, Packed};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// Where a packed folder comes to lie.
pub struct Place {
    folder: PathBuf,
    force: bool,
}

impl Place {
    /// A place for a folder.
    ///
    /// # Errors
    /// If something is there that may not be replaced.
    pub fn new(folder: &Path, force: bool) -> Result<Self> {
        let folder = std::path::absolute(folder).with_context(|| format!("{} is no folder", folder.display()))?;
        let place = Self { folder, force };
        place.check()?;
        Ok(place)
    }

    /// Only what this command made, and nobody has added to, is replaced.
    fn check(&self) -> Result<()> {
        let folder = self.folder.display();
        if self.folder.symlink_metadata().is_err() {
            return Ok(());
        }
        if !self.force {
            bail!("{folder} is there already; choose another folder with -o, or pass --force to replace a packed game");
        }
        let Some(packed) = Packed::read(&self.folder).filter(|_| !self.folder.is_symlink()) else {
            bail!("{folder} is no packed game (it has no {LIST}), and is not replaced; choose another folder with -o");
        };
        let known: BTreeSet<PathBuf> = packed.files().iter().map(|file| self.folder.join(file)).collect();
        let mut found = Vec::new();
        files_in(&self.folder, &mut found)?;
        match found.iter().find(|path| !known.contains(*path) && **path != self.folder.join(LIST)) {
            Some(path) => bail!(
                "{folder} is not replaced: {} was not packed; move it away, or choose another folder with -o",
                path.display()
            ),
            None => Ok(()),
        }
    }

    /// A new folder beside the place. It is removed if it does not get there.
    ///
    /// # Errors
    /// If it cannot be made.
    pub fn aside(&self) -> Result<TempDir> {
        let parent = self.folder.parent().context("the root of a file system is no place for a game")?;
        std::fs::create_dir_all(parent).with_context(|| format!("cannot make the folder {}", parent.display()))?;
        let made = tempfile::Builder::new().prefix(".lightwell-pack-").tempdir_in(parent);
        made.with_context(|| format!("cannot write into {}", parent.display()))
    }

    /// Puts the folder in its place; gives the size of its files \[bytes\].
    ///
    /// # Errors
    /// If something has come there meanwhile, or it cannot be moved. What was there before then stays.
    pub fn finish(&self, aside: TempDir) -> Result<u64> {
        self.check()?;
        open_to_all(aside.path())?;
        let mut files = Vec::new();
        files_in(aside.path(), &mut files)?;
        let size = files.iter().filter_map(|path| path.metadata().ok()).map(|data| data.len()).sum();
        let cannot = || format!("cannot move the packed game to {}", self.folder.display());
        if self.folder.exists() {
            let old = self.aside()?;
            let before = old.path().join("before");
            std::fs::rename(&self.folder, &before).with_context(cannot)?;
            if let Err(error) = std::fs::rename(aside.path(), &self.folder) {
                // The one before comes back; if it cannot, it stays where it is and is not removed.
                if std::fs::rename(&before, &self.folder).is_err() {
                    let kept = old.keep();
                    bail!("{}: {error}; the one before is in {}", cannot(), kept.display());
                }
                return Err(error).with_context(cannot);
            }
        } else {
            std::fs::rename(aside.path(), &self.folder).with_context(cannot)?;
        }
        // It is no temporary folder any more.
        let _ = aside.keep();
        Ok(size)
    }
}

/// Temporary folders are for their owner alone; a game is for all.
#[cfg(unix)]
fn open_to_all(folder: &Path) -> Result<()> {
    use std::os::unix::fs::PermissionsExt;
    std::fs::set_permissions(folder, std::fs::Permissions::from_mode(0o755))?;
    Ok(())
}

#[cfg(not(unix))]
fn open_to_all(_: &Path) -> Result<()> {
    Ok(())
}

fn files_in(folder: &Path, found: &mut Vec<PathBuf>) -> Result<()> {
    for entry in std::fs::read_dir(folder).with_context(|| format!("cannot read {}", folder.display()))? {
        let entry = entry?;
        match entry.file_type()?.is_dir() {
            true => files_in(&entry.path(), found)?,
            false => found.push(entry.path()),
        }
    }
    Ok(())
}
