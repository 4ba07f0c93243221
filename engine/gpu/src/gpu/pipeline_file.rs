//! The driver's pipeline cache on disk: shaders are not compiled again at the next start.

use crate::core::replace_file;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use xxhash_rust::xxh3::xxh3_64;

/// The head of a file: its kind and version.
const MAGIC: &[u8; 8] = b"lwpipe01";

/// The driver's cache of pipelines with the file that it is kept in.
pub(super) struct PipelineFile {
    pub cache: wgpu::PipelineCache,
    pub(super) path: PathBuf,
    pub(super) has_grown: AtomicBool,
}

impl PipelineFile {
    /// Notes that a pipeline was made with the cache.
    pub fn grow(&self) {
        self.has_grown.store(true, Ordering::Relaxed);
    }

    fn save(&self) -> std::io::Result<()> {
        let Some(data) = self.cache.get_data() else { return Ok(()) };
        self.path.parent().map_or(Ok(()), std::fs::create_dir_all)?;
        replace_file(&self.path, &wrapped(&data))
    }
}

impl Drop for PipelineFile {
    fn drop(&mut self) {
        if self.has_grown.load(Ordering::Relaxed)
            && let Err(error) = self.save()
        {
            log::warn!("cannot keep pipelines in {}: {error}", self.path.display());
        }
    }
}

/// The file's content.
fn wrapped(data: &[u8]) -> Vec<u8> {
    [MAGIC.as_slice(), &xxh3_64(data).to_le_bytes(), data].concat()
}

/// The data of a file; none if it is not whole, or no such file.
pub(super) fn unwrapped(file: &[u8]) -> Option<&[u8]> {
    let (hash, data) = file.strip_prefix(MAGIC)?.split_first_chunk::<8>()?;
    (u64::from_le_bytes(*hash) == xxh3_64(data)).then_some(data)
}

#[cfg(test)]
mod tests {
    use super::{unwrapped, wrapped};

    #[test]
    fn only_whole_files_are_taken() {
        let file = wrapped(b"pipelines");
        assert_eq!(unwrapped(&file), Some(b"pipelines".as_slice()));
        assert_eq!(unwrapped(&file[..file.len() - 1]), None, "cut off");
        assert_eq!(unwrapped(b"something else"), None);
        assert_eq!(unwrapped(b""), None);
        for at in 0..file.len() {
            let mut broken = file.clone();
            broken[at] ^= 1;
            assert_eq!(unwrapped(&broken), None, "byte {at}");
        }
    }
}
