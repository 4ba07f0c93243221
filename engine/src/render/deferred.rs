//! The frame: which passes a view needs, in which order.
//!
//! ```text
//! scene ─ gbuffer ──────────────┬─ direct (a pass a light) ─┬─ compose ─ tone map
//!      ├─ shadow (a map a light) ┘                           │
//!      ├─ rsm ─ inject ─ propagate ────── relight ─ average ─┤
//!      ├─ sky sweep ─ relight, gloss (for methods that have no light of the sky) ┤
//!      └─ blend (blended surfaces, over all others) ─────────┘
//! ```
//! Nothing is drawn that the image does not read: the layers that show no light ask for no light passes at all,
//! and passes whose inputs have not changed keep their last result (see [`crate::graph`]).

use super::average::{self, History};
use super::blend::{self, Source};
use super::compare;
use super::compose::{self, Lights, RADIANCE};
use super::debug;
use super::error::RenderError;
use super::extra::{self, ExtraPass, Picture};
use super::frame::Frame;
use super::gbuffer::GBuffer;
use super::gpu_scene::GpuScene;
use super::layers::Views;
use super::lpv::sweep::GpuSurfels;
use super::post::mlaa;
use super::post::tone_map::{self, DISPLAY};
use super::ray_scene::RayScene;
use super::reference::{self, PathTracer};
use super::settings::{Beside, GiMethod, Layer, ReferenceSettings, RenderSettings};
use super::vpl::{self, VirtualLights};
use super::{ambient, direct, gbuffer, gloss, lpv, needs, sky_light, slc};
use crate::gpu::{Gpu, ReadbackError, read_buffer};
use crate::graph::{Buffer, CompileOptions, FrameReport, Graph, Handle, Pace, TargetCache, Texture};
use crate::scene::{ProbePoint, Scene, SceneView, ViewProjection};
use glam::Vec3;
use std::f32::consts::PI;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::Arc;

/// Draws scenes. Keeps what may be used again: the scene on the device, and the targets of earlier frames.
pub struct Renderer {
    gpu_scene: GpuScene,
    views: Views,
    surfels: GpuSurfels,
    /// Made when they are first asked for.
    virtual_lights: Option<VirtualLights>,
    targets: TargetCache,
    /// Made when it is first asked for.
    tracer: Option<PathTracer>,
    /// The scene for shadow rays, made when they are first asked for.
    rays: Option<RayScene>,
    /// Why the scene of that identity and geometry cannot be gathered from.
    refused_rays: Option<([u64; 3], String)>,
    /// Whether the last frame drew blended surfaces.
    has_blended: bool,
    probes: Vec<ProbePoint>,
    /// Whether the last frame looked up their light.
    has_probe_light: bool,
    extra: Vec<ExtraPass>,
    history: History,
}

impl Renderer {
    /// A renderer with nothing drawn yet.
    pub fn new(gpu: &Gpu) -> Self {
        Self {
            gpu_scene: GpuScene::new(gpu),
            views: Views::default(),
            surfels: GpuSurfels::new(gpu),
            virtual_lights: None,
            targets: TargetCache::new(),
            tracer: None,
            rays: None,
            refused_rays: None,
            has_blended: false,
            probes: Vec::new(),
            has_probe_light: false,
            extra: Vec::new(),
            history: History::default(),
        }
    }

    /// Adds a pass of one's own, after those that were added before: it makes of the radiance that is shown another
    /// one. It comes before the tone map of display images; [`Renderer::radiance`] stays what was drawn. What it needs
    /// of shaders goes to [`ShaderLibrary::add`](crate::gpu::ShaderLibrary::add). `docs/frame.md` has an example.
    pub fn add_pass(&mut self, pass: impl Fn(&mut Graph<'_>, &Picture<'_>) -> Handle<Texture> + Send + Sync + 'static) {
        self.extra.push(Box::new(pass));
    }

    /// Sets what the frames are paced by, where an interface shares the device; none: nothing.
    pub fn set_pace(&mut self, pace: Option<Arc<Pace>>) {
        self.targets.set_pace(pace);
    }

