//! A loaded scene with the device that draws it: load, set the time, draw, read back.

use crate::beside::Comparison;
use crate::cli::{Common, Edges, Gi, LookArgs, Only};
use crate::editor::Files;
use crate::scene_path;
use crate::set;
use anyhow::{Context, Result, anyhow, bail};
use lightwell::assets::AssetLibrary;
use lightwell::files::{self, LoadOptions, SceneInfo, load_scene};
use lightwell::gpu::{self, Gpu, GpuOptions};
use lightwell::graph::FrameReport;
use lightwell::measure::Image;
use lightwell::render::debug::DebugSettings;
use lightwell::render::reference::{Estimate, PathTracer, TraceSettings, content_key};
use lightwell::render::slc::{ACCEPTED, TESTED};
use lightwell::render::{DisplaySettings, GiMethod, Layer, MlaaEdges, ReferenceSettings, RenderSettings, Renderer};
use lightwell::scene::{Extractor, Scene, SceneCamera, SceneId, SceneView};
use lightwell::world::{Clpv, GameWorld, InstantRadiosity, SceneSettings, Transform};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The device that all options ask for.
///
/// # Errors
/// No shaders, no driver, or no adapter of that name.
pub fn gpu_options(common: &Common) -> Result<GpuOptions> {
    Ok(GpuOptions { adapter: common.adapter.clone(), shader_dir: gpu::default_shader_dir()? })
}

/// Opens the device without a window.
///
/// # Errors
/// As [`gpu_options`].
pub fn open_gpu(common: &Common) -> Result<Gpu> {
    Ok(Gpu::headless(&gpu_options(common)?)?)
}

/// A world with what is made from it for drawing.
struct Loaded {
    world: GameWorld,
    extractor: Extractor,
    scene: Scene,
}

/// A loaded scene with the device that draws it.
pub struct Session {
    /// The device, which sessions may share.
    pub gpu: Arc<Gpu>,
    path: PathBuf,
    options: LoadOptions,
    look: LookArgs,
    library: AssetLibrary,
    loaded: Loaded,
    pub(crate) renderer: Renderer,
    display: DisplaySettings,
    pub(crate) comparison: Comparison,
}

/// What an editor works on.
pub struct Parts<'a> {
    /// The world.
    pub world: &'a mut GameWorld,
    /// The scene's file and where its assets come from.
    pub files: Files<'a>,
    /// Choices that change the picture.
    pub look: &'a mut LookArgs,
    /// How light becomes what the screen shows.
    pub display: &'a mut DisplaySettings,
    /// The reference beside the picture.
    pub comparison: &'a mut Comparison,
    /// What the renderer sees.
    pub scene: &'a Scene,
}

impl Session {
    /// Loads a scene by file or name, and applies what `--set` changes.
    ///
    /// # Errors
    /// If the scene or something in it cannot be loaded, a path of `--set` does not exist, or the camera does not.
    pub fn open(gpu: impl Into<Arc<Gpu>>, scene: &str, look: &LookArgs, common: &Common) -> Result<Self> {
        let gpu = gpu.into();
        let path = scene_path::find(scene)?;
        let options = LoadOptions { models: common.models.clone() };
        Self::with(gpu, path, options, AssetLibrary::new(), look)
    }

    /// Opens a device without a window, and loads a scene as [`Session::open`] does.
    ///
    /// # Errors
    /// As [`Session::open`], and if there is no device.
    pub fn headless(scene: &str, look: &LookArgs, common: &Common) -> Result<Self> {
        // Before the device, which takes its time.
        scene_path::find(scene)?;
        Self::open(open_gpu(common)?, scene, look, common)
    }

    /// The same scene once more with other choices, on the same device. Meshes and images are shared.
    ///
    /// # Errors
    /// As [`Session::open`].
    pub fn again(&self, look: &LookArgs) -> Result<Self> {
        Self::with(self.gpu.clone(), self.path.clone(), self.options.clone(), self.library.clone(), look)
    }

    fn with(
        gpu: Arc<Gpu>,
        path: PathBuf,
        options: LoadOptions,
        mut library: AssetLibrary,
        look: &LookArgs,
    ) -> Result<Self> {
        let loaded = load(&path, &mut library, &options, look)?;
        let renderer = Renderer::new(&gpu);
        Ok(Self {
            gpu,
            path,
            options,
            look: look.clone(),
            library,
            loaded,
            renderer,
            display: DisplaySettings::default(),
            comparison: Comparison::default(),
        })
    }

