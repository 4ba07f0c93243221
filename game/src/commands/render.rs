//! `lightwell render`: images of a scene in files.

use crate::cli::{Common, RenderArgs};
use crate::sequence::Sequence;
use crate::session::{PendingPicture, Session};
use crate::writer::Picture;
use crate::{capture, jitter, progress};
use anyhow::{Result, bail};
use indicatif::ProgressBar;
use lightwell::gpu::Gpu;
use lightwell::render::{GiMethod, Layer, ReferenceSettings};
use lightwell::scene::SceneView;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Samples between two looks at the clock.
const SAMPLES_A_STEP: u32 = 64;
/// How often a half-done image is kept.
const SAVE_EVERY: Duration = Duration::from_secs(30);

/// Renders one image, or one for each frame.
///
/// # Errors
/// If the scene cannot be loaded or drawn, or a file cannot be written.
pub fn run(args: &RenderArgs, common: &Common) -> Result<()> {
    if !args.look.debug.views.is_empty() && (args.aa > 1 || extension_is(&args.output, "exr")) {
        bail!("--debug draws over what a screen shows: write a .png file, without --aa");
    }
    let mut session = Session::headless(&args.scene, &args.look, common)?;
    let shot = Shot { size: args.size, aa: args.aa, linear: extension_is(&args.output, "exr") };
    let Some(frames) = args.frames.clone() else {
        session.set_seconds(args.time.unwrap_or(0.0));
        let settings = session.render_settings(true);
        if settings.gi == GiMethod::REFERENCE {
            trace_ahead(&mut session, args, &settings.reference)?;
        } else if args.resume.is_some() {
            bail!("--resume goes with `--gi reference`, whose images take long");
        }
        let bar = progress::bar(u64::from(args.aa), "rendering");
        shot.take(&mut session, &bar)?.write(&args.output)?;
        bar.finish_and_clear();
        return Ok(());
    };
    let bar = progress::bar((frames.end - frames.start) * u64::from(args.aa), "rendering frames");
    let mut sequence = Sequence::start(&mut session)?;
    for frame in frames {
        session.set_ticks(frame);
        sequence.take(numbered(&args.output, frame), &shot, &mut session, &bar)?;
    }
    sequence.finish(&session)?;
    bar.finish_and_clear();
    Ok(())
}

/// Traces all samples of the image, with a bar and the half-done image in a file where one is wanted, and says how
/// much noise is left. The frame that is written then finds them done.
fn trace_ahead(session: &mut Session, args: &RenderArgs, settings: &ReferenceSettings) -> Result<()> {
    let view = SceneView { camera: session.camera()?, size: args.size, jitter: [0.0; 2] };
    let (mut tracing, key) = session.begin_trace(&view, &settings.trace)?;
    let bar = progress::bar(u64::from(settings.samples), "tracing");
    let mut saved = Instant::now();
    if let Some(file) = &args.resume {
        let samples = tracing.resume(file, key)?;
        if samples > 0 {
            say!("{}: {samples} samples a pixel are there already", file.display());
        }
        bar.set_position(u64::from(samples));
    }
    while tracing.tracer.samples() < settings.samples {
        let next = settings.samples.min(tracing.tracer.samples() + SAMPLES_A_STEP);
        tracing.advance_to(next, &mut |done| bar.set_position(u64::from(done)))?;
        let finished = tracing.tracer.samples() >= settings.samples;
        if let Some(file) = args.resume.as_ref().filter(|_| finished || saved.elapsed() > SAVE_EVERY) {
            tracing.save(file, key)?;
            saved = Instant::now();
        }
    }
    bar.finish_and_clear();
    let estimate = tracing.estimate()?;
    let noise = |layer| estimate.noise(layer).map(|noise| format!("{:.2} %", 100.0 * noise));
    say!(
        "{} samples a pixel; noise relative to the mean: direct {}, indirect {}, total {}",
        estimate.samples,
        noise(Layer::Direct)?,
        noise(Layer::Indirect)?,
        noise(Layer::Total)?
    );
    Ok(())
}

/// How an image is taken.
pub struct Shot {
    /// Size [pixels].
    pub size: [u32; 2],
    /// Number of frames that are averaged.
    pub aa: u32,
    /// Linear radiance instead of what a screen shows.
    pub linear: bool,
}

/// What was drawn.
pub enum Taken {
    /// It is there.
    Ready(Picture),
    /// It comes back from the device.
    Coming(PendingPicture),
}

impl Taken {
    /// Waits for it.
    ///
    /// # Errors
    /// If the device fails.
    pub fn finish(self, gpu: &Gpu) -> Result<Picture> {
        match self {
            Self::Ready(picture) => Ok(picture),
            Self::Coming(pending) => pending.finish(gpu),
        }
    }
}

impl Shot {
    /// Draws the scene as it stands.
    ///
    /// # Errors
    /// If the scene cannot be drawn.
    pub fn take(&self, session: &mut Session, bar: &ProgressBar) -> Result<Picture> {
        self.begin(session, bar)?.finish(&session.gpu)
    }

    /// The same, and does not wait for a picture of one frame to come back.
    ///
    /// # Errors
    /// As [`Shot::take`].
    pub fn begin(&self, session: &mut Session, bar: &ProgressBar) -> Result<Taken> {
        let settings = session.render_settings(!self.linear);
        // The tracer filters over the pixel by itself.
        let aa = if settings.gi == GiMethod::REFERENCE && settings.only.is_light() { 1 } else { self.aa };
        if aa == 1 {
            let view = SceneView { camera: session.camera()?, size: self.size, jitter: jitter::shift(0, 1) };
            let settings = if self.linear { settings } else { session.display_settings() };
            session.render(&view, &settings)?;
            bar.inc(u64::from(self.aa));
            return Ok(Taken::Coming(session.painter.begin_reading(self.linear)?));
        }
        let told = &mut || bar.inc(u64::from(self.aa / aa));
        Ok(Taken::Ready(Picture::Linear(capture::take_telling(session, self.size, aa, &settings, told)?)))
    }
}

fn extension_is(path: &Path, ending: &str) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case(ending))
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
    use super::*;

    #[test]
    fn frames_are_numbered() {
        assert_eq!(numbered(Path::new("a/b.png"), 7), Path::new("a/b_0007.png"));
        assert_eq!(numbered(Path::new("a/{}.png"), 12345), Path::new("a/12345.png"));
        assert_eq!(numbered(Path::new("x_{}_y.v2.exr"), 3), Path::new("x_0003_y.v2.exr"));
    }
}