    /// Sets whether frames are audited: see [`TargetCache::set_audit`]. Path tracing begins anew with each.
    pub fn set_audit(&mut self, audit: bool) {
        self.targets.set_audit(audit);
    }

    /// Sets whether frames measure the time that passes take on the device (they do by default). To read it they wait
    /// for the device at their end.
    pub fn set_timing(&mut self, timing: bool) {
        self.targets.set_timing(timing);
    }

    /// Sets the points whose indirect light the next frames look up; see [`Renderer::probe_light`].
    pub fn set_probes(&mut self, probes: Vec<ProbePoint>) {
        self.has_probe_light &= self.probes == probes;
        self.probes = probes;
    }

    /// Indirect irradiance [W/m²] at the points of [`Renderer::set_probes`], as of the last frame; zeros where no light
    /// volume was filled. Waits for the device to be done with that frame.
    ///
    /// # Errors
    /// If the device fails.
    pub fn probe_light(&self, gpu: &Gpu) -> Result<Vec<Vec3>, ReadbackError> {
        let buffer = self.buffer(lpv::sweep::PROBE_LIGHT).filter(|_| self.has_probe_light);
        match buffer {
            Some(buffer) => Ok(lpv::sweep::probe_light(&self.probes, &read_buffer::<[f32; 4]>(gpu, buffer)?)),
            None => Ok(vec![Vec3::ZERO; self.probes.len()]),
        }
    }

    /// Whether further frames of the same view would make its picture better, since frames are averaged; see
    /// [`RenderSettings::average`].
    pub fn is_settling(&self) -> bool {
        self.history.is_settling()
    }

    /// Draws the view. The images are [`Renderer::radiance`] and [`Renderer::display`]; the report says what ran,
    /// what was kept and what was skipped, and why.
    ///
    /// # Errors
    /// A size or camera that makes no image, a shader that never compiled, or a device that failed. The images
    /// of the last good frame stay.
    pub fn render(
        &mut self,
        gpu: &Gpu,
        scene: &Scene,
        view: &SceneView,
        settings: &RenderSettings,
    ) -> Result<FrameReport, RenderError> {
        let result = self.render_frame(gpu, scene, view, settings);
        if result.is_err() {
            self.history.forget();
        }
        result
    }

    fn render_frame(
        &mut self,
        gpu: &Gpu,
        scene: &Scene,
        view: &SceneView,
        settings: &RenderSettings,
    ) -> Result<FrameReport, RenderError> {
        check_view(gpu, view)?;
        match (needs::averages(scene, settings), needs::shows_indirect(settings)) {
            (true, true) => self.history.begin(gpu, scene, view, settings),
            (true, false) => self.history.skip(),
            (false, _) => self.history.forget(),
        }
        if let (GiMethod::Reference(reference), true) = (settings.gi, settings.only.is_light()) {
            return self.render_reference(gpu, scene, view, settings, &reference);
        }
        self.gpu_scene.update(gpu, scene);
        self.views.begin_frame();
        let bounds = self.gpu_scene.bounds(scene);
        if needs::shows_indirect(settings) && sky_light::is_mirrored(scene) {
            self.gpu_scene.update_sky_reflections(gpu, scene);
        }
        if settings.gi == GiMethod::Vpl && settings.only.is_light() {
            self.virtual_lights.get_or_insert_with(|| VirtualLights::new(gpu)).update(gpu, scene)?;
        }
        if needs::casts_rays(scene, settings) {
            self.rays.get_or_insert_with(|| RayScene::new(gpu)).update(gpu, scene)?;
        } else if needs::gathers(scene, settings) {
            self.update_gathered(gpu, scene);
        }
        let refused_rays =
            self.refused_rays.as_ref().map(|(_, why)| why.as_str()).filter(|_| needs::gathers(scene, settings));
        if let Some(cell) = needs::finest_cell(scene, view, settings, &bounds, refused_rays.is_none())? {
            self.surfels.update(gpu, scene, cell);
        }
        let beside = settings.beside.filter(|_| settings.display && settings.only.is_light());
        let tracer = match &beside {
            Some(beside) => {
                let tracer = self.tracer.get_or_insert_with(|| PathTracer::new(gpu));
                tracer.begin(gpu, scene, view, &beside.reference.trace)?;
                Some(tracer)
            }
            None => None,
        };
        let frame = Frame {
            scene,
            gpu_scene: &self.gpu_scene,
            surfels: &self.surfels,
            rays: self.rays.as_ref().filter(|_| refused_rays.is_none()),
            refused_rays,
            virtual_lights: self.virtual_lights.as_ref(),
            view,
            settings,
            bounds,
            probes: &self.probes,
            views: &self.views,
            history: &self.history,
        };
        let mut graph = Graph::new(seed(gpu));
        let Drawn { gbuffer, radiance, has_blended } = declare(&mut graph, &frame, gpu)?;
        let shown = match (beside, tracer) {
            (Some(beside), Some(tracer)) => declare_beside(&mut graph, settings, radiance, tracer, &beside),
            _ if settings.display && settings.only == Layer::Total => {
                extra::declare(&mut graph, &self.extra, &gbuffer, radiance, view.size)
            }
            _ => radiance,
        };
        finish(&mut graph, settings, radiance, shown, view.size, Some((&frame, &gbuffer)));
        self.has_blended = has_blended;
        self.has_probe_light = graph.latest::<Buffer>(lpv::sweep::PROBE_LIGHT).is_some();
        execute(gpu, graph, &mut self.targets, settings)
    }

