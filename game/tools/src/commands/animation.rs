//! Playing without a display: one loop of the animation, a file a frame.

use crate::cli::{Quality, QualityArgs};
use crate::sequence::Sequence;
use crate::shot::{Images, Shot};
use anyhow::Result;
use lightwell_runtime::cli::{Common, LookArgs};
use lightwell_runtime::progress;
use lightwell_runtime::say;
use lightwell_runtime::session::Session;
use lightwell_runtime::writer::numbered;
use std::path::Path;

/// Frames a second of what is written.
const RATE: f64 = 10.0;
/// Most frames that are written.
const MOST: u64 = 48;
/// Length of scenes that say none \[s\].
const DEFAULT_DURATION: f64 = 2.0;

/// The frames of a scene that are written.
pub struct Animation<'a> {
    /// The scene, by file or name.
    pub scene: &'a str,
    /// Size of the images \[pixels\]; none: 512 × 512.
    pub size: Option<[u32; 2]>,
    /// How quiet they are.
    pub quality: &'a QualityArgs,
    /// Choices that change them.
    pub look: &'a LookArgs,
}

/// Renders the scene's animation into `out/NAME/`; `why` says why no window opens.
///
/// # Errors
/// If the scene cannot be loaded or drawn, or a file cannot be written.
pub fn run(args: &Animation, common: &Common, why: &str) -> Result<()> {
    let images = Images::choose(None, args.quality, Quality::Fast, args.look, false)?;
    let mut session = Session::headless(args.scene, args.look, common)?;
    let duration = session.settings().duration.map_or(DEFAULT_DURATION, f64::from);
    let count = ((duration * RATE).round() as u64).clamp(1, MOST);
    let folder = Path::new("out").join(session.name());
    let shot = Shot { size: args.size.unwrap_or([512, 512]), images, linear: false };
    say!("{why}: rendering {count} frames of `{}` into {}/ ...", session.name(), folder.display());
    let bar = progress::bar(count, "rendering frames");
    let mut sequence = Sequence::start(&mut session)?;
    for index in 0..count {
        session.set_seconds(index as f64 / RATE);
        sequence.take(numbered(&folder.join("frame.png"), index + 1), &shot, &mut session)?;
        bar.inc(1);
    }
    let tally = sequence.finish(&session)?;
    bar.finish_and_clear();
    if let Some(sentence) = tally.sentence() {
        say!("{sentence}");
    }
    let place = folder.canonicalize().unwrap_or(folder);
    say!("wrote {count} frames, 0.1 s apart: {}", place.join("frame_0001.png").display());
    Ok(())
}
