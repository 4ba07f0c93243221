//! A scene test as its file holds it. The [module](super) describes the format.

use super::count::CountBounds;
use lightwell::files::{Document, FileError, FileErrorKind as Kind, Step};
use lightwell::render::{GiMethod, Layer};
use lightwell_runtime::cli::{LookArgs, TraceArgs, parse_assignment};
use serde::de::Error;
use serde::{Deserialize, Deserializer};
use std::collections::BTreeMap;
use std::path::Path;
use wgpu::DeviceType;

/// A scene test: `SceneTest(scene: "…", expect: (…))`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneTest {
    /// What it shows, for people.
    #[serde(default)]
    pub description: String,
    /// The scene: a file, from the test's folder on; a shipped scene by name; or a file below `$LIGHTWELL_MODELS/`
    /// or `$LIGHTWELL_REFERENCE/`.
    pub scene: String,
    /// Times \[s\], in the order in which they are drawn.
    #[serde(default = "at_the_start")]
    pub times: Vec<f64>,
    /// Size of the images \[pixels\].
    #[serde(default = "small")]
    pub size: [u32; 2],
    /// Camera by name; else the scene's primary one.
    #[serde(default)]
    pub camera: Option<String>,
    /// Indirect light; else what the scene asks for.
    #[serde(default, deserialize_with = "method")]
    pub gi: Option<GiMethod>,
    /// Samples, bounces and seed of `gi: Reference`.
    #[serde(default)]
    pub trace: Traced,
    /// Changes to the loaded scene, each `PATH=VALUE` as for `--set`.
    #[serde(default)]
    pub set: Vec<String>,
    /// Frames with shifted pixel grids that are averaged for an image.
    #[serde(default = "one")]
    pub aa: u32,
    /// The checks. Besides them, no pixel may be NaN or infinite.
    #[serde(default)]
    pub expect: Expectations,
}

/// The checks of a test at its times.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Expectations {
    /// Each image looks like its golden one.
    pub golden: Option<Golden>,
    /// Errors against references.
    pub errors: Vec<ErrorBound>,
    /// Expected work of the passes of a frame.
    pub frames: Vec<FrameExpectation>,
    /// A second run gives the same bits.
    pub deterministic: bool,
}

/// Images that were looked at once and are kept in the folder `goldens` beside the test.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Golden {
    /// Largest mean FLIP.
    pub flip: f64,
    /// Largest FLIP of 99 % of the pixels: something small that is wrong, or all edges a little aside.
    pub flip_p99: f64,
    /// Times of the test that it applies to; all if not said.
    pub at: Option<Vec<f64>>,
}

impl Default for Golden {
    fn default() -> Self {
        // Above what drivers differ by, below what an eye sees when the two are shown in turn.
        Self { flip: 0.01, flip_p99: 0.1, at: None }
    }
}

/// How much farther from a golden image another kind of adapter may be: its rays meet other triangles where edges touch,
/// and edges lie elsewhere by up to 1/256 of a pixel. Goldens are made by software drivers.
const OF_OTHER_ADAPTERS: f64 = 2.0;

impl Golden {
    /// The bounds for an adapter of that kind.
    pub fn on(&self, kind: DeviceType) -> Self {
        let factor = if kind == DeviceType::Cpu { 1.0 } else { OF_OTHER_ADAPTERS };
        Self { flip: factor * self.flip, flip_p99: factor * self.flip_p99, at: self.at.clone() }
    }
}

/// A bound on the error against a reference.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ErrorBound {
    /// What is compared: all light, or direct or indirect light alone.
    #[serde(default)]
    pub layer: LightLayer,
    /// The reference.
    pub reference: Reference,
    /// Largest errors.
    pub max: ErrorBounds,
    /// Times of the test that it applies to; all if not said.
    #[serde(default)]
    pub at: Option<Vec<f64>>,
}

/// Layer of light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
pub enum LightLayer {
    /// All light.
    #[default]
    Total,
    /// Straight from lights, and emission and sky.
    Direct,
    /// Light that has met a surface before.
    Indirect,
}

impl LightLayer {
    /// The renderer's layer.
    pub fn layer(self) -> Layer {
        match self {
            Self::Total => Layer::Total,
            Self::Direct => Layer::Direct,
            Self::Indirect => Layer::Indirect,
        }
    }

    /// In file names and messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::Total => "total",
            Self::Direct => "direct",
            Self::Indirect => "indirect",
        }
    }
}

/// The reference of an image.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub enum Reference {
    /// A stored image, `.exr` (or `.png`), from the test's folder on or below `$LIGHTWELL_REFERENCE/`. It may be larger
    /// than the test's images by a whole factor: pixels are then averaged.
    Image(String),
    /// The path tracer's image of the same view.
    Traced(Traced),
}