    /// Brings the scene for the rays of the final gather up to date. What does not fit the device is looked up in the
    /// volumes alone, and not tried again before it changes.
    fn update_gathered(&mut self, gpu: &Gpu, scene: &Scene) {
        let subject = [scene.identity, scene.revisions.geometry, scene.revisions.materials];
        if self.refused_rays.as_ref().is_some_and(|(refused, _)| *refused == subject) {
            return;
        }
        let rays = self.rays.get_or_insert_with(|| RayScene::new(gpu));
        self.refused_rays = rays.update(gpu, scene).err().map(|error| (subject, error.to_string()));
        if let Some((_, why)) = &self.refused_rays {
            self.rays = None;
            log::warn!("light is not gathered: {why}");
        }
    }

    /// Traces the view instead of drawing it.
    fn render_reference(
        &mut self,
        gpu: &Gpu,
        scene: &Scene,
        view: &SceneView,
        settings: &RenderSettings,
        reference: &ReferenceSettings,
    ) -> Result<FrameReport, RenderError> {
        self.has_blended = false;
        self.has_probe_light = false;
        let tracer = self.tracer.get_or_insert_with(|| PathTracer::new(gpu));
        if settings.no_cache || self.targets.is_audited() {
            tracer.restart();
        }
        tracer.begin(gpu, scene, view, &reference.trace)?;
        let mut graph = Graph::new(seed(gpu));
        graph.skip("gbuffer", "the path tracer finds what the camera sees by itself");
        let radiance = reference::declare(&mut graph, tracer, RADIANCE, settings.only, reference);
        finish(&mut graph, settings, radiance, radiance, view.size, None);
        execute(gpu, graph, &mut self.targets, settings)
    }

    /// The virtual lights, for tools and measurements: none before the first frame that asked for them.
    pub fn virtual_lights(&self) -> Option<&VirtualLights> {
        self.virtual_lights.as_ref()
    }

    /// The path tracer, for measurements: none before the first traced frame.
    pub fn tracer(&self) -> Option<&PathTracer> {
        self.tracer.as_ref()
    }

    /// The path tracer, to trace images beside the frames.
    pub fn tracer_mut(&mut self, gpu: &Gpu) -> &mut PathTracer {
        self.tracer.get_or_insert_with(|| PathTracer::new(gpu))
    }

    /// The last frame's linear radiance [W/(m² sr)], unexposed: rgba32float.
    pub fn radiance(&self) -> Option<&wgpu::Texture> {
        self.targets.texture(RADIANCE)
    }

    /// The last frame as a display shows it: rgba8unorm, sRGB-encoded. Only if the settings asked for it.
    pub fn display(&self) -> Option<&wgpu::Texture> {
        self.targets.texture(DISPLAY)
    }

