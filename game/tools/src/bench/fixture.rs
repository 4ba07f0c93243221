//! A scene with everything that is compared in it, on one device.

use super::results::{SceneFigures, VariantFigures};
use super::variant::{self, Variant};
use crate::capture;
use anyhow::{Context, Result};
use lightwell::files::SceneInfo;
use lightwell::gpu::Gpu;
use lightwell::measure::Image;
use lightwell::render::lpv;
use lightwell::render::{GiMethod, Layer, RenderSettings};
use lightwell::scene::{LightShape, SceneClpv, SceneView};
use lightwell::world::Clpv;
use lightwell_runtime::cli::Common;
use lightwell_runtime::session::{self, Session};
use std::collections::BTreeMap;
use std::sync::Arc;
use xxhash_rust::xxh3::xxh3_64;

/// A scene with everything that is compared in it. Variants of other settings have worlds and renderers of their own,
/// so that each keeps its caches while they take turns.
pub struct Fixture {
    sessions: Vec<Session>,
    /// The variants, each with the index of its session.
    pub runners: Vec<(Variant, usize)>,
    camera: Option<String>,
}

/// The settings of the thesis, where a scene has them.
const THESIS: (&str, &str) = ("preset", "thesis");

fn own((path, value): (&str, &str)) -> (String, String) {
    (path.to_owned(), value.to_owned())
}

/// The three layers of light.
pub struct Light {
    /// All light.
    pub total: Image,
    /// Direct light.
    pub direct: Image,
    /// Total minus direct.
    pub indirect: Image,
}

impl Light {
    fn new(total: Image, direct: Image) -> Self {
        let mut indirect = total.clone();
        for (pixel, direct) in indirect.pixels_mut().iter_mut().zip(direct.pixels()) {
            *pixel = [0, 1, 2].map(|c| pixel[c] - direct[c]);
        }
        Self { total, direct, indirect }
    }
}

impl Fixture {
    /// Loads a scene; its variants come later, since sweeps depend on it.
    ///
    /// # Errors
    /// If the scene cannot be loaded.
    pub fn open(gpu: Arc<Gpu>, scene: &str, camera: Option<&str>, common: &Common) -> Result<Self> {
        let look = Variant::path_tracing(1).look(camera);
        let session = Session::open(gpu, scene, &look, common)?;
        Ok(Self { sessions: vec![session], runners: Vec::new(), camera: camera.map(str::to_owned) })
    }

    /// Sets up the variants.
    ///
    /// # Errors
    /// If a setting does not exist.
    pub fn add(&mut self, variants: &[Variant]) -> Result<()> {
        for variant in variants {
            let variant = &self.in_thesis_settings(variant);
            // All path tracing of the unchanged scene shares one session.
            let index = match variant.is_traced() && variant.sets.is_empty() {
                true => 0,
                false => {
                    let look = variant.look(self.camera.as_deref());
                    let session = self.sessions[0].again(&look);
                    self.sessions.push(session.with_context(|| format!("variant `{}`", variant.name))?);
                    self.sessions.len() - 1
                }
            };
            self.runners.push((variant.clone(), index));
        }
        Ok(())
    }

    /// The session that traces references: the scene as its file has it.
    pub fn tracer(&mut self) -> &mut Session {
        &mut self.sessions[0]
    }

    /// A variant with its session.
    pub fn runner(&mut self, index: usize) -> (&Variant, &mut Session) {
        let (variant, session) = &self.runners[index];
        (variant, &mut self.sessions[*session])
    }

    /// Name of the scene.
    pub fn name(&self) -> String {
        self.sessions[0].name()
    }

    /// The scene's light volume: that of the thesis, if the scene has its settings.
    ///
    /// # Errors
    /// If those settings do not fit the scene.
    pub fn clpv(&self) -> Result<Option<Clpv>> {
        let of = |session: &Session| session.scene().clpv.as_ref().map(|clpv| clpv.settings.clone());
        let variant = self.in_thesis_settings(&Variant::new("thesis", GiMethod::CLPV, vec![own(variant::DIFFUSION)]));
        match variant.sets.iter().any(|(path, _)| path == "preset") {
            true => Ok(of(&self.sessions[0].again(&variant.look(self.camera.as_deref()))?)),
            false => Ok(of(&self.sessions[0])),
        }
    }

    /// The variant with the thesis's settings of the scene first, if the scene has them and it is the thesis's method.
    fn in_thesis_settings(&self, variant: &Variant) -> Variant {
        let info = self.sessions[0].world().ecs.get_resource::<SceneInfo>();
        let has_them = info.is_some_and(|info| info.presets.contains_key(THESIS.1));
        let mut variant = variant.clone();
        if has_them && variant.sets.first() == Some(&own(variant::DIFFUSION)) {
            variant.sets.insert(0, own(THESIS));
        }
        variant
    }

    /// Length of the animation [s] and frames a second.
    pub fn clock(&self) -> (Option<f32>, u32) {
        let settings = self.sessions[0].settings();
        (settings.duration, settings.frame_rate)
    }

    /// Moves all sessions to a time.
    pub fn set_seconds(&mut self, seconds: f64) {
        self.sessions.iter_mut().for_each(|session| session.set_seconds(seconds));
    }

