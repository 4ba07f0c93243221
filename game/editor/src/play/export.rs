//! The animation as image files, a frame at a time while the window stays alive; and as a video where `ffmpeg` is.

use super::player::Player;
use super::render_thread::Purpose;
use crate::editor::Export;
use anyhow::{Context, Result, bail};
use lightwell::measure;
use lightwell::render::RenderSettings;
use lightwell::scene::{SceneCamera, SceneView};
use lightwell_runtime::session::Session;
use lightwell_runtime::writer::numbered;
use std::ffi::OsString;
use std::io::Read;
use std::process::{Child, Command, Stdio};

/// An export that goes on.
pub(crate) struct Job {
    export: Export,
    next: u64,
    encoder: OsString,
    encoding: Option<Child>,
}

/// What an export needs next.
pub(crate) enum Next {
    /// This view of the session to be drawn, then [`Job::keep`].
    Frame(Box<(SceneView, RenderSettings)>),
    /// Time: the video is being made.
    Wait,
    /// Nothing.
    Done,
}

impl Job {
    /// Begins with the first frame.
    pub(crate) fn new(export: Export) -> Self {
        Self { export, next: 0, encoder: "ffmpeg".into(), encoding: None }
    }

    /// Frames that are written, and all of them.
    pub(crate) fn progress(&self) -> (u64, u64) {
        (self.next, self.export.frames)
    }

    /// Moves the session on to what is needed next. `eye` is the camera to look through once it stands there.
    ///
    /// # Errors
    /// If there is no camera, or no video can be made.
    pub(crate) fn next(
        &mut self,
        session: &mut Session,
        eye: impl FnOnce(&Session) -> Result<SceneCamera>,
    ) -> Result<Next> {
        if self.next >= self.export.frames {
            return if self.export.video { self.encode() } else { Ok(Next::Done) };
        }
        let folder = &self.export.folder;
        std::fs::create_dir_all(folder).with_context(|| format!("cannot make the folder {}", folder.display()))?;
        session.set_seconds(self.next as f64 / f64::from(self.export.rate.max(1)));
        let view = SceneView { camera: eye(session)?, size: self.export.size, jitter: [0.0; 2] };
        let settings = RenderSettings { beside: None, average: false, ..session.display_settings() };
        Ok(Next::Frame(Box::new((view, settings))))
    }

    /// Writes the frame that was drawn.
    ///
    /// # Errors
    /// If it cannot be read back or written.
    pub(crate) fn keep(&mut self, session: &Session) -> Result<()> {
        let (size, rgb) = session.display_bytes()?;
        let path = numbered(&self.export.folder.join("frame.png"), self.next + 1);
        measure::write_png_rgb8(&path, size, &rgb)?;
        self.next += 1;
        Ok(())
    }

    /// Begins the video, or looks whether it is made.
    fn encode(&mut self) -> Result<Next> {
        let Some(encoding) = &mut self.encoding else {
            self.encoding = Some(self.encoder()?);
            return Ok(Next::Wait);
        };
        let Some(status) = encoding.try_wait().context("ffmpeg cannot be waited for")? else { return Ok(Next::Wait) };
        let mut said = String::new();
        if let Some(stderr) = &mut encoding.stderr {
            let _ = stderr.read_to_string(&mut said);
        }
        if !status.success() {
            let folder = self.export.folder.display();
            bail!("no video was made, the images are in {folder}; ffmpeg says: {}", said.trim());
        }
        Ok(Next::Done)
    }

    fn encoder(&self) -> Result<Child> {
        let export = &self.export;
        Command::new(&self.encoder)
            .args(["-y", "-loglevel", "error", "-framerate", &export.rate.to_string(), "-start_number", "1", "-i"])
            .arg(export.folder.join("frame_%04d.png"))
            // Frames of a longer export before this one may lie behind.
            .args(["-frames:v", &export.frames.to_string()])
            .args(["-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-pix_fmt", "yuv420p"])
            .arg(export.folder.join("video.mp4"))
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .with_context(|| {
                let folder = export.folder.display();
                format!("no video was made, the images are in {folder}: ffmpeg cannot be started; install it")
            })
    }
}

impl Drop for Job {
    fn drop(&mut self) {
        if let Some(mut encoding) = self.encoding.take() {
            let _ = encoding.kill();
            let _ = encoding.wait();
        }
    }
}

impl Player {
    /// Begins the next frame of the export.
    pub(super) fn continue_export(&mut self) {
        let Some(job) = &mut self.job else { return };
        let camera = &self.camera;
        let next = job.next(&mut self.session, |session| Ok(camera.apply(&session.camera()?)));
        let begun = next.and_then(|next| match next {
            Next::Frame(frame) => {
                self.render_thread.begin(&mut self.session, frame.0, frame.1, Purpose::Export).map(|()| false)
            }
            Next::Wait => Ok(false),
            Next::Done => Ok(true),
        });
        match begun {
            Ok(false) => {}
            Ok(true) => {
                let folder = self.job.as_ref().map(|job| job.export.folder.display().to_string()).unwrap_or_default();
                self.end_export(&format!("exported into {folder}"), false);
            }
            Err(error) => self.end_export(&format!("the export ended: {error:#}"), true),
        }
    }

    /// Writes the frame that was drawn for the export.
    pub(super) fn keep_exported(&mut self) {
        // It may have been cancelled meanwhile.
        let Some(job) = &mut self.job else { return };
        if let Err(error) = job.keep(&self.session) {
            self.end_export(&format!("the export ended: {error:#}"), true);
        }
    }

    /// Begins an export, unless one goes on.
    pub(super) fn begin_export(&mut self, export: Export) {
        match self.job {
            Some(_) => self.editor.tell("an export goes on already: cancel it first", true),
            None => self.job = Some(Job::new(export)),
        }
    }

    /// Ends the export at the user's wish.
    pub(super) fn cancel_export(&mut self) {
        let Some(job) = &self.job else { return };
        let (done, all) = job.progress();
        let text = format!("export cancelled; {done} of {all} frames are in {}", job.export.folder.display());
        self.end_export(&text, false);
    }

    pub(super) fn end_export(&mut self, text: &str, is_error: bool) {
        if self.job.take().is_some() {
            self.editor.tell(text, is_error);
        }
        self.picture.forget();
        self.stale = true;
    }
}

#[cfg(test)]
impl Job {
    /// The same with another program in the place of `ffmpeg`.
    pub(crate) fn with_encoder(export: Export, encoder: &str) -> Self {
        let mut job = Self::new(export);
        job.encoder = encoder.into();
        job
    }
}
