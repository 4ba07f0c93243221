//! Half-done images in files, so that a long trace can be taken up again.

use super::path_trace::PathTracer;
use crate::gpu::{self, Gpu};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// First bytes of a file of sums.
const MAGIC: &[u8; 8] = b"LWTRACE1";

/// Why sums could not be kept or taken up.
#[derive(Debug, thiserror::Error)]
pub enum StateError {
    /// The file cannot be read or written.
    #[error("{}: {reason}", file.display())]
    File {
        /// The file.
        file: PathBuf,
        /// What the system says.
        reason: io::Error,
    },
    /// The file holds something else.
    #[error("{}: this is no half-done trace, or it is cut off: remove it to restart", .0.display())]
    Format(PathBuf),
    /// The file belongs to another image.
    #[error("{}: this half-done trace is of another scene, time, camera, size or setting: remove it to restart", .0.display())]
    Other(PathBuf),
    /// The device failed.
    #[error("the sums could not be read back: {0}")]
    Device(String),
}

impl PathTracer {
    /// Writes the sums with the number of samples and the key of what is traced (see
    /// [`content_key`](super::content_key)), in one step: a file that was there stays whole until then.
    ///
    /// # Errors
    /// If the device fails or the file cannot be written.
    pub fn save(&self, gpu: &Gpu, path: &Path, key: u128) -> Result<(), StateError> {
        let Some(progress) = &self.progress else { return Ok(()) };
        let sums: Vec<f32> =
            gpu::read_buffer(gpu, &progress.sums).map_err(|error| StateError::Device(error.to_string()))?;
        let file = |reason| StateError::File { file: path.into(), reason };
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let mut part = tempfile::NamedTempFile::new_in(folder).map_err(file)?;
        let mut header = MAGIC.to_vec();
        header.extend(key.to_le_bytes());
        header.extend(progress.samples.to_le_bytes());
        part.write_all(&header).and_then(|()| part.write_all(bytemuck::cast_slice(&sums))).map_err(file)?;
        part.persist(path).map_err(|error| file(error.error))?;
        Ok(())
    }

    /// Takes up what [`PathTracer::save`] wrote, if there is such a file: the samples that it holds. The image must
    /// have been begun. The result has the same bits as if it had been traced in one go.
    ///
    /// # Errors
    /// If the file cannot be read, or is of another image.
    pub fn resume(&mut self, gpu: &Gpu, path: &Path, key: u128) -> Result<u32, StateError> {
        let Some(progress) = &mut self.progress else { return Ok(0) };
        let bytes = match std::fs::read(path) {
            Ok(bytes) => bytes,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(0),
            Err(reason) => return Err(StateError::File { file: path.into(), reason }),
        };
        let format = || StateError::Format(path.into());
        let rest = bytes.strip_prefix(MAGIC).ok_or_else(format)?;
        let (stored, rest) = rest.split_first_chunk::<16>().ok_or_else(format)?;
        let (samples, sums) = rest.split_first_chunk::<4>().ok_or_else(format)?;
        if u128::from_le_bytes(*stored) != key {
            return Err(StateError::Other(path.into()));
        }
        if sums.len() as u64 != progress.sums.size() {
            return Err(format());
        }
        gpu.write_buffer(&progress.sums, 0, sums);
        progress.samples = u32::from_le_bytes(*samples);
        Ok(progress.samples)
    }
}
