//! What draws scenes: it brings the scene on the device up to date, asks the method of indirect light what it needs,
//! declares the frame ([`super::frame_graph`]) and runs it.

use super::custom_passes::{self, ExtraPass, Picture};
use super::debug::DebugView;
use super::error::RenderError;
use super::frame::{Frame, Kept};
use super::frame_graph::{self, Drawn};
use super::history::History;
use super::indirect::light_volumes::sweep;
use super::indirect::path_tracer::{self, PathTracer};
use super::indirect::{IndirectMethod, Methods, RayUse, Subject};
use super::post::compose::RADIANCE;
use super::post::temporal_antialiasing;
use super::post::tone_map::DISPLAY;
use super::probe_light::PendingProbes;
use super::rays::RayScene;
use super::scene_gpu::GpuScene;
use super::scene_gpu::surfels::GpuSurfels;
use super::settings::{Layer, RenderSettings};
use super::shadows::shadow_map;
use super::sky::sky_light;
use super::surfaces::Surfaces;
use super::transparency::blend;
use super::views::Views;
use crate::gpu::{Gpu, ReadbackError, begin_read_buffer};
use crate::graph::{
    Buffer, CompileOptions, FramePacing, FrameReport, Graph, Handle, PassState, TargetCache, Texture, Timing,
};
use crate::scene::{Aabb, ProbePoint, Scene, SceneView, ViewProjection};
use glam::Vec3;
use std::f32::consts::PI;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::Arc;
use std::time::Instant;

/// Draws scenes. Keeps what may be used again: the scene on the device, and the targets of earlier frames.
pub struct Renderer {
    gpu_scene: GpuScene,
    views: Views,
    surfels: GpuSurfels,
    methods: Methods,
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
    /// The links of surfels that the last frame has left.
    kept: Option<Kept>,
    /// Warnings of the last frame.
    warned: Vec<String>,
}

impl Renderer {
    /// A renderer with nothing drawn yet.
    pub fn new(gpu: &Gpu) -> Self {
        Self {
            gpu_scene: GpuScene::new(gpu),
            views: Views::default(),
            surfels: GpuSurfels::new(gpu),
            methods: Methods::standard(),
            targets: TargetCache::new(),
            tracer: None,
            rays: None,
            refused_rays: None,
            has_blended: false,
            probes: Vec::new(),
            has_probe_light: false,
            extra: Vec::new(),
            history: History::default(),
            kept: None,
            warned: Vec::new(),
        }
    }

    /// Adds a pass of one's own, after those that were added before: it makes of the radiance that is shown another
    /// one. It comes before the tone map of display images; [`Renderer::radiance`] stays what was drawn. What it needs
    /// of shaders goes to [`ShaderLibrary::add`](crate::gpu::ShaderLibrary::add). `docs/frame.md` has an example.
    pub fn add_pass(&mut self, pass: impl Fn(&mut Graph<'_>, &Picture<'_>) -> Handle<Texture> + Send + Sync + 'static) {
        self.extra.push(Box::new(pass));
    }

    /// Adds a custom method of indirect light, and its shaders to the device; [`RenderSettings::gi`] chooses it by its name.
    /// It replaces one of the same name.
    pub fn add_method(&mut self, gpu: &Gpu, method: Box<dyn IndirectMethod>) {
        for (name, text) in method.shaders() {
            gpu.shaders.add(name, text);
        }
        self.methods.add(method);
    }

    /// The methods of indirect light.
    pub fn methods(&self) -> &Methods {
        &self.methods
    }

    /// Sets what the frames are paced by, where an interface shares the device; none: nothing.
    pub fn set_pacing(&mut self, pacing: Option<Arc<FramePacing>>) {
        self.targets.set_pacing(pacing);
    }

    /// Sets whether frames are audited: see [`TargetCache::set_audit`]. Path tracing restarts with each.
    pub fn set_audit(&mut self, audit: bool) {
        self.targets.set_audit(audit);
    }

    /// Sets when reports tell the times of passes on the device: by default with each frame, which waits for the device.
    pub fn set_timing(&mut self, timing: Timing) {
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
        self.begin_probe_light(gpu)?.finish(gpu)
    }

    /// As [`Renderer::probe_light`], without a wait: the light arrives one to three frames later.
    ///
    /// # Errors
    /// If the device fails.
    pub fn begin_probe_light(&self, gpu: &Gpu) -> Result<PendingProbes, ReadbackError> {
        let buffer = self.buffer(sweep::PROBE_LIGHT).filter(|_| self.has_probe_light);
        let found = buffer.map(|buffer| begin_read_buffer(gpu, buffer)).transpose()?;
        Ok(PendingProbes::new(self.probes.clone(), found))
    }

    /// Whether further frames of the same view would make its picture better, since frames are averaged; see
    /// [`RenderSettings::average`].
    pub fn is_settling(&self) -> bool {
        self.history.is_settling()
    }

    /// How many frames a view that rests is averaged over so far, at most [`MOST_FRAMES`](super::MOST_FRAMES); none: frames
    /// are not averaged.
    pub fn averaged(&self) -> Option<u32> {
        self.history.averaged()
    }

