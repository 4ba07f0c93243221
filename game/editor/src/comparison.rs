//! The reference beside the picture: how both are shown, and how far one is from the other.

use anyhow::{Context, Result};
use lightwell::measure::two_halves;
use lightwell::render::reference::TraceSettings;
use lightwell::render::{Beside, Layer, ReferenceSettings, RenderSettings, Shown};
use lightwell::scene::SceneView;
use lightwell_runtime::cli::TraceArgs;
use lightwell_runtime::session::Session;

/// What the window shows while the reference is traced.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mode {
    /// The drawn picture.
    Drawn,
    /// The path-traced one.
    Traced,
    /// The drawn one on the left of a line, the path-traced one on the right.
    #[default]
    Wipe,
    /// Drawn minus traced.
    Difference,
}

impl Mode {
    /// All of them with their names and what they show.
    pub const ALL: [(Self, &'static str, &'static str); 4] = [
        (Self::Wipe, "wipe", "drawn on the left, path-traced on the right; drag the line in the picture"),
        (Self::Difference, "difference", "red where the drawn picture is too bright, blue where it is too dark"),
        (Self::Drawn, "drawn", "the drawn picture alone, while the reference goes on"),
        (Self::Traced, "traced", "the path-traced picture alone"),
    ];
}

/// The reference beside the picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// Whether it is traced.
    pub on: bool,
    /// What is shown.
    pub mode: Mode,
    /// Share of the width that the wipe leaves to the drawn picture.
    pub share: f32,
    /// Error that the difference shows in full colour, relative to the mean of the reference.
    pub full: f32,
    /// Mean of the reference as it was last measured [W/(m² sr)].
    mean: Option<f32>,
}

impl Default for Comparison {
    fn default() -> Self {
        Self { on: false, mode: Mode::default(), share: 0.5, full: 1.0, mean: None }
    }
}

impl Comparison {
    /// What the renderer is asked for. Every frame adds one sample, so that the window stays alive.
    pub fn beside(&self, trace: &TraceArgs) -> Option<Beside> {
        let shown = match self.mode {
            Mode::Drawn => Shown::Wipe(1.0),
            Mode::Traced => Shown::Wipe(0.0),
            Mode::Wipe => Shown::Wipe(self.share),
            Mode::Difference => Shown::Difference(self.full * self.mean.unwrap_or(1.0)),
        };
        let settings = TraceSettings { bounces: trace.bounces, seed: trace.seed };
        let reference = ReferenceSettings { trace: settings, samples: trace.spp, samples_a_frame: 1 };
        self.on.then_some(Beside { reference, shown })
    }
}

/// Error of one layer of light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LayerError {
    /// Root mean square error relative to the reference's mean, free of the reference's noise.
    pub nrmse: f64,
    /// Relative error of the mean; positive: too bright.
    pub bias: f64,
    /// Standard error of the reference's pixels relative to its mean.
    pub noise: f64,
}

/// Error of the picture against the running reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LiveError {
    /// Samples a pixel of the reference.
    pub samples: u32,
    /// All light.
    pub total: LayerError,
    /// Indirect light alone, the hard part.
    pub indirect: LayerError,
}

impl Comparison {
    /// Measures the drawn picture of a view against what was traced of it so far. Draws the layers once more, of which
    /// only the last step is made anew.
    ///
    /// # Errors
    /// If nothing was traced of this view, or the device fails.
    pub fn measure(&mut self, session: &mut Session, view: &SceneView) -> Result<LiveError> {
        let (samples, _) = session.tracing().context("no reference is being traced")?;
        let [total, indirect] = [Layer::Total, Layer::Indirect].map(|only| layer_error(session, view, only));
        let (total, indirect) = (total?, indirect?);
        self.mean = Some(total.1).filter(|mean| *mean > 0.0);
        Ok(LiveError { samples, total: total.0, indirect: indirect.0 })
    }
}

/// Error of a layer, and the mean of the reference.
fn layer_error(session: &mut Session, view: &SceneView, only: Layer) -> Result<(LayerError, f32)> {
    let settings = RenderSettings { only, ..session.render_settings(false) };
    session.render(view, &settings)?;
    let image = session.radiance()?;
    let tracer = session.rendering.renderer.tracer().context("no reference is being traced")?;
    let [even, odd] = tracer.estimate(&session.gpu)?.halves(only);
    let measured = two_halves(&image, &even, &odd)?;
    let mean = 0.5 * (even.mean() + odd.mean());
    // Where the reference is black, relative to nothing: zero if the image is black too.
    let ratio = |value: f64| if mean > 0.0 { value / mean - 1.0 } else { value };
    let error = LayerError { nrmse: measured.nrmse, bias: ratio(image.mean()), noise: measured.noise };
    Ok((error, mean as f32))
}
