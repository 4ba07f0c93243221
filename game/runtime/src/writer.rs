//! Writes pictures into files on a thread of its own, while the next ones are drawn.

use anyhow::{Context, Result, anyhow};
use lightwell::measure::{self, Image};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{SyncSender, sync_channel};
use std::thread::JoinHandle;

/// Pictures that may wait to be written. More would only take memory: whoever is slower sets the pace.
const WAITING: usize = 2;

/// A finished picture.
pub enum Picture {
    /// What a screen shows: sRGB bytes, three a pixel.
    Display {
        /// Size \[pixels\].
        size: [u32; 2],
        /// The bytes.
        rgb: Vec<u8>,
    },
    /// Linear values.
    Linear(Image),
}

impl Picture {
    /// Writes it, making its folder if need be.
    ///
    /// # Errors
    /// If the file or its folder cannot be written.
    pub fn write(&self, path: &Path) -> Result<()> {
        if let Some(folder) = path.parent().filter(|folder| !folder.as_os_str().is_empty()) {
            std::fs::create_dir_all(folder).with_context(|| format!("cannot make the folder {}", folder.display()))?;
        }
        match self {
            Self::Display { size, rgb } => Ok(measure::write_png_rgb8(path, *size, rgb)?),
            Self::Linear(image) => {
                if let Some([x, y]) = image.first_non_finite() {
                    log::warn!("{}: NaN or infinity in the image, first at column {x} of row {y}", path.display());
                }
                Ok(measure::write_image(path, image)?)
            }
        }
    }
}

/// The thread that writes. Pictures are written in the order in which they come.
pub struct Writer {
    queue: Option<SyncSender<(PathBuf, Picture)>>,
    thread: Option<JoinHandle<Result<()>>>,
}

impl Writer {
    /// Starts the thread.
    ///
    /// # Errors
    /// If the system gives none.
    pub fn start() -> Result<Self> {
        let (queue, pictures) = sync_channel::<(PathBuf, Picture)>(WAITING);
        // The first failure ends the thread, and with it the queue: what is queued after it comes to know.
        let write = move || pictures.iter().try_for_each(|(path, picture)| picture.write(&path));
        let thread = std::thread::Builder::new().name("writer".to_owned()).spawn(write)?;
        Ok(Self { queue: Some(queue), thread: Some(thread) })
    }

    /// Queues a picture; waits while others are in its way.
    ///
    /// # Errors
    /// If an earlier one could not be written.
    pub fn write(&mut self, path: PathBuf, picture: Picture) -> Result<()> {
        let sent = self.queue.as_ref().is_some_and(|queue| queue.send((path, picture)).is_ok());
        if sent { Ok(()) } else { self.join().and(Err(anyhow!("the pictures are no longer written"))) }
    }

    /// Waits until all are written.
    ///
    /// # Errors
    /// If one could not be written.
    pub fn finish(mut self) -> Result<()> {
        self.join()
    }

    fn join(&mut self) -> Result<()> {
        self.queue = None;
        let ended = self.thread.take().map(JoinHandle::join);
        ended.unwrap_or(Ok(Ok(()))).unwrap_or_else(|_| Err(anyhow!("the thread that writes pictures has failed")))
    }
}

/// What is queued is written even if the drawing fails.
impl Drop for Writer {
    fn drop(&mut self) {
        if let Err(error) = self.join() {
            log::error!("{error:#}");
        }
    }
}

/// The file of a frame: its number, of four digits or more, for `{}` in the name, else with `_` before the ending.
pub fn numbered(path: &Path, frame: u64) -> PathBuf {
    let number = format!("{frame:04}");
    let name = path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
    let name = match (name.contains("{}"), name.rsplit_once('.')) {
        (true, _) => name.replace("{}", &number),
        (false, Some((stem, ending))) => format!("{stem}_{number}.{ending}"),
        (false, None) => format!("{name}_{number}"),
    };
    path.with_file_name(name)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn picture(value: u8) -> Picture {
        Picture::Display { size: [2, 1], rgb: vec![value; 6] }
    }

    #[test]
    fn all_pictures_are_there_when_it_has_finished() {
        let dir = tempfile::tempdir().unwrap();
        let mut writer = Writer::start().unwrap();
        let path = |index: u8| dir.path().join(format!("new/{index}.png"));
        (0..9).for_each(|index| writer.write(path(index), picture(20 * index)).unwrap());
        writer.finish().unwrap();
        for index in 0..9 {
            let red = measure::read_image(&path(index)).unwrap().pixel(0, 0)[0];
            assert!((red - measure::srgb_decode(f32::from(20 * index) / 255.0)).abs() < 1e-3, "{index}: {red}");
        }
    }

    #[test]
    fn what_cannot_be_written_is_told_once_and_with_its_file() {
        let dir = tempfile::tempdir().unwrap();
        let blocked = dir.path().join("file");
        std::fs::write(&blocked, "").unwrap();
        let mut writer = Writer::start().unwrap();
        let outcome = (0..20).try_for_each(|_| writer.write(blocked.join("a.png"), picture(0)));
        let message = format!("{:#}", outcome.unwrap_err());
        assert!(message.contains("cannot make the folder"), "{message}");
        writer.finish().unwrap();
    }

    #[test]
    fn frames_are_numbered() {
        assert_eq!(numbered(Path::new("a/b.png"), 7), Path::new("a/b_0007.png"));
        assert_eq!(numbered(Path::new("a/{}.png"), 12345), Path::new("a/12345.png"));
        assert_eq!(numbered(Path::new("x_{}_y.v2.exr"), 3), Path::new("x_0003_y.v2.exr"));
    }
}
