//! The animation as image files, a frame at a time while the window stays alive; and as a video where `ffmpeg` is.

use super::player::Player;
use crate::commands::render::numbered;
use crate::editor::Export;
use anyhow::{Context, Result, bail};
use lightwell::measure;
use lightwell::render::RenderSettings;
use lightwell::scene::SceneView;
use std::process::Command;

/// An export that goes on.
pub struct Job {
    export: Export,
    next: u64,
}

impl Job {
    /// Begins with the first frame.
    pub fn new(export: Export) -> Self {
        Self { export, next: 0 }
    }
}

impl Player {
    /// Writes the next frame of the export, if one goes on.
    pub(super) fn continue_export(&mut self) {
        let Some(mut job) = self.job.take() else { return };
        let result = if job.next < job.export.frames { self.export_frame(&job) } else { self.finish_export(&job) };
        match result {
            Ok(()) if job.next < job.export.frames => {
                job.next += 1;
                self.editor.tell(format!("exported {} of {} frames", job.next, job.export.frames), false);
                self.job = Some(job);
            }
            Ok(()) => self.editor.tell(format!("exported into {}", job.export.folder.display()), false),
            Err(error) => self.editor.tell(format!("the export ended: {error:#}"), true),
        }
    }

    fn export_frame(&mut self, job: &Job) -> Result<()> {
        let export = &job.export;
        std::fs::create_dir_all(&export.folder)
            .with_context(|| format!("cannot make the folder {}", export.folder.display()))?;
        self.session.set_seconds(job.next as f64 / f64::from(export.rate.max(1)));
        let view = SceneView { camera: self.eye()?, size: export.size, jitter: [0.0; 2] };
        let settings = RenderSettings { beside: None, ..self.session.display_settings() };
        self.session.render(&view, &settings)?;
        let (size, rgb) = self.session.display_bytes()?;
        let path = numbered(&export.folder.join("frame.png"), job.next + 1);
        measure::write_png_rgb8(&path, size, &rgb)?;
        Ok(())
    }

    fn finish_export(&mut self, job: &Job) -> Result<()> {
        if !job.export.video {
            return Ok(());
        }
        let export = &job.export;
        let output = Command::new("ffmpeg")
            .args(["-y", "-loglevel", "error", "-framerate", &export.rate.to_string(), "-i"])
            .arg(export.folder.join("frame_%04d.png"))
            .args(["-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-pix_fmt", "yuv420p"])
            .arg(export.folder.join("video.mp4"))
            .output()
            .context("ffmpeg cannot be started")?;
        if !output.status.success() {
            bail!("ffmpeg: {}", String::from_utf8_lossy(&output.stderr).trim());
        }
        Ok(())
    }
}
