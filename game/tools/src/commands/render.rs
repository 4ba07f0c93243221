//! `lightwell render`: images of a scene in files.

use crate::cli::{Quality, RenderArgs};
use crate::sequence::Sequence;
use crate::shot::{Images, Shot};
use anyhow::{Result, bail};
use lightwell::render::{GiMethod, Layer, ReferenceSettings};
use lightwell::scene::SceneView;
use lightwell_runtime::cli::Common;
use lightwell_runtime::progress;
use lightwell_runtime::say;
use lightwell_runtime::session::Session;
use lightwell_runtime::writer::numbered;
use std::ops::Range;
use std::path::Path;
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
    let linear = extension_is(&args.output, "exr");
    if !args.look.debug.is_empty() && (args.aa.unwrap_or(1) > 1 || linear) {
        bail!("--debug draws over what a screen shows: write a .png file, without --aa");
    }
    // A sequence is looked at in motion, and takes as long as all its frames together.
    let quality = if args.frames.is_some() { Quality::Fast } else { Quality::Good };
    let images = Images::choose(args.aa, &args.quality, quality, &args.look, linear)?;
    let mut session = Session::headless(&args.scene, &args.look, common)?;
    let shot = Shot { size: args.size, images, linear };
    match &args.frames {
        Some(frames) => render_frames(&mut session, args, &shot, frames.clone()),
        None => render_still(&mut session, args, &shot),
    }
}

fn render_still(session: &mut Session, args: &RenderArgs, shot: &Shot) -> Result<()> {
    session.set_seconds(args.time.unwrap_or(0.0));
    let settings = session.render_settings(true);
    if settings.gi == GiMethod::REFERENCE {
        trace_ahead(session, args, &settings.reference)?;
    } else if args.resume.is_some() {
        bail!("--resume goes with `--gi reference`, whose images take long");
    }
    let bar = progress::bar(shot.images.expected(), "rendering");
    let (picture, outcome) = shot.take(session, &mut |step| step.show_on(&bar))?;
    picture.write(&args.output)?;
    bar.finish_and_clear();
    if let Some(outcome) = outcome {
        say!("{}: {outcome}", args.output.display());
    }
    Ok(())
}

fn render_frames(session: &mut Session, args: &RenderArgs, shot: &Shot, frames: Range<u64>) -> Result<()> {
    let bar = progress::bar(frames.end - frames.start, "rendering frames");
    let mut sequence = Sequence::start(session)?;
    for frame in frames {
        session.set_ticks(frame);
        sequence.take(numbered(&args.output, frame), shot, session)?;
        bar.inc(1);
    }
    let tally = sequence.finish(session)?;
    bar.finish_and_clear();
    if let Some(sentence) = tally.sentence() {
        say!("{sentence}");
    }
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

fn extension_is(path: &Path, ending: &str) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case(ending))
}
