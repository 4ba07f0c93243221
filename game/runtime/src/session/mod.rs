//! A loaded scene with the device that draws it: load, set the time, draw, read back.

mod custom_methods;
mod reading;
mod render_state;
mod tracing;

pub use custom_methods::CustomMethods;
pub use reading::{Objects, PendingPicture};
pub use render_state::RenderState;
pub use tracing::Tracing;

use crate::cli::{Common, LookArgs};
use crate::scene_path;
use crate::set;
use anyhow::Result;
use lightwell::assets::AssetLibrary;
use lightwell::files::{self, ComponentTypes, EditContext, LoadOptions, Overridden, load_scene};
use lightwell::gpu::{self, Gpu, GpuOptions};
use lightwell::graph::FrameReport;
use lightwell::measure::Image;
use lightwell::render::reference::TraceSettings;
use lightwell::render::{Beside, DisplaySettings, MethodInfo, RenderSettings};
use lightwell::scene::{Scene, SceneCamera, SceneView};
use lightwell::world::{GameWorld, SceneSettings};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The device that all options ask for.
pub fn gpu_options(common: &Common) -> GpuOptions {
    GpuOptions { adapter: common.adapter.clone(), ..GpuOptions::default() }
}

/// Keeps what the driver makes of shaders in the user's cache folder, for windows: they are to open quickly.
pub fn keep_pipelines(gpu: &Gpu) {
    if let Some(folders) = directories::ProjectDirs::from("", "", "lightwell") {
        gpu.keep_pipelines(folders.cache_dir());
    }
}

/// Opens the device without a window.
///
/// # Errors
/// No driver, no adapter of that name, or shaders that cannot be read.
pub fn open_gpu(common: &Common) -> Result<Gpu> {
    Ok(Gpu::headless(&gpu_options(common))?)
}

/// A loaded scene with the device that draws it.
pub struct Session {
    /// The device, which sessions may share.
    pub gpu: Arc<Gpu>,
    path: PathBuf,
    options: LoadOptions,
    library: AssetLibrary,
    world: GameWorld,
    /// What draws it.
    pub rendering: RenderState,
    /// The reference that frames for a display are shown beside, if any.
    pub beside: Option<Beside>,
}

/// The scene's file and where its assets come from.
pub struct Files<'a> {
    /// Loaded assets.
    pub library: &'a mut AssetLibrary,
    /// Folder of models.
    pub options: &'a LoadOptions,
    /// The scene's file.
    pub path: &'a Path,
}

impl Files<'_> {
    /// The same for edits.
    pub fn context(&mut self) -> EditContext<'_> {
        EditContext { library: self.library, options: self.options, path: self.path }
    }
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
    /// What the renderer sees.
    pub scene: &'a Scene,
    /// The methods of indirect light that it can be drawn with.
    pub methods: &'a [MethodInfo],
}

impl Session {
    /// Loads a scene by file or name, and applies what `--set` changes.
    ///
    /// # Errors
    /// If the scene or something in it cannot be loaded, a path of `--set` does not exist, or the camera does not.
    pub fn open(gpu: impl Into<Arc<Gpu>>, scene: &str, look: &LookArgs, common: &Common) -> Result<Self> {
        Self::open_with(gpu, scene, look, common, ComponentTypes::default(), &CustomMethods::default())
    }

    /// Like [`open`](Self::open), for a scene with components and methods of indirect light of a game.
    ///
    /// # Errors
    /// As [`Session::open`].
    pub fn open_with(
        gpu: impl Into<Arc<Gpu>>,
        scene: &str,
        look: &LookArgs,
        common: &Common,
        types: ComponentTypes,
        methods: &CustomMethods,
    ) -> Result<Self> {
        let path = scene_path::find(scene)?;
        let options = common.load_options(types);
        Self::with(RenderState::with_methods(gpu.into(), look.clone(), methods), path, options, AssetLibrary::new())
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
        Self::with(self.new_rendering(look.clone()), self.path.clone(), self.options.clone(), self.library.clone())
    }

    fn with(
        mut rendering: RenderState,
        path: PathBuf,
        options: LoadOptions,
        mut library: AssetLibrary,
    ) -> Result<Self> {
        let gpu = rendering.gpu.clone();
        let world = load(&path, &mut library, &options, &mut rendering)?;
        Ok(Self { gpu, path, options, library, world, rendering, beside: None })
    }

