//! The measurements of a scene.

use super::super::error::{layer_error, mean};
use super::super::picture;
use super::super::reference::{References, Wanted};
use super::super::stage::stage_of;
use super::super::variant::Variant;
use super::published::{STAGES, Scene};
use super::{Course, ErrorRow, SceneResults, Times};
use crate::capture;
use anyhow::Result;
use lightwell::gpu::Gpu;
use lightwell::graph::{FrameReport, PassState};
use lightwell::measure::Image;
use lightwell::render::debug::DebugView;
use lightwell::render::{GiMethod, Layer, RenderSettings};
use lightwell::scene::SceneView;
use lightwell_runtime::cli::{Common, DebugArgs, LookArgs};
use lightwell_runtime::session::Session;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

/// Frames before those that are timed.
const WARM_UP: u32 = 2;
/// Time of errors and pictures \[s\].
const MOMENT: f64 = 1.0;
/// Changes of a setting, as `--set` writes them.
type Sets<'a> = &'a [(&'a str, &'a str)];
/// The settings whose errors are compared, by what they change of those that the thesis evaluated.
const VARIANTS: [(&str, Sets); 12] = [
    ("as evaluated", &[]),
    ("without gradient damping", &[("clpv.gradient_damping", "0")]),
    ("with gradient damping", &[("clpv.gradient_damping", "1")]),
    ("without the gloss march", &[("clpv.gloss_march", "Off")]),
    ("gloss march, weights 1/d", &[("clpv.gloss_march", "InverseDistance")]),
    ("gloss march, weights 1/d²", &[("clpv.gloss_march", "InverseSquare")]),
    ("printed formulas", &[("clpv.formulas", "Printed")]),
    ("printed formulas, with their bounce", &[("clpv.formulas", "Printed"), ("clpv.bounce", "true")]),
    // Of the thesis's future work (8.2).
    ("ambient occlusion of 0.4 m", &[("clpv.ambient_occlusion", "0.4")]),
    ("ambient occlusion of 1.6 m", &[("clpv.ambient_occlusion", "1.6")]),
    ("1,024 texels by flux", &[("clpv.rsm_samples", "1024")]),
    ("8,192 texels by flux", &[("clpv.rsm_samples", "8192")]),
];
/// The variants that figure 7.8 shows.
const DAMPING: [usize; 2] = [1, 2];
/// Propagation steps of figure 7.9.
const STEPS: [u32; 4] = [4, 8, 16, 32];
/// Grids of figure 7.10: cells, and their edge \[m\].
const GRIDS: [([u32; 3], f32); 4] = [([4, 4, 4], 0.6), ([8, 8, 7], 0.3), ([16, 16, 14], 0.15), ([32, 32, 28], 0.075)];

/// Measures a scene, or its stand-in where its model is missing.
pub(super) fn scene(
    gpu: &Arc<Gpu>,
    paper: &Scene,
    course: &Course,
    folder: &Path,
    common: &Common,
) -> Result<SceneResults> {
    let stage = |scene| Stage { gpu, scene, common };
    let mut stage = stage(paper.scene);
    if let (Err(error), Some(stand_in)) = (stage.session(&[], &[]), paper.stand_in) {
        log::warn!("`{}`: {error:#}; its stand-in `{stand_in}` is measured", paper.scene);
        stage.scene = stand_in;
    }
    let mut results = SceneResults { name: paper.name.to_owned(), scene: stage.scene.to_owned(), ..Default::default() };
    let mut session = stage.session(&[], &[])?;
    for &size in &course.sizes {
        let (times, report) = times(&mut session, size, course.frames)?;
        results.times.push(times);
        count(&session, &report, &mut results);
    }
    stage.errors(paper, course, folder, &mut results)?;
    if paper.scene == "cornell" {
        stage.sweeps(course, folder, &mut results)?;
    }
    Ok(results)
}

/// A scene in the thesis's settings.
struct Stage<'a> {
    gpu: &'a Arc<Gpu>,
    scene: &'a str,
    common: &'a Common,
}

