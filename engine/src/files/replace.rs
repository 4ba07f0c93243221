//! Files are replaced in one step: at every moment there is the old one or the whole new one.

use std::ffi::OsString;
use std::io::{Result, Write};
use std::path::{Path, PathBuf};

/// Replaces a file, or makes it. If that fails the old one stays, and nothing else is left. A link stays a link: the
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
    let written = write(&temporary, bytes).and_then(|()| std::fs::rename(&temporary, path));
    written.inspect_err(|_| discard(&temporary))
}

/// A file of this process beside another one, which [`remove_leftovers`](super::remove_leftovers) knows.
pub(super) fn beside(path: &Path, ending: &str) -> PathBuf {
    let mut name: OsString = path.file_name().unwrap_or_default().to_owned();
    name.push(format!(".{}{ending}", std::process::id()));
    path.with_file_name(name)
}

pub(super) fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    let mut file = std::fs::File::create(path)?;
    file.write_all(bytes)?;
    file.sync_all()
}

/// What is left of a failure is of no use; that it is there harms nobody.
pub(super) fn discard(path: &Path) {
    let _ = std::fs::remove_file(path);
}
