//! Runs one scene test.

use super::discover::TestCase;
use super::document::{ErrorBound, FrameExpectation, Reference, SceneTest, Traced, Which, applies};
use super::images::{self, Expected, GoldenVerdict, Pictures};
use super::{frames, place, place::Place};
use crate::capture;
use anyhow::{Context, Error, Result};
use lightwell::files::{FileError, FileErrorKind};
use lightwell::gpu::Gpu;
use lightwell::measure::{Image, read_image};
use lightwell::render::reference::TraceSettings;
use lightwell::render::{Layer, RenderSettings};
use lightwell::scene::SceneView;
use lightwell_runtime::cli::Common;
use lightwell_runtime::session::{Session, open_gpu};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// How tests are run.
#[derive(Clone, Debug)]
pub struct Options {
    /// Models and adapter.
    pub common: Common,
    /// Keep what is drawn as golden images.
    pub bless: bool,
    /// Folder of the images of failures.
    pub output: PathBuf,
}

/// The report of a test.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// All holds.
    Passed,
    /// The failed checks, in words.
    Failed(Vec<String>),
    /// Not all could be checked, and why; what could be, holds.
    Skipped(String),
}

/// A test that was run.
#[derive(Clone, Debug)]
pub struct Report {
    /// Its outcome.
    pub outcome: Outcome,
    /// Golden images that were written.
    pub blessed: Vec<PathBuf>,
    /// How long it took.
    pub elapsed: Duration,
}

/// Runs a test. It takes the device and puts it back unless something went wrong with it; where there is none, one is
/// opened.
pub fn run(case: &TestCase, options: &Options, device: &mut Option<Arc<Gpu>>) -> Report {
    let start = Instant::now();
    let mut findings = Findings::default();
    if let Err(error) = attempt(case, options, device, &mut findings) {
        match reason_to_skip(&error) {
            Some(reason) => findings.skips.push(reason),
            None => findings.faults.push(format!("{error:#}")),
        }
    }
    let Findings { faults, skips, blessed } = findings;
    let outcome = match (faults.is_empty(), skips.is_empty()) {
        (false, _) => Outcome::Failed(faults),
        (true, false) => Outcome::Skipped(skips.join("; ")),
        (true, true) => Outcome::Passed,
    };
    Report { outcome, blessed, elapsed: start.elapsed() }
}

/// The findings of a test.
#[derive(Default)]
struct Findings {
    faults: Vec<String>,
    skips: Vec<String>,
    blessed: Vec<PathBuf>,
}

/// A third-party model that is not there is no fault of the program.
fn reason_to_skip(error: &Error) -> Option<String> {
    let error = error.downcast_ref::<FileError>()?;
    (error.kind == FileErrorKind::MissingModel).then(|| {
        let help = error.help.as_deref().map(|help| format!(": {help}")).unwrap_or_default();
        format!("{}{help}", error.message)
    })
}

fn attempt(case: &TestCase, options: &Options, device: &mut Option<Arc<Gpu>>, findings: &mut Findings) -> Result<()> {
    let test = SceneTest::read(&case.path)?;
    let scene = match place::scene(&test.scene, case.folder(), &options.common)? {
        Place::File(path) => path,
        Place::NotGiven(reason) => {
            findings.skips.push(reason);
            return Ok(());
        }
    };
    let open = |gpu| Session::open(gpu, &scene.to_string_lossy(), &test.look(), &options.common);
    let gpu = device.take().map_or_else(|| open_gpu(&options.common).map(Arc::new), Ok)?;
    let mut stage = Stage { case, test: &test, options, findings, session: open(gpu)? };
    let images = test.times.iter().map(|&time| stage.check(time)).collect::<Result<Vec<Image>>>()?;
    let Stage { session, .. } = stage;
    let mut gpu = session.gpu;
    if test.expect.deterministic {
        let mut again = Stage { case, test: &test, options, findings, session: open(gpu)? };
        // Something else is drawn before, so that what a frame leaves behind would show.
        if let [time] = test.times[..] {
            again.session.set_seconds(time + 1.0);
            let settings = again.session.render_settings(false);
            capture::take(&mut again.session, test.size, test.aa, &settings)?;
        }
        for (&time, first) in test.times.iter().zip(&images).rev() {
            again.check_equal(time, first)?;
        }
        gpu = again.session.gpu;
    }
    *device = Some(gpu);
    Ok(())
}

/// A test with its loaded scene.
struct Stage<'a> {
    case: &'a TestCase,
    test: &'a SceneTest,
    options: &'a Options,
    findings: &'a mut Findings,
    session: Session,
}