/// Settings of the path tracer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Traced {
    /// Samples a pixel.
    pub samples: u32,
    /// Indirect bounces; unlimited if not said.
    pub bounces: Option<u32>,
    /// Seed of the random numbers.
    pub seed: u32,
}

impl Default for Traced {
    fn default() -> Self {
        Self { samples: 64, bounces: None, seed: 0 }
    }
}

impl Traced {
    fn check(&self, path: &[Step]) -> Result<(), Fault> {
        // An even number, so that both halves are of equal weight.
        let ok = (2..=1 << 24).contains(&self.samples) && self.samples.is_multiple_of(2);
        let path = [path, &[key("samples")]].concat();
        require(ok, path, &format!("{} samples a pixel", self.samples), "use an even number, 2 to 16777216")
    }
}

/// Largest errors, of bias in size (see [`lightwell::measure`] for the definitions).
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ErrorBounds {
    /// Relative root mean square error.
    pub nrmse: Option<f64>,
    /// Relative error of the mean.
    pub bias: Option<f64>,
    /// Root mean square error [W/(m² sr)].
    pub rmse: Option<f64>,
    /// 95th percentile of the relative error.
    pub p95: Option<f64>,
    /// Mean FLIP.
    pub flip: Option<f64>,
    /// FLIP of 99 % of the pixels.
    pub flip_p99: Option<f64>,
}

impl ErrorBounds {
    /// Names and bounds of the metrics that have one.
    pub fn named(&self) -> impl Iterator<Item = (&'static str, f64)> {
        let all = [
            ("nrmse", self.nrmse),
            ("bias", self.bias),
            ("rmse", self.rmse),
            ("p95", self.p95),
            ("flip", self.flip),
            ("flip_p99", self.flip_p99),
        ];
        all.into_iter().filter_map(|(name, bound)| Some((name, bound?)))
    }
}

/// Expected work of the passes of a frame. Names may hold `*` for any text.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct FrameExpectation {
    /// Which frame.
    pub frame: Which,
    /// Times of the test that it applies to; all if not said.
    pub at: Option<Vec<f64>>,
    /// Passes that must run.
    pub ran: Vec<String>,
    /// Passes whose result must be kept from before.
    pub cached: Vec<String>,
    /// Passes that must be left out because nobody wants what they make.
    pub culled: Vec<String>,
    /// Passes that must be left out, with a reason.
    pub skipped: Vec<String>,
    /// Passes that must not run, for whatever reason, or because there are none of that name.
    pub not_run: Vec<String>,
    /// No pass at all may run.
    pub idle: bool,
    /// Counts of a pass, or summed over all passes that a name with `*` matches; `"*"` is the whole frame.
    pub counts: BTreeMap<String, CountBounds>,
}

/// A frame of a time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
pub enum Which {
    /// The first frame of that time; at the first time of the test nothing is there to be kept.
    #[default]
    First,
    /// A second one, in which nothing has changed.
    Again,
}

/// A method; `None` is one, and not the absence of a value.
fn method<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<GiMethod>, D::Error> {
    let method = GiMethod::deserialize(deserializer)?;
    match GiMethod::BUILT_IN.contains(&method.variant()) {
        true => Ok(Some(method)),
        false => Err(D::Error::unknown_variant(method.variant(), GiMethod::BUILT_IN)),
    }
}

fn at_the_start() -> Vec<f64> {
    vec![0.0]
}

fn small() -> [u32; 2] {
    [128, 128]
}

fn one() -> u32 {
    1
}

impl SceneTest {
    /// Reads and checks a file.
    ///
    /// # Errors
    /// Whatever is wrong with it, with line and column.
    pub fn read(path: &Path) -> Result<Self, FileError> {
        let (document, test) = Document::read::<Self>(path)?;
        test.check().map_err(|fault| fault.error(&document))?;
        Ok(test)
    }

    /// The choices that change the image, as the command line has them.
    pub fn look(&self) -> LookArgs {
        let sets = self.set.iter().filter_map(|text| parse_assignment(text).ok()).collect();
        let Traced { samples, bounces, seed } = self.trace;
        let trace = TraceArgs { spp: samples, bounces, seed };
        LookArgs { gi: self.gi, camera: self.camera.clone(), sets, trace, ..LookArgs::default() }
    }

    /// The times at which there is a golden image.
    pub fn golden_times(&self) -> impl Iterator<Item = f64> {
        let applies_at =
            |time: f64| self.expect.golden.as_ref().is_some_and(|golden| applies(golden.at.as_deref(), time));
        self.times.iter().copied().filter(move |&time| applies_at(time))
    }