    /// Any retained texture by its name, for overlays and tools.
    pub fn target(&self, name: &str) -> Option<&wgpu::Texture> {
        self.targets.texture(name)
    }

    /// The identities of the nearest blended surfaces in the last frame, r32uint and 0 where there is none; none if it
    /// drew no such surface.
    pub fn blended_objects(&self) -> Option<&wgpu::Texture> {
        self.targets.texture(blend::OBJECTS).filter(|_| self.has_blended)
    }

    /// Any retained buffer by its name, for tools and measurements.
    pub fn buffer(&self, name: &str) -> Option<&wgpu::Buffer> {
        self.targets.buffer(name)
    }
}

/// Compiles and runs the graph.
fn execute(
    gpu: &Gpu,
    graph: Graph,
    targets: &mut TargetCache,
    settings: &RenderSettings,
) -> Result<FrameReport, RenderError> {
    let plan = graph.compile(targets, &CompileOptions { no_cache: settings.no_cache })?;
    let executed = plan.execute(gpu, targets);
    // A lost device refuses whatever it is given: that is not what is wrong.
    if let Some(lost) = gpu.device_lost() {
        return Err(RenderError::Lost(lost));
    }
    let report = executed?;
    match gpu.take_errors() {
        errors if errors.is_empty() => Ok(report),
        errors => Err(RenderError::Device(errors.join("\n"))),
    }
}

/// Every content key depends on the shaders: a reloaded shader makes everything anew.
fn seed(gpu: &Gpu) -> u64 {
    let mut hasher = DefaultHasher::new();
    gpu.shaders.revision().hash(&mut hasher);
    hasher.finish()
}

/// What a frame has before it is shown.
struct Drawn {
    gbuffer: GBuffer,
    radiance: Handle<Texture>,
    /// Whether there are blended surfaces in it.
    has_blended: bool,
}

/// Declares everything up to the radiance.
fn declare<'a>(graph: &mut Graph<'a>, frame: &Frame<'a>, gpu: &Gpu) -> Result<Drawn, RenderError> {
    let gbuffer = gbuffer::declare(graph, frame);
    let only = frame.settings.only;
    let has_blended = blend::is_needed(graph, frame);
    let mut lights = Lights::default();
    let mut lamps = Vec::new();
    let mut field = None;
    if matches!(only, Layer::Total | Layer::Direct) {
        let published = frame.virtual_lights.filter(|_| frame.settings.gi == GiMethod::Vpl).and_then(|v| v.published());
        if published.is_none() || has_blended {
            lamps = direct::lamps(graph, frame);
        }
        lights.direct = Some(match published {
            Some(settings) => vpl::declare_main_lights(graph, frame, &gbuffer, settings),
            None => direct::declare(graph, frame, &gbuffer, &lamps),
        });
    } else {
        graph.skip("direct", "the layer that is shown holds no direct light");
    }
    if !needs::shows_indirect(frame.settings) {
        graph.skip("clpv", "the layer that is shown holds no indirect light");
    } else if frame.settings.gi == GiMethod::None {
        graph.skip("clpv", "indirect light is switched off");
    } else if frame.settings.gi == GiMethod::Vpl {
        graph.skip("clpv", "the indirect light comes from virtual lights");
        lights.indirect = vpl::declare(graph, frame, &gbuffer)?;
    } else if frame.settings.gi == GiMethod::Slc {
        graph.skip("clpv", "the indirect light comes from stochastic light culling");
        lights.indirect = slc::declare(graph, frame, &gbuffer, gpu)?;
    } else {
        let indirect = lpv::declare(graph, frame, &gbuffer)?;
        lights.indirect = indirect.as_ref().map(|i| gloss::declare(graph, frame, &gbuffer, i, gloss::Names::ALL));
        field = indirect.map(|indirect| indirect.field);
    }
    lights.indirect = lights.indirect.map(|light| average::declare(graph, frame, &gbuffer, light));
    let sky = sky_light::declare(graph, frame, &gbuffer);
    lights.sky = sky.as_ref().map(|sky| sky.radiance);
    if has_blended {
        let sources = [lights.indirect, lights.sky].into_iter().flatten().collect::<Vec<_>>();
        let source = match (field, sky) {
            (Some(field), None) => Some(Source::Field(Box::new(field))),
            (None, Some(sky)) if lights.indirect.is_none() => Some(Source::Field(Box::new(sky.field))),
            // Light from two places, or at the pixels alone.
            _ if sources.is_empty() => None,
            _ => Some(Source::Ambient(ambient::declare(graph, &gbuffer, &sources))),
        };
        lights.blended = Some(blend::declare(graph, frame, &gbuffer, gpu, lamps, source));
    }
    let mut radiance = compose::declare(graph, frame, &gbuffer, lights);
    if let (GiMethod::Vpl, Some(state), 1.., true) =
        (frame.settings.gi, frame.virtual_lights, frame.settings.particle_paths, frame.settings.only.is_light())
    {
        radiance = vpl::declare_paths(graph, frame, &gbuffer, state, radiance);
    }
    Ok(Drawn { gbuffer, radiance, has_blended })
}