    /// Loads the scene anew from its file. If that fails, the running one stays as it is.
    ///
    /// # Errors
    /// As [`Session::open`].
    pub fn reload(&mut self) -> Result<()> {
        // A fresh library: models and images may have changed too.
        let mut library = AssetLibrary::new();
        self.loaded = load(&self.path, &mut library, &self.options, &self.look)?;
        self.library = library;
        Ok(())
    }

    /// Loads another scene on the same device. If that fails, the running one stays as it is.
    ///
    /// # Errors
    /// As [`Session::open`].
    pub fn open_other(&mut self, path: &Path) -> Result<()> {
        let mut library = AssetLibrary::new();
        // What was asked of the scene before need not exist in this one.
        let look = LookArgs { camera: None, sets: Vec::new(), ..self.look.clone() };
        self.loaded = load(path, &mut library, &self.options, &look)?;
        (self.library, self.look, self.path) = (library, look, path.to_owned());
        Ok(())
    }

    /// Saves the scene.
    ///
    /// # Errors
    /// If something has no form in a file, or the file cannot be written.
    pub fn save(&self, path: &Path) -> Result<()> {
        Ok(files::save_scene(&self.loaded.world, path)?)
    }

    /// Saves the scene under another name, and goes on with that file. Paths in scene files are relative: in another
    /// folder the new file is tried first.
    ///
    /// # Errors
    /// As [`Session::save`], and if the file could not be loaded from there.
    pub fn save_as(&mut self, path: &Path) -> Result<()> {
        let folder = |path: &Path| path.canonicalize().ok().and_then(|p| p.parent().map(Path::to_owned));
        let new_folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
        if folder(&self.path) != new_folder.canonicalize().ok() {
            let trial = new_folder.join(format!(".{}.trial.scene.ron", std::process::id()));
            let saved = self.save(&trial);
            let loaded =
                saved.and_then(|()| Ok(load_scene(&trial, &mut self.library.clone(), &self.options).map(drop)?));
            let _ = std::fs::remove_file(&trial);
            loaded.context("paths in the scene are relative to its folder; save it beside the original")?;
        }
        self.save(path)?;
        self.path = path.to_owned();
        Ok(())
    }

