//! The measurements of a scene, step by step.

use super::super::error::{layer_error, mean};
use super::super::picture;
use super::super::reference::{References, Wanted};
use super::super::variant::Variant;
use super::{CastRow, Course, DrawRow, ErrorRow, Picture, SceneResults};
use crate::capture;
use anyhow::{Context, Result, bail};
use lightwell::files::SceneInfo;
use lightwell::gpu::Gpu;
use lightwell::graph::{FrameReport, PassState};
use lightwell::measure::Image;
use lightwell::render::vpl::{IntersectionCounts, virtual_lights};
use lightwell::render::{GiMethod, Layer, RenderSettings};
use lightwell::scene::SceneView;
use lightwell_runtime::cli::Common;
use lightwell_runtime::session::Session;
use std::fmt;
use std::path::Path;
use std::sync::Arc;

/// The name of the settings that follow the report.
const PRESET: &str = "report";
/// Time of everything \[s\].
const MOMENT: f64 = 1.0;
/// Image of frames of which only the counts matter [pixels].
const SMALL: [u32; 2] = [16; 2];
/// Particles whose intersection tests are counted.
const CASTS: [u32; 6] = [10, 16, 64, 256, 1024, 4096];
/// Particles of frames whose draws are counted.
const DRAWS: [u32; 4] = [1, 10, 32, 100];
/// Particles of images whose error is taken.
const ERRORS: [u32; 5] = [4, 16, 64, 256, 1024];
/// Most virtual lights that are shown one by one, and so many a row.
const SINGLE: (u32, u32) = (18, 6);
/// Particles whose ways are shown.
const PATHS: u32 = 10;

/// Changes of a setting, as `--set` writes them.
type Sets<'a> = &'a [(&'a str, &'a str)];

/// Settings whose errors are compared: a name, whether they begin with the report's, and changes.
type Settings = (&'static str, bool, Sets<'static>);
const PHYSICAL: (&str, &str) = ("vpl.shading", "Physical");
/// All in one pass: the same image sooner.
const BATCHED: (&str, &str) = ("vpl.accumulation", "Batched");
pub(super) const VARIANTS: [Settings; 4] = [
    ("as the report", true, &[BATCHED]),
    ("its particles, with the geometry term", true, &[BATCHED, PHYSICAL]),
    ("its particles, with geometry and shadow rays", true, &[BATCHED, PHYSICAL, ("vpl.visibility", "ShadowRays")]),
    ("our defaults", false, &[]),
];

/// One measurement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Step {
    /// Intersection tests of so many particles.
    Casts(u32),
    /// Draws of a frame of so many.
    Draws(u32),
    /// The main light, single virtual lights, and ways of particles.
    Pictures,
    /// Error of settings with so many particles.
    Error(&'static Settings, u32),
}

impl fmt::Display for Step {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Casts(particles) => write!(f, "casts of {particles} particles"),
            Self::Draws(particles) => write!(f, "draws for {particles} particles"),
            Self::Pictures => f.write_str("pictures"),
            Self::Error((what, ..), particles) => write!(f, "error of {particles} particles, {what}"),
        }
    }
}

impl Step {
    /// All of a scene, what is quick first.
    pub(super) fn all() -> Vec<Self> {
        let errors = VARIANTS.iter().flat_map(|settings| ERRORS.map(|particles| Self::Error(settings, particles)));
        let counts = CASTS.into_iter().map(Self::Casts).chain(DRAWS.into_iter().map(Self::Draws));
        counts.chain([Self::Pictures]).chain(errors).collect()
    }

    /// Whether the results have it, taken in the same way.
    pub(super) fn is_done(&self, results: &SceneResults, course: &Course, folder: &Path) -> bool {
        let words = course.in_words();
        match *self {
            Self::Casts(particles) => results.casts.iter().any(|row| row.particles == particles),
            Self::Draws(particles) => results.draws.iter().any(|row| row.particles == particles),
            Self::Pictures => {
                let there = |picture: &Picture| picture.course == words && folder.join(&picture.file).is_file();
                !results.pictures.is_empty() && results.pictures.iter().all(there)
            }
            Self::Error((what, ..), particles) => {
                let same =
                    |row: &ErrorRow| (row.what == *what, row.particles, &row.course) == (true, particles, &words);
                results.errors.iter().any(same)
            }
        }
    }

    /// Takes it and puts it into the results, in place of what an earlier run left of it.
    pub(super) fn take(&self, stage: &Stage, course: &Course, folder: &Path, results: &mut SceneResults) -> Result<()> {
        match *self {
            Self::Casts(particles) => results.casts.push(stage.casts(particles)?),
            Self::Draws(particles) => results.draws.push(stage.draws(particles)?),
            Self::Pictures => results.pictures = stage.pictures(course, folder)?,
            Self::Error(settings, particles) => {
                results.errors.retain(|row| (row.what.as_str(), row.particles) != (settings.0, particles));
                results.errors.push(stage.error(settings, particles, course)?);
            }
        }
        Ok(())
    }
}

