//! Files are replaced in one step: at every moment there is the old one or the whole new one.

use std::ffi::OsString;
use std::fs::{File, Metadata};
use std::io::{Result, Write};
use std::path::{Path, PathBuf};

/// Replaces a file, or makes it. Permissions, and owner and group as far as the system lets, stay those of the file that
/// is replaced; a new one has the usual ones. If that fails the old one stays, and nothing else is left. A link stays a link: the
/// file that it leads to is replaced. What is no file, such as a pipe, is written to.
///
/// # Errors
/// If it cannot be written beside the old one, or not take its place.
pub fn replace_file(path: &Path, bytes: &[u8]) -> Result<()> {
    let path = &path.canonicalize().unwrap_or_else(|_| path.to_owned());
    if path.metadata().is_ok_and(|old| !old.is_file()) {
        return std::fs::write(path, bytes);
    }
    let temporary = beside(path, ".tmp");
    let written = write_in_place_of(&temporary, bytes, path).and_then(|()| std::fs::rename(&temporary, path));
    written.inspect_err(|_| discard(&temporary))
}

/// A file of this process beside another one, which `files::remove_leftovers` knows.
#[doc(hidden)]
pub fn beside(path: &Path, ending: &str) -> PathBuf {
    let mut name: OsString = path.file_name().unwrap_or_default().to_owned();
    name.push(format!(".{}{ending}", std::process::id()));
    path.with_file_name(name)
}

/// Writes a file that shall take the place of another one, with the permissions of that.
#[doc(hidden)]
pub fn write_in_place_of(path: &Path, bytes: &[u8], old: &Path) -> Result<()> {
    discard(path);
    let old = old.metadata().ok();
    let mut file = create(path, old.as_ref())?;
    file.write_all(bytes)?;
    if let Some(old) = &old {
        keep_access(&file, old)?;
    }
    file.sync_all()
}

/// Nobody reads the new file, not even for a moment, who must not read the old one.
#[cfg(unix)]
fn create(path: &Path, old: Option<&Metadata>) -> Result<File> {
    use std::os::unix::fs::OpenOptionsExt;
    let mode = if old.is_some() { 0o600 } else { 0o666 };
    File::options().write(true).create_new(true).mode(mode).open(path)
}

#[cfg(not(unix))]
fn create(path: &Path, _old: Option<&Metadata>) -> Result<File> {
    File::options().write(true).create_new(true).open(path)
}

/// Gives the file owner, group and permissions of an older one. Without the right to give the group, the group may do
/// what all others may.
#[cfg(unix)]
fn keep_access(file: &File, old: &Metadata) -> Result<()> {
    use std::os::unix::fs::{MetadataExt, PermissionsExt, fchown};
    let new = file.metadata()?;
    if (new.uid(), new.gid()) != (old.uid(), old.gid()) && fchown(file, Some(old.uid()), Some(old.gid())).is_err() {
        // Only the group can be given by those who are not root, and only one of theirs; what came of it is seen below.
        let _ = fchown(file, None, Some(old.gid()));
    }
    let mode = match file.metadata()?.gid() == old.gid() {
        true => old.mode() & 0o777,
        false => old.mode() & 0o707 | (old.mode() & 0o7) << 3,
    };
    file.set_permissions(std::fs::Permissions::from_mode(mode))
}

#[cfg(not(unix))]
fn keep_access(_file: &File, _old: &Metadata) -> Result<()> {
    Ok(())
}

/// The rest of a failed write is of no use and harms nobody.
#[doc(hidden)]
pub fn discard(path: &Path) {
    let _ = std::fs::remove_file(path);
}