    /// A rendering of nothing yet, on the same device and with the same methods.
    fn new_rendering(&self, look: LookArgs) -> RenderState {
        RenderState::with_methods(self.gpu.clone(), look, self.rendering.custom_methods())
    }

    /// Loads the scene anew from its file, into the same world, where entities have the identities of those that stood
    /// at the same paths. If that fails, the running one stays as it is.
    ///
    /// # Errors
    /// As [`Session::open`].
    pub fn reload(&mut self) -> Result<()> {
        let (path, look) = (self.path.clone(), self.rendering.look.clone());
        // A fresh library, since models and images may have changed too; and all that can be wrong is found first.
        let mut library = AssetLibrary::new();
        // What was whole and is broken now may be half written: the last good state stays.
        let strict = self.options.strict || !self.library.has_faults();
        let options = LoadOptions { strict, ..self.options.clone() };
        let loaded = load(&path, &mut library, &options, &mut self.new_rendering(look));
        self.library.watch_also(&library);
        loaded?;
        files::reenter_scene(&mut self.world, &mut library, &options, &path)?;
        self.library = library;
        complete(&mut self.world, &self.path, &mut self.library, &mut self.rendering)
    }

    /// Loads another scene on the same device. If that fails, the running one stays as it is.
    ///
    /// # Errors
    /// As [`Session::open`].
    pub fn open_other(&mut self, path: &Path) -> Result<()> {
        // What was asked of the scene before need not exist in this one.
        let look = LookArgs { camera: None, sets: Vec::new(), ..self.rendering.look.clone() };
        self.replace(path.to_owned(), look)
    }

    fn replace(&mut self, path: PathBuf, look: LookArgs) -> Result<()> {
        // A fresh library: models and images may have changed too.
        let mut library = AssetLibrary::new();
        let mut rendering = self.new_rendering(look);
        let world = load(&path, &mut library, &self.options, &mut rendering)?;
        self.rendering.take_scene(rendering);
        (self.world, self.library, self.path) = (world, library, path);
        Ok(())
    }

    /// Saves the scene.
    ///
    /// # Errors
    /// If something has no form in a file, or the file cannot be written.
    pub fn save(&self, path: &Path) -> Result<()> {
        Ok(files::save_scene(&self.world, path)?)
    }

    /// Saves the scene under another name, and goes on with that file. In another folder its relative paths are rewritten.
    ///
    /// # Errors
    /// As [`Session::save`], and if a file that the scene names cannot be reached from there.
    pub fn save_as(&mut self, path: &Path) -> Result<()> {
        files::save_scene_as(&mut self.world, &self.library, &self.options, &self.path, path)?;
        self.path = path.to_owned();
        Ok(())
    }