    /// A key of what a measurement depends on: the scene at its times, the variant with its volumes, and `what`.
    ///
    /// # Errors
    /// If there is no camera.
    pub fn key(&mut self, runner: usize, times: &[f64], what: &str) -> Result<String> {
        let mut text = String::new();
        for &time in times {
            let session = self.tracer();
            session.set_seconds(time);
            let view = SceneView { camera: session.camera()?, size: [1; 2], jitter: [0.0; 2] };
            text += &format!("{:032x} ", session.content_key(&view, &Default::default()));
        }
        let (variant, session) = self.runner(runner);
        let clpv = session.scene().clpv.as_ref().map(|clpv| format!("{clpv:?}"));
        let lights: Vec<_> = session.scene().lights.iter().map(|l| (l.rsm_size, l.shadow_size)).collect();
        text += &format!("{} {clpv:?} {lights:?} {what}", variant.identity());
        Ok(format!("{:016x}", xxh3_64(text.as_bytes())))
    }

    /// The three layers of light of a variant that is drawn, `aa` frames averaged.
    ///
    /// # Errors
    /// If it cannot be drawn.
    pub fn draw(&mut self, runner: usize, size: [u32; 2], aa: u32) -> Result<Light> {
        let (_, session) = self.runner(runner);
        let settings = session.render_settings(false);
        let mut layer = |only| capture::take(session, size, aa, &RenderSettings { only, ..settings.clone() });
        let (total, direct) = (layer(Layer::Total)?, layer(Layer::Direct)?);
        Ok(Light::new(total, direct))
    }

    /// The three layers of light of a variant that is traced.
    ///
    /// # Errors
    /// If it cannot be traced.
    pub fn trace(&mut self, runner: usize, size: [u32; 2]) -> Result<Light> {
        let (variant, session) = self.runner(runner);
        let settings = lightwell::render::reference::TraceSettings { bounces: variant.bounces, seed: 0 };
        let spp = variant.spp;
        let view = SceneView { camera: session.camera()?, size, jitter: [0.0; 2] };
        session.begin_trace(&view, &settings)?.0.tracer.restart();
        let estimate = session.trace(&view, &settings, spp, &mut |_| {})?;
        // A single sample is both halves.
        Ok(Light { total: estimate.total(), direct: estimate.direct(), indirect: estimate.indirect() })
    }

    /// The scene in numbers, as it stands.
    ///
    /// # Errors
    /// If there is no camera, or the settings make no volume.
    pub fn figures(&self) -> Result<SceneFigures> {
        let session = &self.sessions[0];
        let scene = session.scene();
        let view = SceneView { camera: session.camera()?, size: [512; 2], jitter: [0.0; 2] };
        let mut figures = SceneFigures {
            name: self.name(),
            primitives: scene.primitives.len(),
            triangles: scene.primitives.iter().map(|primitive| primitive.mesh.indices.len() / 3).sum(),
            lights: lights_in_words(scene),
            volumes: "none".to_owned(),
            cells: None,
            steps: None,
        };
        if let (Some(clpv), Some(settings)) = (&scene.clpv, self.clpv()?) {
            let clpv = SceneClpv { settings, ..clpv.clone() };
            let volumes = lpv::volumes(&clpv, &scene.bounds(), &view)?;
            let [x, y, z] = clpv.settings.cells;
            let finest = volumes.first().map_or(0.0, |volume| volume.cell);
            figures.volumes = format!("{} × {x}×{y}×{z}, {finest:.3} m", volumes.len());
            figures.cells = Some(volumes.iter().map(|volume| u64::from(volume.cell_count())).sum());
            figures.steps = Some(clpv.settings.steps);
        }
        Ok(figures)
    }

    /// The variants for the results.
    pub fn variant_figures(&self) -> Vec<VariantFigures> {
        let figures = |(variant, _): &(Variant, usize)| VariantFigures {
            name: variant.name.clone(),
            what: variant.what.clone(),
            traced: variant.is_traced(),
            sweep: variant.sweep.clone(),
            scene: variant.sweep.is_some().then(|| self.name()),
        };
        self.runners.iter().map(figures).collect()
    }
}

fn lights_in_words(scene: &lightwell::scene::Scene) -> String {
    let mut kinds: BTreeMap<&str, usize> = BTreeMap::new();
    for light in &scene.lights {
        *kinds
            .entry(match light.shape {
                LightShape::Directional => "directional",
                LightShape::Point => "point",
                LightShape::Spot { .. } => "spot",
                LightShape::Sun { .. } => "sun",
                LightShape::Sphere { .. } => "sphere",
                LightShape::Disc { .. } => "disc",
                LightShape::Rectangle { .. } => "rectangle",
                LightShape::Tube { .. } => "tube",
            })
            .or_default() += 1;
    }
    let words: Vec<String> = kinds.iter().map(|(kind, count)| format!("{count} {kind}")).collect();
    if words.is_empty() { "none".to_owned() } else { words.join(", ") }
}

/// Opens the device that all sessions of a run share.
///
/// # Errors
/// If there is none.
pub fn open_gpu(common: &Common) -> Result<Arc<Gpu>> {
    Ok(Arc::new(session::open_gpu(common)?))
}