impl Stage<'_> {
    /// Checks all that must hold at a time; gives the radiance.
    fn check(&mut self, time: f64) -> Result<Image> {
        self.session.set_seconds(time);
        let settings = self.session.render_settings(true);
        let camera = self.session.camera()?;
        let view = SceneView { camera, size: self.test.size, jitter: [0.0; 2] };
        let expected: Vec<&FrameExpectation> =
            self.test.expect.frames.iter().filter(|frame| applies(frame.at.as_deref(), time)).collect();
        for which in [Which::First, Which::Again] {
            let frames = expected.iter().filter(|frame| frame.frame == which).copied();
            let frames: Vec<&FrameExpectation> = frames.collect();
            // The first frame is drawn in any case: its image may be the one that is looked at.
            if which == Which::Again && frames.is_empty() {
                continue;
            }
            // Extraction again, as in any other frame: nothing changed, so that it must find nothing.
            self.session.set_seconds(time);
            let report = self.session.render(&view, &settings)?;
            let prefix = if which == Which::First { "first frame" } else { "second frame" };
            let faults = frames.into_iter().flat_map(|frame| frames::check(frame, &report));
            faults.for_each(|fault| self.findings.faults.push(format!("at {time} s, {prefix}: {fault}")));
        }
        let radiance = self.radiance(&settings)?;
        self.finite(time, &radiance, Layer::Total)?;
        self.check_golden(time, &settings)?;
        self.check_errors(time, &radiance, &settings)?;
        Ok(radiance)
    }

    /// Radiance of the last frame, or averaged over frames.
    fn radiance(&mut self, settings: &RenderSettings) -> Result<Image> {
        match self.test.aa {
            1 => self.session.radiance(),
            aa => capture::take(&mut self.session, self.test.size, aa, &without_display(settings)),
        }
    }

    fn check_golden(&mut self, time: f64, settings: &RenderSettings) -> Result<()> {
        let expected = self.test.expect.golden.as_ref();
        let Some(golden) = expected.filter(|golden| applies(golden.at.as_deref(), time)) else { return Ok(()) };
        let actual = match self.test.aa {
            1 => capture::display(&self.session)?,
            aa => capture::take(&mut self.session, self.test.size, aa, settings)?,
        };
        let (file, pictures) = (self.case.golden(time), self.pictures(time, "golden"));
        let golden = golden.on(self.session.gpu.info.device_type);
        match images::check_golden(&actual, &file, &golden, self.options.bless, &pictures)? {
            GoldenVerdict::Same => {}
            GoldenVerdict::Blessed => self.findings.blessed.push(file),
            GoldenVerdict::Wrong(what) => self.fault(time, &what),
        }
        Ok(())
    }

    fn check_errors(&mut self, time: f64, total: &Image, settings: &RenderSettings) -> Result<()> {
        let bounds = self.test.expect.errors.iter().filter(|bound| applies(bound.at.as_deref(), time));
        for (index, bound) in bounds.enumerate() {
            let layer = bound.layer.layer();
            let image = match layer {
                Layer::Total => total.clone(),
                _ => {
                    let settings = RenderSettings { only: layer, ..without_display(settings) };
                    capture::take(&mut self.session, self.test.size, self.test.aa, &settings)?
                }
            };
            self.finite(time, &image, layer)?;
            self.check_error(time, &image, bound, index)?;
        }
        Ok(())
    }

    fn check_error(&mut self, time: f64, image: &Image, bound: &ErrorBound, index: usize) -> Result<()> {
        let Some((expected, against)) = self.expected(bound)? else { return Ok(()) };
        let name = bound.layer.name();
        let pictures = self.pictures(time, &format!("{name}_{index}"));
        if let Some(what) = images::check_errors(image, &expected, &bound.max, &pictures)? {
            self.fault(time, &format!("{name} light against {against}: {what}"));
        }
        Ok(())
    }

    /// The reference, and what to call it; none if its folder is not given.
    fn expected(&mut self, bound: &ErrorBound) -> Result<Option<(Expected, String)>> {
        match &bound.reference {
            Reference::Image(written) => match place::file(written, self.case.folder(), &self.options.common) {
                Place::File(path) => {
                    let image = read_image(&path).context("the reference")?;
                    Ok(Some((Expected { image, halves: None }, written.clone())))
                }
                Place::NotGiven(reason) => {
                    // Once, and not at every time.
                    if !self.findings.skips.contains(&reason) {
                        self.findings.skips.push(reason);
                    }
                    Ok(None)
                }
            },
            Reference::Traced(traced) => self.trace(traced, bound.layer.layer()).map(Some),
        }
    }

    fn trace(&mut self, traced: &Traced, layer: Layer) -> Result<(Expected, String)> {
        let view = SceneView { camera: self.session.camera()?, size: self.test.size, jitter: [0.0; 2] };
        let settings = TraceSettings { bounces: traced.bounces, seed: traced.seed };
        let estimate = self.session.trace(&view, &settings, traced.samples, &mut |_| {})?;
        let image = match layer {
            Layer::Direct => estimate.direct(),
            Layer::Indirect => estimate.indirect(),
            _ => estimate.total(),
        };
        let expected = Expected { image, halves: Some(estimate.halves(layer)) };
        Ok((expected, format!("{} traced samples a pixel", estimate.samples)))
    }

    /// Draws the time again; the bits must be the same.
    fn check_equal(&mut self, time: f64, first: &Image) -> Result<()> {
        self.session.set_seconds(time);
        let settings = self.session.render_settings(false);
        let second = capture::take(&mut self.session, self.test.size, self.test.aa, &settings)?;
        let pictures = self.pictures(time, "second_run");
        if let Some(what) = images::check_equal(first, &second, &pictures)? {
            self.fault(time, &what);
        }
        Ok(())
    }

    fn finite(&mut self, time: f64, image: &Image, layer: Layer) -> Result<()> {
        let what = format!("{layer:?}").to_lowercase();
        let pictures = self.pictures(time, &format!("{what}_not_finite"));
        if let Some(what) = images::non_finite(image, &format!("{what} light"), &pictures)? {
            self.fault(time, &what);
        }
        Ok(())
    }

    fn fault(&mut self, time: f64, what: &str) {
        self.findings.faults.push(format!("at {time} s: {what}"));
    }

    fn pictures(&self, time: f64, what: &str) -> Pictures {
        Pictures::new(Path::new(&self.options.output), format!("{}_{time}s_{what}", self.case.name))
    }
}

fn without_display(settings: &RenderSettings) -> RenderSettings {
    RenderSettings { display: false, ..settings.clone() }
}