impl Stage<'_> {
    /// The scene without its sky, whose light the thesis has not, in the thesis's settings with further changes.
    fn session(&self, sets: Sets, views: &[DebugView]) -> Result<Session> {
        let thesis = [("preset", "thesis"), ("scene.sky", "(0, 0, 0)")];
        let owned = |&(path, value): &(&str, &str)| (path.to_owned(), value.to_owned());
        let sets = thesis.iter().chain(sets).map(owned).collect();
        let look = Variant::new("thesis", GiMethod::CLPV, sets).look(None);
        let debug = DebugArgs { views: views.to_vec(), ..DebugArgs::default() };
        Session::open(Arc::clone(self.gpu), self.scene, &LookArgs { debug, ..look }, self.common)
    }

    /// The indirect light of settings.
    fn indirect(&self, sets: Sets, course: &Course) -> Result<Image> {
        let mut session = self.session(sets, &[])?;
        session.set_seconds(MOMENT);
        let settings = RenderSettings { only: Layer::Indirect, ..session.render_settings(false) };
        capture::take(&mut session, course.error_size, course.images, &settings)
    }

    /// Errors of all variants, and figures 7.2 to 7.8.
    fn errors(&self, paper: &Scene, course: &Course, folder: &Path, results: &mut SceneResults) -> Result<()> {
        let references = References { cache: course.references.clone(), stored: None, bless: false };
        let mut tracer = self.session(&[], &[])?;
        tracer.set_seconds(MOMENT);
        let wanted = Wanted {
            scene: self.scene,
            time: MOMENT,
            size: course.error_size,
            bounces: Some(1),
            samples: course.samples,
        };
        let halves = references.get(&mut tracer, &wanted, &mut |_| {})?.estimate.halves(Layer::Indirect);
        let reference = mean(&halves);
        let mut images = Vec::new();
        for (what, sets) in VARIANTS {
            let image = self.indirect(sets, course)?;
            let error = layer_error(&image, &halves)?;
            let row = ErrorRow { what: what.to_owned(), nrmse: error.nrmse, bias: error.bias, noise: error.noise };
            images.push((image, format!("{what}: nrmse {:.3}", row.nrmse)));
            results.errors.push(row);
        }
        let file = format!("pictures/figure_{}.png", paper.figure);
        let title = format!("{}, indirect light (figure {})", self.scene, paper.figure);
        picture::three(&folder.join(&file), &images[0].0, &reference, &title, &images[0].1)?;
        results.pictures.insert(paper.figure.to_owned(), vec![file]);
        if ["7.3", "7.4"].contains(&paper.figure) {
            let row: Vec<_> = DAMPING.iter().map(|&index| images[index].clone()).collect();
            let file = format!("pictures/figure_7.8_{}.png", self.scene);
            let title = format!("{}: gradient damping (figure 7.8)", self.scene);
            picture::row(&folder.join(&file), &title, &row, picture::exposure(&reference))?;
            results.pictures.insert("7.8".to_owned(), vec![file]);
        }
        Ok(())
    }

    /// Figures 7.9 and 7.10: propagation steps, and grids with the cells that hold surfaces.
    fn sweeps(&self, course: &Course, folder: &Path, results: &mut SceneResults) -> Result<()> {
        let mut images = Vec::new();
        for steps in STEPS {
            let image = self.indirect(&[("clpv.steps", &steps.to_string())], course)?;
            images.push((image, format!("{steps} steps")));
        }
        let exposure = picture::exposure(&images[images.len() - 1].0);
        let file = "pictures/figure_7.9.png".to_owned();
        picture::row(&folder.join(&file), "Propagation steps (figure 7.9)", &images, exposure)?;
        results.pictures.insert("7.9".to_owned(), vec![file]);
        let (mut light, mut voxels) = (Vec::new(), Vec::new());
        for (cells, edge) in GRIDS {
            let [x, y, z] = cells;
            let (cells, size) = (format!("({x}, {y}, {z})"), format!("Meters({edge})"));
            let sets = [("clpv.cells", cells.as_str()), ("clpv.cell_size", size.as_str())];
            light.push((self.indirect(&sets, course)?, format!("{x}×{y}×{z}")));
            voxels.push((self.voxels(&sets, course)?, format!("cells of {edge} m")));
        }
        let files = ["pictures/figure_7.10_voxels.png", "pictures/figure_7.10.png"].map(str::to_owned);
        picture::row(&folder.join(&files[0]), "Cells with surfaces (figure 7.10, above)", &voxels, 1.0)?;
        picture::row(&folder.join(&files[1]), "Grids (figure 7.10, below)", &light, exposure)?;
        results.pictures.insert("7.10".to_owned(), files.to_vec());
        Ok(())
    }

    /// The screen's image with the cells of the geometry volume.
    fn voxels(&self, sets: Sets, course: &Course) -> Result<Image> {
        let mut session = self.session(sets, &[DebugView::Voxels])?;
        session.set_seconds(MOMENT);
        let settings = session.display_settings();
        capture::take(&mut session, course.error_size, 1, &settings)
    }
}

/// Times of frames of the animation, everything recomputed, and the report of the last.
fn times(session: &mut Session, size: [u32; 2], frames: u32) -> Result<(Times, FrameReport)> {
    let mut samples: BTreeMap<String, Vec<f64>> = BTreeMap::new();
    let mut last = None;
    for frame in 0..WARM_UP + frames.max(1) {
        session.set_ticks(u64::from(frame));
        let view = SceneView { camera: session.camera()?, size, jitter: [0.0; 2] };
        let settings = RenderSettings { no_cache: true, ..session.render_settings(true) };
        let report = session.render(&view, &settings)?;
        if frame >= WARM_UP {
            let mut stages: BTreeMap<&str, f64> = BTreeMap::new();
            for pass in &report.passes {
                let stage = stage_of(&pass.name).filter(|stage| STAGES.contains(stage));
                if let Some((stage, ms)) = stage.zip(pass.gpu_ms) {
                    *stages.entry(stage).or_default() += ms;
                }
            }
            // The thesis's total is the sum of its columns.
            let total = stages.values().sum();
            stages.insert("TOTAL", total);
            stages.into_iter().for_each(|(stage, ms)| samples.entry(stage.to_owned()).or_default().push(ms));
        }
        last = Some(report);
    }
    let stages = samples.into_iter().map(|(stage, values)| (stage, median(values))).collect();
    let report = last.ok_or_else(|| anyhow::anyhow!("no frame was drawn"))?;
    Ok((Times { size, frames: frames.max(1) as usize, stages }, report))
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}

/// Counts of a frame, in the words of table 7.1.
fn count(session: &Session, report: &FrameReport, results: &mut SceneResults) {
    let ran = |prefix: &'static str| {
        report.passes.iter().filter(move |pass| pass.state == PassState::Ran && pass.name.starts_with(prefix))
    };
    let primitives = &session.scene().primitives;
    results.triangles = primitives.iter().map(|primitive| primitive.mesh.indices.len() as u64 / 3).sum();
    results.rsm_triangles = ran("rsm ").map(|pass| pass.counts.triangles).sum();
    results.injections = ran("inject,").chain(ran("blockers of")).map(|pass| pass.counts.injections).sum();
    results.cell_steps = ran("propagate,").map(|pass| pass.counts.cells).sum();
    results.merges = ran("blockers,").map(|pass| pass.counts.merges).sum();
}
