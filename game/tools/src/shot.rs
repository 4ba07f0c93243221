//! How an image for a file is taken: of how many frames, and of which kind.

use crate::capture::Sampling;
use crate::cli::{Quality, QualityArgs};
use crate::still::{self, Goal, Outcome, Progress};
use crate::{capture, jitter};
use anyhow::{Result, bail};
use lightwell::gpu::Gpu;
use lightwell::render::GiMethod;
use lightwell::scene::SceneView;
use lightwell_runtime::cli::{LookArgs, Switch};
use lightwell_runtime::progress::Bar;
use lightwell_runtime::session::{PendingPicture, Session};
use lightwell_runtime::writer::Picture;

/// Which frames an image is the mean of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Images {
    /// So many with shifted pixel grids; one alone is not shifted.
    Count(Sampling),
    /// As many as it takes.
    Until(Goal),
}

impl Images {
    /// What the command line asks for: `aa` frames if it says so, else one, or, for a display image of light, as many as its
    /// quality takes.
    ///
    /// # Errors
    /// If a quality is asked for of an image that has none.
    pub fn choose(
        aa: Option<u32>,
        quality: &QualityArgs,
        default: Quality,
        look: &LookArgs,
        linear: bool,
    ) -> Result<Self> {
        let alone = if look.gi == Some(GiMethod::REFERENCE) {
            Some("path tracing takes as many samples as --spp says: give --spp N")
        } else if !look.only.is_light() {
            Some("--only albedo, normal and depth have no noise: leave it out, or give --aa N for smooth edges")
        } else if !look.debug.is_empty() {
            Some("--debug draws over a single frame: leave one of the two out")
        } else if look.average == Some(Switch::On) {
            Some("--average on goes on with the frames before, each a single one: leave one of the two out")
        } else {
            None
        };
        let edges = quality.edges.unwrap_or(1);
        if let Some(why) = alone.filter(|_| edges > 1) {
            bail!("--edges does not apply: {why}");
        }
        let of_file = "an .exr image is a single frame, or as many as --aa asks for: write a .png file, or give --aa N";
        let fixed = if linear { Some(of_file) } else { alone };
        match (aa, fixed, quality.given()) {
            (Some(images), _, _) => Ok(Self::Count(Sampling { images, edges })),
            (None, Some(why), Some(option)) => bail!("{option} does not apply: {why}"),
            (None, Some(_), None) => Ok(Self::Count(Sampling { images: 1, edges })),
            (None, None, _) => Ok(Self::Until(Goal::new(quality, default))),
        }
    }

    /// How many there will be, as far as is known before the first.
    pub fn expected(&self) -> u64 {
        match self {
            Self::Count(sampling) => u64::from(sampling.frames()),
            Self::Until(goal) => u64::from(goal.least),
        }
    }
}

/// How far an image is.
#[derive(Clone, Copy, Debug)]
pub enum Step {
    /// A frame more is done.
    Frame,
    /// The average of unknown length has come so far.
    Average(Progress),
}

impl Step {
    /// Moves the bar on.
    pub fn show_on(self, bar: &Bar) {
        let Self::Average(progress) = self else { return bar.inc(1) };
        bar.set_length(u64::from(progress.expected));
        bar.set_position(u64::from(progress.images));
        if let Some(estimate) = progress.estimate {
            bar.set_message(format!("rendering, estimated error {:.4}", estimate.mean));
        }
    }
}

/// How an image is taken.
pub struct Shot {
    /// Size [pixels].
    pub size: [u32; 2],
    /// The frames that are averaged.
    pub images: Images,
    /// Linear radiance instead of what a screen shows.
    pub linear: bool,
}

/// The image that was drawn.
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
    /// Draws the scene as it stands, and says what became of an average of unknown length. `told` hears how far it is.
    ///
    /// # Errors
    /// If the scene cannot be drawn.
    pub fn take(&self, session: &mut Session, told: &mut dyn FnMut(Step)) -> Result<(Picture, Option<Outcome>)> {
        let (taken, outcome) = self.begin(session, told)?;
        Ok((taken.finish(&session.gpu)?, outcome))
    }

    /// The same, and does not wait for an image of one frame to come back.
    ///
    /// # Errors
    /// As [`Shot::take`].
    pub fn begin(&self, session: &mut Session, told: &mut dyn FnMut(Step)) -> Result<(Taken, Option<Outcome>)> {
        let settings = session.render_settings(!self.linear);
        let sampling = match self.images {
            // The tracer filters over the pixel by itself.
            Images::Count(_) if settings.gi == GiMethod::REFERENCE && settings.only.is_light() => Sampling::images(1),
            Images::Count(sampling) => sampling,
            Images::Until(goal) => {
                let told = &mut |progress| told(Step::Average(progress));
                let (image, outcome) = still::average(session, self.size, &settings, goal, told)?;
                return Ok((Taken::Ready(Picture::Linear(image)), Some(outcome)));
            }
        };
        if sampling.frames() == 1 {
            let view = SceneView { camera: session.camera()?, size: self.size, jitter: jitter::shift(0, 1) };
            let settings = if self.linear { settings } else { session.display_settings() };
            session.render(&view, &settings)?;
            told(Step::Frame);
            return Ok((Taken::Coming(session.rendering.begin_reading(self.linear)?), None));
        }
        let told = &mut || told(Step::Frame);
        let image = capture::take_telling(session, self.size, sampling, &settings, told)?;
        Ok((Taken::Ready(Picture::Linear(image)), None))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use lightwell::render::debug::DebugView;
    use lightwell_runtime::cli::{DebugArgs, Only};

    #[test]
    fn what_has_no_quality_says_so() {
        let look = LookArgs::default();
        let asked = QualityArgs { quality: Some(Quality::Best), time_limit: None, edges: None };
        let choose = |aa, quality: &QualityArgs, look: &LookArgs, linear| {
            Images::choose(aa, quality, Quality::Good, look, linear)
        };
        let plain = QualityArgs::default();
        assert!(matches!(choose(None, &plain, &look, false), Ok(Images::Until(goal)) if goal.bound == 0.02));
        assert!(matches!(choose(None, &asked, &look, false), Ok(Images::Until(goal)) if goal.bound == 0.01));
        assert_eq!(choose(Some(3), &plain, &look, false).unwrap(), Images::Count(Sampling::images(3)));
        let debug = DebugArgs { views: vec![DebugView::Lights], ..DebugArgs::default() };
        let cases = [
            (look.clone(), true, "give --aa N"),
            (LookArgs { gi: Some(GiMethod::REFERENCE), ..look.clone() }, false, "--spp"),
            (LookArgs { only: Only::Depth, ..look.clone() }, false, "--only"),
            (LookArgs { debug, ..look.clone() }, false, "--debug"),
            (LookArgs { average: Some(Switch::On), ..look.clone() }, false, "--average on"),
        ];
        for (look, linear, expected) in cases {
            assert_eq!(choose(None, &plain, &look, linear).unwrap(), Images::Count(Sampling::images(1)), "{expected}");
            let error = format!("{:#}", choose(None, &asked, &look, linear).unwrap_err());
            assert!(error.starts_with("--quality does not apply: ") && error.contains(expected), "{error}");
        }
        let limited = QualityArgs { quality: None, time_limit: Some(1.0), edges: None };
        let error = format!("{:#}", choose(None, &limited, &look, true).unwrap_err());
        assert!(error.starts_with("--time-limit does not apply"), "{error}");
    }
}