/// The reference goes on, and is shown with what was drawn.
fn declare_beside<'a>(
    graph: &mut Graph<'a>,
    settings: &RenderSettings,
    radiance: Handle<Texture>,
    tracer: &'a mut PathTracer,
    beside: &Beside,
) -> Handle<Texture> {
    let traced = reference::declare(graph, tracer, "traced radiance", settings.only, &beside.reference);
    compare::declare(graph, radiance, traced, beside.shown)
}

/// Asks for the radiance, and where it is wanted for the display image of `shown`, with what is drawn over it.
fn finish<'a>(
    graph: &mut Graph<'a>,
    settings: &RenderSettings,
    radiance: Handle<Texture>,
    shown: Handle<Texture>,
    size: [u32; 2],
    drawn: Option<(&Frame<'a>, &GBuffer)>,
) {
    graph.output(radiance);
    if settings.display {
        let mut display = tone_map::declare(graph, settings, shown, size);
        if settings.mlaa {
            display = mlaa::declare(graph, display, size, settings.mlaa_edges, drawn.map(|(_, gbuffer)| gbuffer));
        } else {
            graph.skip("mlaa", "anti-aliasing is off");
        }
        match drawn {
            _ if settings.debug.is_empty() => {}
            Some((frame, gbuffer)) => display = debug::declare(graph, frame, gbuffer, display),
            None => graph.skip("debug", "a path-traced frame has no depth to draw over; use a drawn method"),
        }
        graph.output(display);
    } else {
        graph.skip("tone map", "no display image is wanted");
    }
}

fn check_view(gpu: &Gpu, view: &SceneView) -> Result<(), RenderError> {
    let [width, height] = view.size;
    let limit = gpu.limits.max_texture_dimension_2d;
    if width == 0 || height == 0 || width > limit || height > limit {
        return Err(RenderError::Size { width, height, limit });
    }
    let camera = &view.camera;
    let wrong = |what: String| Err(RenderError::Camera { camera: camera.name.clone(), what });
    let is_near_valid = camera.near > 0.0 || (camera.near == 0.0 && camera.is_orthographic());
    if !(is_near_valid && camera.near.is_finite()) {
        return wrong(format!("the near plane is at {} m; give a distance above 0", camera.near));
    }
    if camera.far.is_some_and(|far| !(far > camera.near)) {
        return wrong(format!("the far plane must lie beyond the near plane at {} m", camera.near));
    }
    match camera.projection {
        ViewProjection::Perspective { vertical_fov } if !(vertical_fov > 0.0 && vertical_fov < PI) => {
            let degrees = vertical_fov.to_degrees();
            return wrong(format!("the field of view is {degrees}°; give one between 0° and 180°"));
        }
        ViewProjection::Orthographic { height } if !(height > 0.0 && height.is_finite()) => {
            return wrong(format!("it sees {height} m of height; give a length above 0"));
        }
        _ => {}
    }
    if !camera.world_from_view.is_finite() {
        return wrong("its place is not finite".into());
    }
    Ok(())
}