    /// What an editor works on.
    pub fn parts(&mut self) -> Parts<'_> {
        Parts {
            world: &mut self.loaded.world,
            files: Files { library: &mut self.library, options: &self.options, path: &self.path },
            look: &mut self.look,
            display: &mut self.display,
            comparison: &mut self.comparison,
            scene: &self.loaded.scene,
        }
    }

    /// The world.
    pub fn world(&self) -> &GameWorld {
        &self.loaded.world
    }

    /// What is seen at a pixel of the last drawn frame.
    ///
    /// # Errors
    /// If the last frame was traced and not drawn, or the device fails.
    pub fn seen_at(&self, [x, y]: [u32; 2]) -> Result<Option<SceneId>> {
        let texture = self.renderer.target("gbuffer object");
        let texture = texture.context("a path-traced image does not tell what it shows; pick in the drawn one")?;
        if x >= texture.width() || y >= texture.height() {
            return Ok(None);
        }
        // The first word of a texel is the identity, zero where there is nothing.
        let word_at = |texture: &wgpu::Texture, bytes_a_texel: usize| -> Result<u32> {
            let bytes = gpu::read_texture(&self.gpu, texture, 0, 0)?;
            let at = bytes_a_texel * (y as usize * texture.width() as usize + x as usize);
            Ok(bytes.get(at..at + 4).and_then(|b| b.try_into().ok()).map_or(0, u32::from_le_bytes))
        };
        let blended = self.renderer.blended_objects().map(|objects| word_at(objects, 4)).transpose()?;
        let word = match blended {
            Some(word) if word != 0 => word,
            _ => word_at(texture, 8)?,
        };
        Ok(self.loaded.scene.primitives.iter().map(|p| p.id).find(|id| word != 0 && id.0 as u32 == word))
    }

    /// A layer of a kept target as the last frame left it.
    ///
    /// # Errors
    /// If there is no such target, level or layer, or its format has no plain numbers.
    pub fn target(&self, name: &str, mip: u32, layer: u32) -> Result<gpu::ImageF32> {
        let texture = self.renderer.target(name).context("the last frames did not make it")?;
        Ok(gpu::read_layer_f32(&self.gpu, texture, mip, layer)?)
    }

    /// Samples a pixel of the path-traced image that is on its way, so far and when it is finished.
    pub fn tracing(&self) -> Option<(u32, u32)> {
        let tracer = self.renderer.tracer().filter(|_| self.traces())?;
        Some((tracer.samples(), self.look.trace.spp))
    }

    /// File of the scene.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Name of the scene.
    pub fn name(&self) -> String {
        scene_path::name_of(&self.path)
    }

    /// Settings of the scene.
    pub fn settings(&self) -> SceneSettings {
        settings(&self.loaded.world)
    }

    /// What the renderer sees.
    pub fn scene(&self) -> &Scene {
        &self.loaded.scene
    }

    /// Moves everything to where it is at a tick of the scene's clock.
    pub fn set_ticks(&mut self, ticks: u64) {
        self.loaded.world.set_tick(ticks);
        self.loaded.update();
    }

    /// Moves everything to where it is after so many seconds.
    pub fn set_seconds(&mut self, seconds: f64) {
        self.loaded.world.set_seconds(seconds);
        self.loaded.update();
    }

    /// The camera that was asked for, or the scene's primary one.
    ///
    /// # Errors
    /// If there is no camera of that name, or none at all.
    pub fn camera(&self) -> Result<SceneCamera> {
        choose_camera(&self.loaded.scene, self.look.camera.as_deref())
    }

    /// Settings of a frame.
    pub fn render_settings(&self, display: bool) -> RenderSettings {
        RenderSettings {
            gi: match self.look.gi.unwrap_or_else(|| gi_of_scene(&self.loaded.world)) {
                Gi::None => GiMethod::None,
                Gi::Clpv => GiMethod::Clpv,
                Gi::Vpl => GiMethod::Vpl,
                Gi::Slc => GiMethod::Slc,
                Gi::Reference => {
                    let samples = self.look.trace.spp;
                    let trace = self.trace_settings();
                    GiMethod::Reference(ReferenceSettings { trace, samples, samples_a_frame: samples })
                }
            },
            only: match self.look.only {
                Only::Total => Layer::Total,
                Only::Direct => Layer::Direct,
                Only::Indirect => Layer::Indirect,
                Only::Albedo => Layer::Albedo,
                Only::Normal => Layer::Normal,
                Only::Depth => Layer::Depth,
            },
            exposure: self.settings().exposure,
            no_cache: false,
            virtual_light: self.look.virtual_light,
            particle_paths: self.look.particle_paths,
            display,
            mlaa: false,
            mlaa_edges: match self.look.mlaa_edges {
                Edges::Color => MlaaEdges::Color,
                Edges::Depth => MlaaEdges::Depth,
                Edges::Normal => MlaaEdges::Normal,
            },
            show: self.display,
            beside: None,
            debug: DebugSettings {
                views: self.look.debug.views.iter().copied().collect(),
                cascade: self.look.debug.cascade,
                bvh_level: self.look.debug.bvh_level,
                outlined: Vec::new(),
            },
        }
    }

    /// Settings of a frame that is looked at: with smooth edges, unless they are not wanted or a layer is shown.
    pub fn display_settings(&self) -> RenderSettings {
        let mlaa = !self.look.no_mlaa && self.look.only == Only::Total;
        let beside = self.comparison.beside(&self.look.trace);
        RenderSettings { mlaa, beside, ..self.render_settings(true) }
    }

    /// What `--bounces` and `--seed` ask of the path tracer.
    pub fn trace_settings(&self) -> TraceSettings {
        TraceSettings { bounces: self.look.trace.bounces, seed: self.look.trace.seed }
    }

    /// Path-traces a view of the scene as it stands, with so many samples a pixel. If the same view was traced before,
    /// its samples count. `progress` is told of the samples that are done.
    ///
    /// # Errors
    /// If the scene cannot be traced or the device fails.
    pub fn trace(
        &mut self,
        view: &SceneView,
        settings: &TraceSettings,
        samples: u32,
        progress: &mut dyn FnMut(u32),
    ) -> Result<Estimate> {
        let mut tracer = self.begin_trace(view, settings)?.0;
        tracer.advance_to(samples, progress)?;
        tracer.estimate()
    }

    /// Takes up a view for the path tracer.
    ///
    /// # Errors
    /// If the scene does not fit the device.
    pub fn begin_trace(&mut self, view: &SceneView, settings: &TraceSettings) -> Result<(Tracing<'_>, u128)> {
        let scene = &self.loaded.scene;
        let key = content_key(scene, view, settings);
        let tracer = self.renderer.tracer_mut(&self.gpu);
        tracer.begin(&self.gpu, scene, view, settings)?;
        Ok((Tracing { gpu: &self.gpu, tracer }, key))
    }

    /// Whether more samples will make the path-traced image better.
    pub fn is_tracing(&self) -> bool {
        self.tracing().is_some_and(|(samples, target)| samples < target)
    }

    /// Whether frames go on tracing, as the picture or beside it.
    fn traces(&self) -> bool {
        self.look.only.is_light() && (self.look.gi == Some(Gi::Reference) || self.comparison.on)
    }

    /// Whether the reference is traced beside a drawn picture.
    pub fn compares(&self) -> bool {
        self.comparison.on && self.look.gi != Some(Gi::Reference)
    }

    /// All files that the scene was made from, besides its own.
    pub fn files(&self) -> BTreeSet<PathBuf> {
        self.library.files()
    }

    /// A key of all that a traced image of this view depends on, the same in every process.
    pub fn content_key(&self, view: &SceneView, settings: &TraceSettings) -> u128 {
        content_key(&self.loaded.scene, view, settings)
    }

    /// Draws a view of the scene as it stands.
    ///
    /// # Errors
    /// If a pass fails or the device is lost.
    pub fn render(&mut self, view: &SceneView, settings: &RenderSettings) -> Result<FrameReport> {
        let report = self.renderer.render(&self.gpu, &self.loaded.scene, view, settings)?;
        Ok(report)
    }

    /// Linear radiance of the last frame.
    ///
    /// # Errors
    /// If nothing was drawn or the device is lost.
    pub fn radiance(&self) -> Result<Image> {
        let texture = self.renderer.radiance().context("no frame was drawn")?;
        let image = gpu::read_texture_f32(&self.gpu, texture)?;
        Image::from_rgba(image.width, image.height, &image.rgba).context("the frame came back incomplete")
    }

    /// Virtual lights that the last frame tested and accepted at a pixel with a surface, on average; none if it was
    /// not drawn with stochastic light culling.
    ///
    /// # Errors
    /// If the device is lost.
    pub fn light_counts(&self) -> Result<Option<[f64; 2]>> {
        let textures = [TESTED, ACCEPTED].map(|name| self.renderer.target(name));
        let (GiMethod::Slc, [Some(tested), Some(accepted)]) = (self.render_settings(false).gi, textures) else {
            return Ok(None);
        };
        let tested = gpu::read_texture_f32(&self.gpu, tested)?;
        let accepted = gpu::read_texture_f32(&self.gpu, accepted)?;
        let surfaces = tested.rgba.iter().filter(|pixel| pixel[3] > 0.0).count().max(1) as f64;
        let mean = |image: &gpu::ImageF32| image.rgba.iter().map(|pixel| f64::from(pixel[3])).sum::<f64>() / surfaces;
        Ok(Some([mean(&tested), mean(&accepted)]))
    }

    /// The last frame as a screen shows it: sRGB bytes, three a pixel.
    ///
    /// # Errors
    /// If no display image was drawn or the device is lost.
    pub fn display_bytes(&self) -> Result<([u32; 2], Vec<u8>)> {
        let texture = self.display_texture().context("no frame was drawn for display")?;
        let bytes = gpu::read_texture(&self.gpu, texture, 0, 0)?;
        let rgb = bytes.chunks_exact(4).flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect();
        Ok(([texture.width(), texture.height()], rgb))
    }

    /// The texture of the last frame for display.
    pub fn display_texture(&self) -> Option<&wgpu::Texture> {
        self.renderer.display()
    }
}

