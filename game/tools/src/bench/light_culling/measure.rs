//! The measurements of a scene.

use super::super::picture;
use super::super::stage::stage_of;
use super::super::variant::Variant;
use super::published::{BOUNDS, Subject};
use super::{BoundRow, Counts, Course, Error, Measured, SubjectResults};
use crate::capture;
use anyhow::{Context, Result};
use bevy_ecs::prelude::Entity;
use lightwell::assets::{AssetId, Material};
use lightwell::gpu::Gpu;
use lightwell::graph::FrameReport;
use lightwell::measure::{Image, compare};
use lightwell::render::{GiMethod, Layer, RenderSettings};
use lightwell::scene::SceneView;
use lightwell::world::{LightBounds, LightCulling, LightLobes, LightShow, MeshRenderer, StochasticLightCulling};
use lightwell_runtime::cli::Common;
use lightwell_runtime::progress::Bar;
use lightwell_runtime::session::Session;
use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

/// Frames before those that are timed.
const WARM_UP: u32 = 2;
/// Time of counts, errors and pictures \[s\].
const MOMENT: f64 = 1.0;
/// GGX α of all surfaces of the scenes of figure 9, whose materials the paper does not print: its false positives there
/// fall by as much as at this α in figure 10.
const GLOSS: f32 = 0.1;
/// Steps of a subject: times and counts of each bound, six times of ways, the error and the pictures.
pub(super) const STEPS: u64 = 3 + 6 + 2;
/// Ways of table 2, in the order of the printed rows.
const WAYS: [LightCulling; 3] = [LightCulling::Splatting, LightCulling::Clustered, LightCulling::Tiled];
const LOBES: [LightLobes; 2] = [LightLobes::Diffuse, LightLobes::Specular];
/// Stages of table 1's columns.
const STAGES: [&[&str]; 5] = [&["GB"], &["GRSM"], &["VPL", "RNG"], &["CUL", "SHS"], &["FLT"]];
/// The column of table 1 that table 2 measures.
const CULLING_AND_SHADING: usize = 3;

/// Measures a scene, or its stand-in where its model is missing.
pub(super) fn subject(
    gpu: &Arc<Gpu>,
    paper: &Subject,
    course: &Course,
    folder: &Path,
    common: &Common,
    bar: &Bar,
) -> Result<SubjectResults> {
    let (scene, mut session) = open(gpu, paper, common)?;
    if !paper.is_of_the_series() {
        make_glossy(&mut session);
    }
    let mut results = SubjectResults {
        name: paper.name.to_owned(),
        scene: scene.to_owned(),
        size: course.size,
        frames: course.frames.max(1) as usize,
        ..Default::default()
    };
    let mut settings = settings(&session)?;
    settings.rsm_size = course.map.unwrap_or(settings.rsm_size);
    let mut stage = Stage { session, settings };
    stage.bounds(course, &mut results, bar)?;
    stage.ways(course, &mut results, bar)?;
    let reference = stage.error(course, &mut results)?;
    bar.inc(1);
    stage.pictures(course, folder, &reference, &mut results)?;
    bar.inc(1);
    let primitives = &stage.session.scene().primitives;
    results.triangles = primitives.iter().map(|primitive| primitive.mesh.indices.len() as u64 / 3).sum();
    results.lights = u64::from(stage.settings.rsm_size).pow(2);
    Ok(results)
}

/// The scene in the paper's settings, and its name.
fn open(gpu: &Arc<Gpu>, paper: &Subject, common: &Common) -> Result<(&'static str, Session)> {
    let open = |scene: &str| {
        let presets = ["culling_paper"].into_iter().chain(paper.roughness);
        let sets = presets.map(|preset| ("preset".to_owned(), preset.to_owned())).collect();
        let look = Variant::new("culling paper", GiMethod::SLC, sets).look(None);
        Session::open(Arc::clone(gpu), scene, &look, common)
    };
    match (open(paper.scene), paper.stand_in) {
        (Err(error), Some(stand_in)) => {
            log::warn!("`{}`: {error:#}; its stand-in `{stand_in}` is measured", paper.scene);
            Ok((stand_in, open(stand_in)?))
        }
        (session, _) => Ok((paper.scene, session?)),
    }
}

/// The settings that the scene's preset made.
fn settings(session: &Session) -> Result<StochasticLightCulling> {
    let entities = session.world().ecs.iter_entities();
    let mut found = entities.filter_map(|entity| entity.get::<StochasticLightCulling>());
    found.next().cloned().context("the preset `culling_paper` makes no settings of light culling")
}