/// A scene with a preset of the report.
pub(super) struct Stage {
    first: Session,
}

impl Stage {
    /// Loads a scene.
    ///
    /// # Errors
    /// If it cannot be loaded or has no such preset.
    pub(super) fn open(gpu: &Arc<Gpu>, scene: &str, common: &Common) -> Result<Self> {
        let first = Session::open(Arc::clone(gpu), scene, &Variant::path_tracing(1).look(None), common)?;
        let info = first.world().ecs.get_resource::<SceneInfo>();
        if !info.is_some_and(|info| info.presets.contains_key(PRESET)) {
            bail!("the scene `{scene}` has no preset `{PRESET}`: --instant-radiosity measures scenes that list one");
        }
        Ok(Self { first })
    }

    /// Name of the scene.
    pub(super) fn name(&self) -> String {
        self.first.name()
    }

    /// The scene at the moment, in the report's settings or its own, with so many particles and further changes. Its sky
    /// is left out, which the report does not have.
    pub(super) fn session(&self, as_report: bool, particles: u32, sets: Sets) -> Result<Session> {
        let (dark, preset) = (("scene.sky", "(0, 0, 0)"), ("preset", PRESET));
        let owned = |&(path, value): &(&str, &str)| (path.to_owned(), value.to_owned());
        let preset = Some(preset).filter(|_| as_report);
        let mut all: Vec<_> = std::iter::once(&dark).chain(preset.as_ref()).map(owned).collect();
        all.push(("vpl.particles".to_owned(), particles.to_string()));
        all.extend(sets.iter().map(owned));
        let mut session = self.first.again(&Variant::new(PRESET, GiMethod::VPL, all).look(None))?;
        session.set_seconds(MOMENT);
        Ok(session)
    }

    fn casts(&self, particles: u32) -> Result<CastRow> {
        let mut row = CastRow { particles, ..Default::default() };
        for casts in ["BruteForce", "Hierarchy", "Bounds"] {
            let mut session = self.session(true, particles, &[BATCHED, ("vpl.casts", casts)])?;
            draw(&mut session, SMALL, Layer::Indirect)?;
            let lights = virtual_lights(session.rendering.renderer.methods()).context("no particle was shot")?;
            let found = lights.particles();
            let IntersectionCounts { rays, objects, triangles, .. } = found.casts;
            match casts {
                "BruteForce" => {
                    row.objects = session.scene().primitives.iter().filter(|object| object.casts_shadow).count() as u64;
                    (row.reflectance, row.lights) = (found.reflectance, found.lights.len() as u64);
                    (row.rays, row.brute_force) = (rays, objects);
                }
                "Hierarchy" => row.hierarchy = found.casts.tests(),
                _ => row.bounds = [objects, triangles],
            }
        }
        Ok(row)
    }

    fn draws(&self, particles: u32) -> Result<DrawRow> {
        let mut session = self.session(true, particles, &[])?;
        let report = draw(&mut session, SMALL, Layer::Total)?;
        let of = |prefix: &str| passes(&report, prefix).map(|pass| pass.counts.draws).sum::<u64>();
        let mut batched = self.session(true, particles, &[BATCHED])?;
        Ok(DrawRow {
            particles,
            lights: passes(&report, "vpl letter").map(|pass| pass.counts.lights).sum(),
            objects: session.scene().primitives.len() as u64,
            shadows: of("shadow "),
            camera: of("gbuffer"),
            virtual_lights: of("vpl letter"),
            batched: draw(&mut batched, SMALL, Layer::Total)?.total().draws,
        })
    }

    /// As the report's figures: the light with its shadows, each virtual light, all together, and ways of particles.
    fn pictures(&self, course: &Course, folder: &Path) -> Result<Vec<Picture>> {
        let mut session = self.session(true, PATHS, &[])?;
        let take = |session: &mut Session, settings: &RenderSettings| {
            capture::take(session, course.size, course.images, settings)
        };
        let settings = |only| RenderSettings { only, ..session.render_settings(false) };
        let (total, direct, indirect) = (settings(Layer::Total), settings(Layer::Direct), settings(Layer::Indirect));
        let all = take(&mut session, &total)?;
        let exposure = picture::exposure(&all);
        let ways = take(&mut session, &RenderSettings { particle_paths: PATHS, ..total })?;
        let whole = [
            (take(&mut session, &direct)?, "the main light".to_owned()),
            (take(&mut session, &indirect)?, "all virtual lights".to_owned()),
            (all, "both".to_owned()),
            (ways, format!("ways of {PATHS} particles")),
        ];
        let lights = virtual_lights(session.rendering.renderer.methods()).context("no particle was shot")?;
        let count = (lights.particles().lights.len() as u32).min(SINGLE.0);
        let words = course.in_words();
        let mut written = Vec::new();
        let mut write = |name: String, what: String, images: &[(Image, String)], exposure| {
            let file = format!("pictures/{}.png", picture::file_name(&format!("{}_{name}", self.name())));
            picture::row(&folder.join(&file), &format!("{}, as the report: {what}", self.name()), images, exposure)?;
            written.push(Picture { what, file, course: words.clone() });
            anyhow::Ok(())
        };
        write("whole".to_owned(), "the parts of the image".to_owned(), &whole, exposure)?;
        for first in (0..count).step_by(SINGLE.1 as usize) {
            let mut images = Vec::new();
            let last = (first + SINGLE.1).min(count);
            for index in first..last {
                let settings = RenderSettings { virtual_light: Some(index), ..indirect.clone() };
                images.push((take(&mut session, &settings)?, format!("virtual light {}", index + 1)));
            }
            let what = format!("virtual lights {} to {last}", first + 1);
            write(format!("lights_{}_to_{last}", first + 1), what, &images, exposure * f64::from(count) / 3.0)?;
        }
        Ok(written)
    }