/// An image that is being traced.
pub struct Tracing<'a> {
    gpu: &'a Gpu,
    /// The tracer.
    pub tracer: &'a mut PathTracer,
}

impl Tracing<'_> {
    /// Goes on until there are so many samples a pixel; tells of those that are done.
    ///
    /// # Errors
    /// If the device fails.
    pub fn advance_to(&mut self, samples: u32, progress: &mut dyn FnMut(u32)) -> Result<()> {
        // Pieces small enough for a bar to move; the result does not depend on them.
        const PIECE: u32 = 16;
        while self.tracer.samples() < samples {
            self.tracer.advance(self.gpu, (samples - self.tracer.samples()).min(PIECE))?;
            if let Some(lost) = self.gpu.device_lost() {
                bail!("the graphics device was lost: {lost}");
            }
            progress(self.tracer.samples());
        }
        Ok(())
    }

    /// Takes up what [`Tracing::save`] wrote, if there is such a file.
    ///
    /// # Errors
    /// If the file is of another image or cannot be read.
    pub fn resume(&mut self, path: &Path, key: u128) -> Result<u32> {
        Ok(self.tracer.resume(self.gpu, path, key)?)
    }

    /// Keeps what is traced so far.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn save(&self, path: &Path, key: u128) -> Result<()> {
        Ok(self.tracer.save(self.gpu, path, key)?)
    }

    /// What was traced so far.
    ///
    /// # Errors
    /// If nothing was traced or the device fails.
    pub fn estimate(&self) -> Result<Estimate> {
        Ok(self.tracer.estimate(self.gpu)?)
    }
}