/// Gives all surfaces a gloss of 4 % at normal incidence. Metals become dielectrics: the paper's are both diffuse and glossy.
fn make_glossy(session: &mut Session) {
    let world = &mut session.parts().world.ecs;
    let mut made: HashMap<AssetId, Arc<Material>> = HashMap::new();
    for mut renderer in world.query::<&mut MeshRenderer>().iter_mut(world) {
        let old = Arc::clone(&renderer.material);
        renderer.material = Arc::clone(made.entry(old.id).or_insert_with(|| Arc::new(glossy(&old))));
    }
}

fn glossy(material: &Material) -> Material {
    Material {
        id: AssetId::fresh(),
        metallic: 0.0,
        specular: 1.0,
        roughness: GLOSS.sqrt(),
        metallic_roughness_texture: None,
        specular_texture: None,
        ..material.clone()
    }
}

/// An open scene in the paper's settings.
struct Stage {
    session: Session,
    settings: StochasticLightCulling,
}

impl Stage {
    /// Changes the paper's settings.
    fn set(&mut self, change: impl FnOnce(&mut StochasticLightCulling)) {
        let mut settings = self.settings.clone();
        change(&mut settings);
        let world = &mut self.session.parts().world.ecs;
        let mut query = world.query::<(Entity, &mut StochasticLightCulling)>();
        query.iter_mut(world).for_each(|(_, mut component)| *component = settings.clone());
    }

    /// Figures 9 and 10, and table 1, which is that of the paper's own bound.
    fn bounds(&mut self, course: &Course, results: &mut SubjectResults, bar: &Bar) -> Result<()> {
        for (row, (bounds, _)) in results.bounds.iter_mut().zip(BOUNDS) {
            self.set(|slc| slc.bounds = bounds);
            let times = self.times(course)?;
            let [diffuse, glossy] = self.counts(bounds, course)?;
            *row = BoundRow { total_ms: times[5], glossy, diffuse };
            if bounds == LightBounds::Ellipsoid {
                results.times = times;
            }
            bar.inc(1);
        }
        Ok(())
    }

    /// Lights of the diffuse and of the GGX lobes.
    fn counts(&mut self, bounds: LightBounds, course: &Course) -> Result<[Counts; 2]> {
        let mut counts = [Counts::default(); 2];
        for (counts, lobes) in counts.iter_mut().zip(LOBES) {
            self.set(|slc| (slc.bounds, slc.lobes) = (bounds, lobes));
            self.session.set_seconds(MOMENT);
            self.draw(course.size)?;
            let [tested, accepted] = self.session.light_counts_of_all_pixels()?.context("no light was counted")?;
            *counts = Counts { tested, accepted };
        }
        Ok(counts)
    }

    /// Table 2. What an adapter cannot draw is told in words, and nothing takes its place.
    fn ways(&mut self, course: &Course, results: &mut SubjectResults, bar: &Bar) -> Result<()> {
        for (rows, lobes) in results.ways.iter_mut().zip(LOBES) {
            for (measured, culling) in rows.iter_mut().zip(WAYS) {
                self.set(|slc| (slc.culling, slc.lobes) = (culling, lobes));
                *measured = match self.times(course) {
                    Ok(times) => Measured::Ms(times[CULLING_AND_SHADING]),
                    Err(error) if culling != LightCulling::Tiled => Measured::Refused(format!("{error:#}")),
                    Err(error) => return Err(error),
                };
                bar.inc(1);
            }
        }
        Ok(())
    }

    /// The error of one image against the sum over all lights, which it returns.
    fn error(&mut self, course: &Course, results: &mut SubjectResults) -> Result<Image> {
        self.set(|slc| {
            (slc.culling, slc.interleave, slc.filter_radius) = (LightCulling::None, 1, 0);
        });
        let reference = self.indirect(course)?;
        self.set(|_| ());
        let found = compare(&self.indirect(course)?, &reference)?;
        results.error = Error { size: course.error_size, rmse: found.rmse, nrmse: found.nrmse, bias: found.bias };
        Ok(reference)
    }

    /// The image beside the sum, and the glossy lights that each bound tests in vain.
    fn pictures(
        &mut self,
        course: &Course,
        folder: &Path,
        reference: &Image,
        results: &mut SubjectResults,
    ) -> Result<()> {
        let name = picture::file_name(&results.name);
        let files = [format!("pictures/{name}.png"), format!("pictures/{name}_in_vain.png")];
        self.set(|_| ());
        let image = self.indirect(course)?;
        let (title, caption) =
            (format!("{}, indirect light", results.name), format!("nrmse {:.3}", results.error.nrmse));
        picture::three(&folder.join(&files[0]), &image, reference, &title, &caption)?;
        let mut row = Vec::new();
        for (((bounds, _), letter), counted) in BOUNDS.into_iter().zip(["a", "b", "c"]).zip(&results.bounds) {
            self.set(|slc| {
                (slc.bounds, slc.lobes, slc.show) = (bounds, LightLobes::Specular, LightShow::FalsePositives)
            });
            row.push((self.indirect(course)?, format!("({letter}) {:.1}", counted.glossy.in_vain())));
        }
        picture::row(&folder.join(&files[1]), &format!("{}, glossy lights in vain", results.name), &row, 4.0)?;
        results.pictures = files.to_vec();
        Ok(())
    }