    fn error(&self, settings: &Settings, particles: u32, course: &Course) -> Result<ErrorRow> {
        let (what, as_report, sets) = *settings;
        let references = References { cache: course.references.clone(), stored: None, bless: false };
        let (name, samples) = (self.name(), course.samples);
        let wanted = Wanted { scene: &name, time: MOMENT, size: course.size, bounces: None, samples };
        // One number of particles for all, so that all share a reference.
        let mut tracer = self.session(false, 1, &[])?;
        let halves = references.get(&mut tracer, &wanted, &mut |_| {})?.estimate.halves(Layer::Indirect);
        let mut session = self.session(as_report, particles, sets)?;
        let wanted = RenderSettings { only: Layer::Indirect, ..session.render_settings(false) };
        let image = capture::take(&mut session, course.size, course.images, &wanted)?;
        let error = layer_error(&image, &halves)?;
        let lights = virtual_lights(session.rendering.renderer.methods()).context("no particle was shot")?;
        Ok(ErrorRow {
            what: what.to_owned(),
            particles,
            lights: lights.particles().lights.len() as u64,
            nrmse: error.nrmse,
            bias: error.bias,
            scaled: layer_error(&scaled_to(&image, &mean(&halves)), &halves)?.nrmse,
            noise: error.noise,
            course: course.in_words(),
        })
    }
}

/// Draws a frame without anything of earlier ones.
fn draw(session: &mut Session, size: [u32; 2], only: Layer) -> Result<FrameReport> {
    let view = SceneView { camera: session.camera()?, size, jitter: [0.0; 2] };
    let settings = RenderSettings { only, no_cache: true, ..session.render_settings(false) };
    session.render(&view, &settings)
}

/// The passes that ran whose names begin so.
fn passes<'a>(report: &'a FrameReport, prefix: &'a str) -> impl Iterator<Item = &'a lightwell::graph::PassReport> {
    report.passes.iter().filter(move |pass| pass.state == PassState::Ran && pass.name.starts_with(prefix))
}

/// The image with the mean of another; as it is where it is black.
fn scaled_to(image: &Image, other: &Image) -> Image {
    let mean = |image: &Image| image.values().map(f64::from).sum::<f64>();
    let factor = if mean(image) > 0.0 { mean(other) / mean(image) } else { 1.0 };
    let mut scaled = image.clone();
    scaled.pixels_mut().iter_mut().flatten().for_each(|value| *value = (f64::from(*value) * factor) as f32);
    scaled
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_image_is_scaled_to_the_mean_of_another() {
        let scaled = scaled_to(&Image::filled(2, 2, [0.5; 3]), &Image::filled(2, 2, [2.0, 1.0, 0.0]));
        assert_eq!(scaled, Image::filled(2, 2, [1.0; 3]));
        let black = Image::filled(2, 2, [0.0; 3]);
        assert_eq!(scaled_to(&black, &scaled), black);
    }

    #[test]
    fn what_was_taken_in_another_way_is_taken_again() {
        let course = Course { size: [8; 2], images: 1, samples: 4, references: "unused".into() };
        let step = Step::Error(&VARIANTS[0], 16);
        let row =
            ErrorRow { what: VARIANTS[0].0.into(), particles: 16, course: course.in_words(), ..Default::default() };
        let results = SceneResults { errors: vec![row], ..Default::default() };
        let done = |step: Step, course: &Course| step.is_done(&results, course, Path::new("."));
        assert!(done(step, &course));
        assert!(!done(Step::Error(&VARIANTS[1], 16), &course) && !done(Step::Error(&VARIANTS[0], 64), &course));
        assert!(!done(step, &Course { samples: 8, ..course.clone() }));
        assert!(!done(Step::Pictures, &course) && !done(Step::Casts(16), &course));
    }
}