impl Loaded {
    /// Gives the scene a light propagation volume that fits it.
    fn add_light_volume(&mut self) {
        log::info!("the scene has no `clpv` component: one that fits its bounds is used");
        let bounds = self.scene.bounds();
        let translation = if bounds.is_empty() { glam::Vec3::ZERO } else { bounds.center() };
        let entity = self.world.spawn("Light volume", None);
        self.world.ecs.entity_mut(entity).insert((Transform { translation, ..Transform::default() }, Clpv::default()));
    }

    /// Gives the scene the default settings of instant radiosity.
    fn add_virtual_lights(&mut self) {
        log::info!("the scene has no `vpl` component: the default settings are used");
        let entity = self.world.spawn("Virtual lights", None);
        self.world.ecs.entity_mut(entity).insert((Transform::default(), InstantRadiosity::default()));
    }

    fn update(&mut self) {
        self.world.update();
        self.extractor.extract(&mut self.world, &mut self.scene);
    }
}

/// The method of indirect light that the scene's file asks for.
fn gi_of_scene(world: &GameWorld) -> Gi {
    match world.ecs.get_resource::<SceneInfo>().map(|info| info.gi) {
        Some(files::Gi::None) => Gi::None,
        Some(files::Gi::Vpl) => Gi::Vpl,
        Some(files::Gi::Slc) => Gi::Slc,
        Some(files::Gi::Clpv) | None => Gi::Clpv,
    }
}

fn settings(world: &GameWorld) -> SceneSettings {
    world.ecs.get_resource::<SceneSettings>().cloned().unwrap_or_default()
}

fn load(path: &Path, library: &mut AssetLibrary, options: &LoadOptions, look: &LookArgs) -> Result<Loaded> {
    let world = load_scene(path, library, options)?;
    let mut loaded = Loaded { world, extractor: Extractor::new(), scene: Scene::default() };
    loaded.world.set_tick(0);
    loaded.update();
    if look.gi == Some(Gi::Clpv) && loaded.scene.clpv.is_none() {
        loaded.add_light_volume();
    }
    if loaded.scene.vpl.is_none()
        && (look.gi == Some(Gi::Vpl) || look.gi.is_none() && gi_of_scene(&loaded.world) == Gi::Vpl)
    {
        loaded.add_virtual_lights();
    }
    for (target, value) in &look.sets {
        set::apply(&mut loaded.world, target, value).map_err(|error| anyhow!("--set {target}={value}: {error}"))?;
    }
    loaded.update();
    choose_camera(&loaded.scene, look.camera.as_deref())?;
    Ok(loaded)
}

fn choose_camera(scene: &Scene, name: Option<&str>) -> Result<SceneCamera> {
    let Some(name) = name else {
        let camera = scene.cameras.iter().find(|c| c.primary).or(scene.cameras.first());
        return camera.cloned().context("the scene has no camera; give an entity a `camera` component");
    };
    let found = scene.cameras.iter().find(|camera| camera.name == name);
    match found {
        Some(camera) => Ok(camera.clone()),
        None if scene.cameras.is_empty() => bail!("there is no camera `{name}`; the scene has none at all"),
        None => {
            let names: Vec<&str> = scene.cameras.iter().map(|camera| camera.name.as_str()).collect();
            bail!("there is no camera `{name}`; there are: {}", names.join(", "))
        }
    }
}