    /// What an editor works on.
    pub fn parts(&mut self) -> Parts<'_> {
        Parts {
            world: &mut self.world,
            files: Files { library: &mut self.library, options: &self.options, path: &self.path },
            methods: &self.rendering.methods,
            look: &mut self.rendering.look,
            display: &mut self.rendering.display,
            scene: &self.rendering.scene,
        }
    }

    /// The world.
    pub fn world(&self) -> &GameWorld {
        &self.world
    }

    /// A layer of a kept target as the last frame left it.
    ///
    /// # Errors
    /// If there is no such target, level or layer, or its format has no plain numbers.
    pub fn target(&self, name: &str, mip: u32, layer: u32) -> Result<gpu::ImageF32> {
        self.rendering.target(name, mip, layer)
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
        render_state::settings(&self.world)
    }

    /// What the renderer sees.
    pub fn scene(&self) -> &Scene {
        &self.rendering.scene
    }

    /// Moves everything to where it is at a tick of the scene's clock.
    pub fn set_ticks(&mut self, ticks: u64) {
        self.world.set_tick(ticks);
        update(&mut self.world, &mut self.rendering);
    }

    /// Moves everything to where it is after so many seconds.
    pub fn set_seconds(&mut self, seconds: f64) {
        self.world.set_seconds(seconds);
        update(&mut self.world, &mut self.rendering);
    }

    /// The camera that was asked for, or the scene's primary one.
    ///
    /// # Errors
    /// If there is no camera of that name, or none at all.
    pub fn camera(&self) -> Result<SceneCamera> {
        self.rendering.camera()
    }

    /// Settings of a frame.
    pub fn render_settings(&self, display: bool) -> RenderSettings {
        self.rendering.settings(&self.world, display)
    }

    /// Settings of a frame that is looked at: with smooth edges, unless they are not wanted or a layer is shown.
    pub fn display_settings(&self) -> RenderSettings {
        RenderSettings { beside: self.beside, ..self.rendering.display_settings(&self.world) }
    }

    /// What `--bounces` and `--seed` ask of the path tracer.
    pub fn trace_settings(&self) -> TraceSettings {
        self.rendering.trace_settings()
    }

    /// All files that the scene was made from, besides its own.
    pub fn files(&self) -> BTreeSet<PathBuf> {
        self.library.files()
    }

    /// All files on which the scene depends, besides its own: those that it was made from, and those that the last load
    /// looked for and that are missing.
    pub fn watched_files(&self) -> BTreeSet<PathBuf> {
        self.library.watched()
    }

    /// What the scene's models hold that is not kept as it is, each with its file.
    pub fn model_warnings(&self) -> impl Iterator<Item = String> + '_ {
        self.library.warnings()
    }

    /// What was decided in loading the scene, such as the units of a model's lights.
    pub fn remarks(&self) -> impl Iterator<Item = &str> {
        self.library.remarks()
    }

    /// Whether images of the scene may share the light that one of them gathers.
    pub fn shares_light(&self, settings: &RenderSettings) -> bool {
        self.rendering.renderer.shares_light(&self.rendering.scene, settings)
    }

    /// Draws a view of the scene as it stands.
    ///
    /// # Errors
    /// If a pass fails or the device is lost.
    pub fn render(&mut self, view: &SceneView, settings: &RenderSettings) -> Result<FrameReport> {
        self.rendering.render(view, settings)
    }

    /// Linear radiance of the last frame.
    ///
    /// # Errors
    /// If nothing was drawn or the device is lost.
    pub fn radiance(&self) -> Result<Image> {
        self.rendering.radiance()
    }

    /// Virtual lights that the last frame tested and accepted at a pixel with a surface, on average; none if it was
    /// not drawn with stochastic light culling.
    ///
    /// # Errors
    /// If the device is lost.
    pub fn light_counts(&self) -> Result<Option<[f64; 2]>> {
        self.rendering.light_counts(self.render_settings(false).gi)
    }

    /// As [`Session::light_counts`], at a pixel of the whole image, whatever it shows.
    ///
    /// # Errors
    /// As there.
    pub fn light_counts_of_all_pixels(&self) -> Result<Option<[f64; 2]>> {
        self.rendering.light_counts_of_all_pixels(self.render_settings(false).gi)
    }

    /// The last frame as a screen shows it: sRGB bytes, three a pixel.
    ///
    /// # Errors
    /// If no display image was drawn or the device is lost.
    pub fn display_bytes(&self) -> Result<([u32; 2], Vec<u8>)> {
        self.rendering.display_bytes()
    }

    /// The texture of the last frame for display.
    pub fn display_texture(&self) -> Option<&wgpu::Texture> {
        self.rendering.display_texture()
    }
}

fn update(world: &mut GameWorld, rendering: &mut RenderState) {
    world.update();
    rendering.follow(world);
}

/// Loads a scene for a rendering that has drawn none, with what its choices ask for.
fn load(
    path: &Path,
    library: &mut AssetLibrary,
    options: &LoadOptions,
    rendering: &mut RenderState,
) -> Result<GameWorld> {
    let mut world = load_scene(path, library, options)?;
    complete(&mut world, path, library, rendering)?;
    Ok(world)
}

/// Adds what the rendering's choices ask for to a scene that was loaded. None of it is saved.
fn complete(world: &mut GameWorld, path: &Path, library: &mut AssetLibrary, rendering: &mut RenderState) -> Result<()> {
    let look = rendering.look.clone();
    world.set_tick(0);
    update(world, rendering);
    let method = look.gi.unwrap_or_else(|| render_state::gi_of_scene(world));
    let missing = rendering.renderer.methods().get(method)?.missing_settings(&rendering.scene);
    if let Some(missing) = missing {
        let (file, component) = (path.display(), missing.component);
        library.remark(format!("{file}: no entity has a `{component}` component: the default one is used"));
    }
    if look.sets.is_empty() && missing.is_none() {
        world.ecs.remove_resource::<Overridden>();
        return rendering.camera().map(drop);
    }
    set::override_values(world, path, &look.sets, |world| {
        if let Some(missing) = missing {
            (missing.add)(world, &rendering.scene);
        }
    })?;
    update(world, rendering);
    rendering.camera()?;
    Ok(())
}
