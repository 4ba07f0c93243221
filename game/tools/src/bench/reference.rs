//! The path-traced images that everything is measured against: stored with the source, cached, or traced now.

use super::reference_file::{self, Stored};
use anyhow::{Context, Result};
use lightwell::render::reference::{Estimate, TraceSettings};
use lightwell::scene::SceneView;
use lightwell_runtime::session::Session;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Seed of all references, another one than that of the path tracing that is measured.
const SEED: u32 = 0x1157;
/// How often a half-done image is kept.
const SAVE_EVERY: Duration = Duration::from_secs(20);

/// Where references lie.
#[derive(Clone, Debug)]
pub struct References {
    /// Folder of those that were traced by earlier runs.
    pub cache: PathBuf,
    /// Folder of those that come with the source.
    pub stored: Option<PathBuf>,
    /// Write what is traced into the latter.
    pub bless: bool,
}

/// The settings of a reference beside its scene.
pub struct Wanted<'a> {
    /// Name of the scene.
    pub scene: &'a str,
    /// Time [s], for the name of the file.
    pub time: f64,
    /// Image size [pixels].
    pub size: [u32; 2],
    /// Indirect bounces; none: unlimited.
    pub bounces: Option<u32>,
    /// Samples a pixel, at least.
    pub samples: u32,
}

/// A reference, and what the reader should know of it.
pub struct Found {
    /// The image.
    pub estimate: Estimate,
    /// Why the stored one was not taken, if it was not.
    pub note: Option<String>,
}

impl Wanted<'_> {
    /// Name of the file without its ending.
    fn name(&self) -> String {
        let [width, height] = self.size;
        let bounces = self.bounces.map_or(String::new(), |bounces| format!("_k{bounces}"));
        format!("{}_{:.0}ms_{width}x{height}{bounces}", self.scene, 1e3 * self.time)
    }
}

impl References {
    /// The folder of references in the source tree, in the current folder or above it.
    pub fn stored_folder() -> Option<PathBuf> {
        let current = std::env::current_dir().ok();
        let above = current.iter().flat_map(|dir| dir.ancestors());
        let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        let folders = above.map(Path::to_owned).chain([source]).map(|dir| dir.join("tests/references/bench"));
        folders.into_iter().find(|dir| dir.is_dir())
    }

    /// Finds the reference of the scene as it stands, or traces it; `progress` is told of the samples that are done.
    ///
    /// # Errors
    /// If it cannot be traced, or a file not be read or written.
    pub fn get(&self, session: &mut Session, wanted: &Wanted, progress: &mut dyn FnMut(u32)) -> Result<Found> {
        let view = SceneView { camera: session.camera()?, size: wanted.size, jitter: [0.0; 2] };
        let settings = TraceSettings { bounces: wanted.bounces, seed: SEED };
        let key = session.content_key(&view, &settings);
        let name = wanted.name();
        let fits = |stored: &Stored| stored.key == key && stored.estimate.samples >= wanted.samples;
        let mut note = None;
        if let Some(folder) = self.stored.as_ref() {
            let path = folder.join(format!("{name}.exr"));
            match reference_file::read(&path)? {
                Some(stored) if fits(&stored) => return Ok(Found { estimate: stored.estimate, note }),
                Some(stored) if !self.bless => note = Some(stale(&path, &stored, key)),
                _ => {}
            }
        }
        let cached = self.cache.join(format!("{name}_{:016x}.exr", (key >> 64) as u64 ^ key as u64));
        let estimate = match reference_file::read(&cached)? {
            Some(stored) if fits(&stored) => stored.estimate,
            _ => {
                let estimate = self.trace(session, (&view, &settings, key), &cached, wanted.samples, progress)?;
                reference_file::write(&cached, &Stored { key, estimate: estimate.clone() }, false)?;
                estimate
            }
        };
        if let (Some(folder), true) = (self.stored.as_ref(), self.bless) {
            let stored = Stored { key, estimate: estimate.clone() };
            reference_file::write(&folder.join(format!("{name}.exr")), &stored, true)?;
        }
        Ok(Found { estimate, note })
    }

    /// Traces the image; what is half done lies in a file, so that an interrupted run loses little.
    fn trace(
        &self,
        session: &mut Session,
        (view, settings, key): (&SceneView, &TraceSettings, u128),
        cached: &Path,
        samples: u32,
        progress: &mut dyn FnMut(u32),
    ) -> Result<Estimate> {
        let folder = &self.cache;
        std::fs::create_dir_all(folder).with_context(|| format!("cannot make the folder {}", folder.display()))?;
        let half_done = cached.with_extension("trace");
        session.begin_trace(view, settings)?.0.tracer.restart();
        let (mut tracing, _) = session.begin_trace(view, settings)?;
        let mut done = tracing.resume(&half_done, key)?;
        let mut saved = Instant::now();
        while done < samples {
            done = samples.min(done + 16);
            tracing.advance_to(done, progress)?;
            if saved.elapsed() > SAVE_EVERY {
                tracing.save(&half_done, key)?;
                saved = Instant::now();
            }
        }
        let estimate = tracing.estimate()?;
        match std::fs::remove_file(&half_done) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
                log::warn!("cannot remove {}: {error}", half_done.display());
            }
            _ => {}
        }
        Ok(estimate)
    }
}

fn stale(path: &Path, stored: &Stored, key: u128) -> String {
    let file = path.file_name().unwrap_or_default().to_string_lossy();
    match stored.key == key {
        true => {
            format!("the stored reference {file} has only {} samples a pixel: traced anew", stored.estimate.samples)
        }
        false => format!(
            "the stored reference {file} is of another state of the scene, camera or tracer: traced anew; --bless stores it"
        ),
    }
}