    fn check(&self) -> Result<(), Fault> {
        require(
            !self.scene.trim().is_empty(),
            [key("scene")],
            "the scene has no name",
            "name a file or a shipped scene",
        )?;
        require(!self.times.is_empty(), [key("times")], "there is no time", "give at least one, in seconds")?;
        for (i, time) in self.times.iter().enumerate() {
            let ok = time.is_finite() && *time >= 0.0;
            require(ok, [key("times"), Step::Index(i)], &format!("the time is {time}"), "use seconds, zero or more")?;
        }
        for (i, edge) in self.size.iter().enumerate() {
            let ok = (1..=16384).contains(edge);
            require(ok, [key("size"), Step::Index(i)], &format!("{edge} pixels"), "use 1 to 16384 pixels")?;
        }
        require((1..=65536).contains(&self.aa), [key("aa")], &format!("`aa` is {}", self.aa), "use 1 to 65536 frames")?;
        self.trace.check(&[key("trace")])?;
        // The tracer filters over the pixel by itself.
        let averaged = self.gi == Some(GiMethod::REFERENCE) && self.aa > 1;
        require(
            !averaged,
            [key("aa")],
            "path-traced images need no `aa`",
            "leave it out, or raise `trace: (samples: …)`",
        )?;
        for (i, text) in self.set.iter().enumerate() {
            if let Err(message) = parse_assignment(text) {
                return Err(Fault::new([key("set"), Step::Index(i)], format!("`{text}` sets nothing"), message));
            }
        }
        self.check_expectations()
    }

    fn check_expectations(&self) -> Result<(), Fault> {
        let expect = |rest: &[Step]| [&[key("expect")], rest].concat();
        if let Some(golden) = &self.expect.golden {
            let path = expect(&[key("golden")]);
            self.check_times(&path, golden.at.as_deref())?;
            for (name, bound) in [("flip", golden.flip), ("flip_p99", golden.flip_p99)] {
                let ok = (0.0..=1.0).contains(&bound);
                let path = [path.clone(), vec![key(name)]].concat();
                require(ok, path, &format!("the bound is {bound}"), "use a FLIP from 0 to 1")?;
            }
        }
        for (i, bound) in self.expect.errors.iter().enumerate() {
            let path = expect(&[key("errors"), Step::Index(i)]);
            self.check_times(&path, bound.at.as_deref())?;
            if let Reference::Traced(traced) = &bound.reference {
                traced.check(&[path.clone(), vec![key("reference")]].concat())?;
            }
            let max = [path, vec![key("max")]].concat();
            let any = bound.max.named().next().is_some();
            require(any, max.clone(), "no error is bounded", "bound one of nrmse, bias, rmse, p95, flip and flip_p99")?;
            for (name, value) in bound.max.named() {
                let path = [max.clone(), vec![key(name)]].concat();
                require(value >= 0.0, path, &format!("the bound is {value}"), "use a number, zero or more")?;
            }
        }
        for (i, frame) in self.expect.frames.iter().enumerate() {
            let path = expect(&[key("frames"), Step::Index(i)]);
            self.check_times(&path, frame.at.as_deref())?;
            for (name, bounds) in &frame.counts {
                if let Some((count, message)) = bounds.fault() {
                    let path = [path, vec![key("counts"), key(name), key(count)]].concat();
                    return Err(Fault::new(path, message, "give `min` below `max`, or one number".to_owned()));
                }
            }
        }
        Ok(())
    }

    /// Checks that the times are some of the test's.
    fn check_times(&self, path: &[Step], at: Option<&[f64]>) -> Result<(), Fault> {
        for (i, time) in at.unwrap_or_default().iter().enumerate() {
            let path = [path, &[key("at"), Step::Index(i)]].concat();
            let known: Vec<String> = self.times.iter().map(f64::to_string).collect();
            let help = format!("`times` has {}", known.join(", "));
            require(self.times.contains(time), path, &format!("the test draws nothing at {time} s"), &help)?;
        }
        Ok(())
    }
}

/// Whether something that is said of the times `at`, or of all, is said of this one.
pub fn applies(at: Option<&[f64]>, time: f64) -> bool {
    at.is_none_or(|times| times.contains(&time))
}

/// A value that is well formed and still wrong.
struct Fault {
    path: Vec<Step>,
    message: String,
    help: String,
}

impl Fault {
    fn new(path: impl Into<Vec<Step>>, message: String, help: String) -> Self {
        Self { path: path.into(), message, help }
    }

    fn error(self, document: &Document) -> FileError {
        document.error(&self.path, Kind::BadValue, self.message).with_help(self.help)
    }
}

fn require(ok: bool, path: impl Into<Vec<Step>>, message: &str, help: &str) -> Result<(), Fault> {
    if ok { Ok(()) } else { Err(Fault::new(path, message.to_owned(), help.to_owned())) }
}

fn key(name: &str) -> Step {
    Step::Key(name.to_owned())
}