    fn indirect(&mut self, course: &Course) -> Result<Image> {
        self.session.set_seconds(MOMENT);
        let settings = RenderSettings { only: Layer::Indirect, ..self.session.render_settings(false) };
        capture::take(&mut self.session, course.error_size, 1, &settings)
    }

    fn draw(&mut self, size: [u32; 2]) -> Result<FrameReport> {
        let view = SceneView { camera: self.session.camera()?, size, jitter: [0.0; 2] };
        let settings = RenderSettings { no_cache: true, ..self.session.render_settings(true) };
        self.session.render(&view, &settings)
    }

    /// Medians of table 1's columns over frames of the animation, everything recomputed.
    fn times(&mut self, course: &Course) -> Result<[f64; 6]> {
        let mut samples: [Vec<f64>; 6] = Default::default();
        for frame in 0..WARM_UP + course.frames.max(1) {
            self.session.set_ticks(u64::from(frame));
            let report = self.draw(course.size)?;
            if frame >= WARM_UP {
                let times = columns(&report);
                samples.iter_mut().zip(times).for_each(|(values, ms)| values.push(ms));
            }
        }
        Ok(samples.map(median))
    }
}

/// Times of a frame in table 1's columns, and their sum \[ms\].
fn columns(report: &FrameReport) -> [f64; 6] {
    let mut times = [0.0; 6];
    for pass in &report.passes {
        let column = stage_of(&pass.name).and_then(|stage| STAGES.iter().position(|column| column.contains(&stage)));
        if let Some((column, ms)) = column.zip(pass.gpu_ms) {
            times[column] += ms;
            times[5] += ms;
        }
    }
    times
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::super::super::fixture::open_gpu;
    use super::super::published::SUBJECTS;
    use super::*;
    use lightwell::world::{Delta, LightChances, LightVisibility, Name};

    /// The settings of section 7, and the roughness of figure 10, which is α: materials have its root.
    #[test]
    fn presets_are_what_the_paper_says() {
        let common = Common::default();
        let gpu = open_gpu(&common).unwrap();
        for paper in SUBJECTS.iter().filter(|paper| paper.is_of_the_series()) {
            let (_, session) = open(&gpu, paper, &common).unwrap();
            let slc = settings(&session).unwrap();
            assert_eq!((slc.rsm_size, slc.delta, slc.visibility), (256, Delta::Absolute(0.001), LightVisibility::None));
            assert_eq!((slc.interleave, slc.filter_radius), (8, 8));
            assert_eq!(slc.chances, LightChances::Independent);
            let entities = session.world().ecs.iter_entities();
            let rings = entities.filter(|entity| entity.get::<Name>().is_some_and(|name| name.0.starts_with("Ring")));
            let visible: Vec<f32> = rings
                .filter_map(|ring| ring.get::<MeshRenderer>())
                .filter(|renderer| renderer.visible)
                .map(|renderer| renderer.material.roughness.powi(2))
                .collect();
            let alpha: f32 = paper.name.trim_start_matches("roughness ").parse().unwrap();
            assert!(
                matches!(visible[..], [found] if (found / alpha - 1.0).abs() < 1e-4),
                "{}: {visible:?}",
                paper.name
            );
        }
    }

    /// One light feeds one map in the paper's settings, also where a model is missing.
    #[test]
    fn one_light_feeds_the_map() {
        let common = Common::default();
        let gpu = open_gpu(&common).unwrap();
        for scene in ["night_court", "cathedral", "courtyard", "glossy_ring"] {
            let paper = Subject { scene, stand_in: None, roughness: None, ..SUBJECTS[3] };
            let (_, mut session) = open(&gpu, &paper, &common).unwrap();
            make_glossy(&mut session);
            session.set_seconds(MOMENT);
            let fed: Vec<_> = session.scene().lights.iter().filter(|light| light.indirect).collect();
            let is_one_map = !fed.is_empty() && fed.iter().all(|light| light_is_one_map(&light.shape));
            assert!(fed.len() == 1 && is_one_map, "{scene}: {} lights", fed.len());
            let glossy = |primitive: &lightwell::scene::Primitive| primitive.material.specular > 0.0;
            assert!(session.scene().primitives.iter().all(glossy), "{scene}");
        }
    }

    fn light_is_one_map(shape: &lightwell::scene::LightShape) -> bool {
        use lightwell::scene::LightShape::{Directional, Spot, Sun};
        matches!(shape, Directional | Sun { .. } | Spot { .. })
    }
}
