//! The driver's pipeline cache on disk: shaders are not compiled again at the next start.

use super::Gpu;
use crate::core::replace_file;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use xxhash_rust::xxh3::xxh3_64;

/// The head of a file: its kind and version.
const MAGIC: &[u8; 8] = b"lwpipe01";

/// The driver's cache of pipelines with the file that it is kept in.
pub(super) struct PipelineFile {
    pub cache: wgpu::PipelineCache,
    path: PathBuf,
    has_grown: AtomicBool,
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

impl Gpu {
    /// Keeps what the driver makes of shaders in a file of that folder, and takes up what is there; to be called before
    /// the first pipeline is made. The file is written when the device is let go. One that is broken, of another device
    /// or of another driver is passed over. Drivers that cannot do it keep nothing.
    pub fn keep_pipelines(&self, folder: &Path) {
        let name = wgpu::util::pipeline_cache_key(&self.info);
        let (Some(name), true) = (name, self.features.contains(wgpu::Features::PIPELINE_CACHE)) else { return };
        let path = folder.join(name);
        let data = std::fs::read(&path).ok();
        let data = data.as_deref().and_then(unwrapped);
        let descriptor = wgpu::PipelineCacheDescriptor { label: Some("pipelines"), data, fallback: true };
        // SAFETY: the data came from `PipelineCache::get_data`, as its checksum says; wgpu compares device and driver, and
        // `fallback` has it begin with an empty cache where they differ.
        #[allow(unsafe_code)]
        let made = self.checked(|| unsafe { self.device.create_pipeline_cache(&descriptor) });
        match made {
            Ok(cache) => drop(self.pipeline_file.set(PipelineFile { cache, path, has_grown: AtomicBool::new(false) })),
            Err(error) => log::warn!("cannot keep pipelines: {error}"),
        }
    }
}

/// The file's content.
fn wrapped(data: &[u8]) -> Vec<u8> {
    [MAGIC.as_slice(), &xxh3_64(data).to_le_bytes(), data].concat()
}

/// The data of a file; none if it is not whole, or no such file.
fn unwrapped(file: &[u8]) -> Option<&[u8]> {
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