    /// Whether images of the scene may share the light that one of them gathers: see [`RenderSettings::gathered_at`].
    pub fn shares_light(&self, scene: &Scene, settings: &RenderSettings) -> bool {
        settings.only.shows_indirect() && self.methods.get(settings.gi).is_ok_and(|method| method.gathers(scene))
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
        let (start, before) = (Instant::now(), gpu.counts());
        let mut result = self.render_frame(gpu, scene, view, settings);
        match &mut result {
            Ok(report) => {
                self.log_news(&report.warnings);
                report.warnings.splice(0..0, scene.warnings.iter().cloned());
                report.host = gpu.counts().since(&before);
                report.host_ms = start.elapsed().as_secs_f64() * 1e3;
            }
            Err(_) => {
                self.history.forget();
                self.kept = None;
            }
        }
        result
    }

    /// Logs each warning when it first appears; those of the scene were logged when they were found.
    fn log_news(&mut self, warnings: &[String]) {
        for warning in warnings.iter().filter(|warning| !self.warned.contains(warning)) {
            log::warn!("{warning}");
        }
        if self.warned != warnings {
            self.warned = warnings.to_vec();
        }
    }

    fn render_frame(
        &mut self,
        gpu: &Gpu,
        scene: &Scene,
        view: &SceneView,
        settings: &RenderSettings,
    ) -> Result<FrameReport, RenderError> {
        check_view(gpu, view)?;
        let method = self.methods.get(settings.gi)?;
        let is_whole_frame = method.is_whole_frame(settings) && settings.only.is_light();
        match (settings.average && method.varies(scene) && !is_whole_frame, settings.only.shows_indirect()) {
            (true, true) => self.history.begin(gpu, scene, view, settings),
            (true, false) => self.history.skip(),
            (false, _) => self.history.forget(),
        }
        if is_whole_frame {
            return self.render_reference(gpu, scene, view, settings);
        }
        let steady = view;
        let is_averaged = settings.average && method.varies(scene) && settings.only.shows_indirect();
        let step = self.history.step().filter(|_| is_averaged);
        let shifted = step.map(|step| SceneView { jitter: step.jitter, ..view.clone() });
        let view = shifted.as_ref().unwrap_or(view);
        let gathered_at = settings.gathered_at.filter(|_| !settings.average);
        let gathered_at = gathered_at.map(|jitter| SceneView { jitter, ..view.clone() });
        let bounds = self.update(gpu, scene, steady, settings)?;
        let method = self.methods.get(settings.gi)?;
        let casts_rays = self.ray_use(scene, &bounds, settings)? != RayUse::None;
        let refused_rays = self.refused_rays.as_ref().map(|(_, why)| why.as_str()).filter(|_| casts_rays);
        let rays = self.rays.as_ref().filter(|_| casts_rays && refused_rays.is_none());
        let has_shadow_rays = method.rays(scene) != RayUse::None || self.needs_rays(scene, &bounds);
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
            rays,
            shadow_rays: rays.filter(|_| has_shadow_rays),
            refused_rays,
            view,
            gathered_at: gathered_at.as_ref(),
            settings,
            bounds,
            probes: &self.probes,
            views: &self.views,
            kept: self.kept.filter(|_| !settings.no_cache && !self.targets.is_audited()),
            history: &self.history,
        };
        let mut graph = Graph::new(seed(gpu));
        let Drawn { gbuffer, radiance, has_blended } = frame_graph::declare(&mut graph, &frame, method, gpu)?;
        let mut is_smooth = false;
        let shown = match (beside, tracer) {
            (Some(beside), Some(tracer)) => {
                frame_graph::declare_beside(&mut graph, settings, radiance, tracer, &beside)
            }
            _ if settings.display && settings.only == Layer::Total => {
                let smooth = temporal_antialiasing::declare(&mut graph, &frame, &gbuffer, radiance);
                is_smooth = smooth.is_some();
                custom_passes::declare(&mut graph, &self.extra, &gbuffer, smooth.unwrap_or(radiance), view.size)
            }
            _ => radiance,
        };
        let settings = &RenderSettings { mlaa: settings.mlaa && !is_smooth, ..settings.clone() };
        frame_graph::finish(&mut graph, settings, radiance, shown, view, Some((&frame, &gbuffer, method)));
        self.has_blended = has_blended;
        self.has_probe_light = graph.latest::<Buffer>(sweep::PROBE_LIGHT).is_some();
        let kept = method.keeps(&frame);
        let report = execute(gpu, graph, &mut self.targets, settings)?;
        let is_made =
            |name: &str| report.pass(name).is_some_and(|pass| matches!(pass.state, PassState::Ran | PassState::Cached));
        self.kept = kept.filter(|kept| kept.passes.iter().all(|pass| is_made(pass)));
        Ok(report)
    }

    /// Brings everything on the device up to date that the frame needs; the bounds of the scene.
    fn update(
        &mut self,
        gpu: &Gpu,
        scene: &Scene,
        view: &SceneView,
        settings: &RenderSettings,
    ) -> Result<Aabb, RenderError> {
        self.gpu_scene.update(gpu, scene);
        self.views.begin_frame();
        let bounds = self.gpu_scene.bounds(scene);
        if settings.only.is_light() {
            self.methods.get_mut(settings.gi)?.update(gpu, scene)?;
        }
        let rays = self.ray_use(scene, &bounds, settings)?;
        match rays {
            RayUse::Required => self.rays.get_or_insert_with(|| RayScene::new(gpu)).update(gpu, scene)?,
            RayUse::Optional => self.update_optional_rays(gpu, scene),
            RayUse::None => {}
        }
        let method = self.methods.get(settings.gi)?;
        let has_rays = rays != RayUse::None && self.refused_rays.is_none();
        let spacing = match settings.only.shows_indirect() {
            true if sky_light::is_needed(scene, settings, method) => Some(sweep::sky::volume(&bounds).cell),
            true => method.surfel_spacing(&Subject { scene, view, bounds: &bounds, has_rays })?,
            false => None,
        };
        if let Some(spacing) = spacing {
            self.surfels.update(gpu, scene, spacing);
            self.history.keep_patches(gpu, &self.surfels);
        }
        if settings.only.shows_indirect() && self.rays.as_ref().is_some_and(RayScene::has_mirrors) {
            self.history.keep_mirrors(gpu, view.size, Surfaces::Nearest);
        }
        if settings.only.shows_indirect() && self.rays.is_some() && self.gpu_scene.has_second_lobes() {
            self.history.keep_mirrors(gpu, view.size, Surfaces::SecondLobes);
        }
        Ok(bounds)
    }

    /// How the frame casts rays: for its method, soft shadows and the borders of others, or to show their hierarchy.
    fn ray_use(&self, scene: &Scene, bounds: &Aabb, settings: &RenderSettings) -> Result<RayUse, RenderError> {
        if settings.display && settings.debug.shows(DebugView::Bvh) {
            return Ok(RayUse::Required);
        }
        let method = self.methods.get(settings.gi)?;
        Ok(match method.rays(scene) {
            _ if !settings.only.is_light() => RayUse::None,
            RayUse::None if self.needs_rays(scene, bounds) => RayUse::Optional,
            of_method => of_method,
        })
    }

    /// Whether a frame casts rays whatever its method is: for soft shadows, through glass, and for shadows of small things in
    /// large worlds.
    fn needs_rays(&self, scene: &Scene, bounds: &Aabb) -> bool {
        let are_maps_coarse = || shadow_map::are_coarse(&scene.lights, bounds);
        casts_soft_shadows(scene)
            || self.gpu_scene.has_glass()
            || self.gpu_scene.has_second_lobes()
            || are_maps_coarse()
    }

    /// Brings the scene for rays up to date where a method can do without. What does not fit the device is not tried again
    /// before it changes.
    fn update_optional_rays(&mut self, gpu: &Gpu, scene: &Scene) {
        let subject = [scene.identity, scene.revisions.geometry, scene.revisions.materials];
        if self.refused_rays.as_ref().is_some_and(|(refused, _)| *refused == subject) {
            return;
        }
        let rays = self.rays.get_or_insert_with(|| RayScene::new(gpu));
        self.refused_rays = rays.update(gpu, scene).err().map(|error| (subject, error.to_string()));
        if self.refused_rays.is_some() {
            self.rays = None;
        }
    }

    /// Traces the view instead of drawing it.
    fn render_reference(
        &mut self,
        gpu: &Gpu,
        scene: &Scene,
        view: &SceneView,
        settings: &RenderSettings,
    ) -> Result<FrameReport, RenderError> {
        let reference = &settings.reference;
        self.has_blended = false;
        self.has_probe_light = false;
        let tracer = self.tracer.get_or_insert_with(|| PathTracer::new(gpu));
        if settings.no_cache || self.targets.is_audited() {
            tracer.restart();
        }
        tracer.begin(gpu, scene, view, &reference.trace)?;
        let mut graph = Graph::new(seed(gpu));
        graph.skip("gbuffer", "the path tracer finds what the camera sees by itself");
        let radiance = path_tracer::declare(&mut graph, tracer, RADIANCE, settings.only, reference);
        frame_graph::finish(&mut graph, settings, radiance, radiance, view, None);
        execute(gpu, graph, &mut self.targets, settings)
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
    mut graph: Graph,
    targets: &mut TargetCache,
    settings: &RenderSettings,
) -> Result<FrameReport, RenderError> {
    let warnings = graph.take_warnings();
    let plan = graph.compile(targets, &CompileOptions { no_cache: settings.no_cache })?;
    let executed = plan.execute(gpu, targets);
    // A lost device refuses whatever it is given: that is not what is wrong.
    if let Some(lost) = gpu.device_lost() {
        return Err(RenderError::Lost(lost));
    }
    let report = FrameReport { warnings, ..executed? };
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

/// Whether a light with a surface casts shadows, which rays find.
fn casts_soft_shadows(scene: &Scene) -> bool {
    scene.lights.iter().any(|light| light.casts_shadow && light.shape.is_area())
}
