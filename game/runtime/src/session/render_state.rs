//! What draws a world: the scene as the renderer sees it, the renderer, and the choices of how.

use super::CustomMethods;
use crate::cli::{Edges, LookArgs, Only, Switch};
use anyhow::{Context, Result, bail};
use lightwell::files::SceneInfo;
use lightwell::game::{Draw, DrawnLine};
use lightwell::gpu::Gpu;
use lightwell::graph::FrameReport;
use lightwell::render::debug::{DebugSettings, Line};
use lightwell::render::reference::TraceSettings;
use lightwell::render::{
    DisplaySettings, GiMethod, IndirectMethod, Layer, MethodInfo, MlaaEdges, ReferenceSettings, RenderSettings,
    Renderer,
};
use lightwell::scene::{Extractor, Scene, SceneCamera, SceneView};
use lightwell::world::{GameWorld, SceneSettings};
use std::sync::Arc;

/// What draws a world.
pub struct RenderState {
    /// The device, which render states may share.
    pub gpu: Arc<Gpu>,
    /// Choices that change the picture.
    pub look: LookArgs,
    /// How light becomes what the screen shows.
    pub display: DisplaySettings,
    /// What the renderer sees.
    pub scene: Scene,
    /// The renderer.
    pub renderer: Renderer,
    extractor: Extractor,
    custom: CustomMethods,
    pub(super) methods: Vec<MethodInfo>,
}

impl RenderState {
    /// Of nothing yet.
    pub fn new(gpu: Arc<Gpu>, look: LookArgs) -> Self {
        Self::with_methods(gpu, look, &CustomMethods::default())
    }

    /// Empty, with the methods of indirect light of a game.
    pub fn with_methods(gpu: Arc<Gpu>, look: LookArgs, custom: &CustomMethods) -> Self {
        let renderer = renderer_with(&gpu, custom);
        let methods = renderer.methods().list().collect();
        let (display, scene, extractor) = (DisplaySettings::default(), Scene::default(), Extractor::new());
        Self { gpu, look, display, scene, renderer, extractor, custom: custom.clone(), methods }
    }

    /// Another renderer with the same methods, which has drawn nothing yet.
    pub fn new_renderer(&self) -> Renderer {
        renderer_with(&self.gpu, &self.custom)
    }

    /// The methods of indirect light that it was made with besides those of the engine.
    pub fn custom_methods(&self) -> &CustomMethods {
        &self.custom
    }

    /// Adds a method of indirect light to its renderer.
    pub fn add_method(&mut self, method: Box<dyn IndirectMethod>) {
        self.renderer.add_method(&self.gpu, method);
        self.methods = self.renderer.methods().list().collect();
    }

    /// Descriptions of all methods of indirect light that it can draw with.
    pub fn methods(&self) -> &[MethodInfo] {
        &self.methods
    }

    /// Takes over scene and choices of a rendering that has drawn nothing yet; what was drawn stays.
    pub(super) fn take_scene(&mut self, other: Self) {
        (self.scene, self.extractor, self.look) = (other.scene, other.extractor, other.look);
    }

    /// Takes over what changed in the world.
    pub fn follow(&mut self, world: &mut GameWorld) {
        self.extractor.extract(world, &mut self.scene);
    }

    /// The camera that was asked for, or the scene's primary one.
    ///
    /// # Errors
    /// If there is no camera of that name, or none at all.
    pub fn camera(&self) -> Result<SceneCamera> {
        choose_camera(&self.scene, self.look.camera.as_deref())
    }

    /// Settings of a frame.
    pub fn settings(&self, world: &GameWorld, display: bool) -> RenderSettings {
        let scene = settings(world);
        RenderSettings {
            gi: self.look.gi.unwrap_or_else(|| gi_of_scene(world)),
            reference: ReferenceSettings {
                trace: self.trace_settings(),
                samples: self.look.trace.spp,
                samples_a_frame: self.look.trace.spp,
            },
            only: match self.look.only {
                Only::Total => Layer::Total,
                Only::Direct => Layer::Direct,
                Only::Indirect => Layer::Indirect,
                Only::Albedo => Layer::Albedo,
                Only::Normal => Layer::Normal,
                Only::Depth => Layer::Depth,
            },
            exposure: scene.exposure,
            auto_exposure: scene.auto_exposure,
            no_cache: false,
            each_light_alone: self.look.each_light_alone,
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
            moment: world.clock().tick(),
            average: self.look.average == Some(Switch::On),
            images: 1,
            gathered_at: None,
            beside: None,
            update: self.look.light_over.unwrap_or_default(),
            debug: DebugSettings {
                views: self.look.debug.views.iter().copied().collect(),
                cascade: self.look.debug.cascade,
                bvh_level: self.look.debug.bvh_level,
                outlined: Vec::new(),
                lines: drawn_lines(world),
                targets: self.look.debug.targets.clone(),
            },
        }
    }

    /// Settings of a frame that is looked at: with smooth edges, unless they are not wanted or a layer is shown.
    pub fn display_settings(&self, world: &GameWorld) -> RenderSettings {
        let mlaa = !self.look.no_mlaa && self.look.only == Only::Total;
        RenderSettings { mlaa, ..self.settings(world, true) }
    }

    /// What `--bounces` and `--seed` ask of the path tracer.
    pub fn trace_settings(&self) -> TraceSettings {
        TraceSettings { bounces: self.look.trace.bounces, seed: self.look.trace.seed }
    }

    /// Draws a view of the scene as it stands.
    ///
    /// # Errors
    /// If a pass fails or the device is lost.
    pub fn render(&mut self, view: &SceneView, settings: &RenderSettings) -> Result<FrameReport> {
        Ok(self.renderer.render(&self.gpu, &self.scene, view, settings)?)
    }
}

fn renderer_with(gpu: &Gpu, custom: &CustomMethods) -> Renderer {
    let mut renderer = Renderer::new(gpu);
    for method in custom.make() {
        renderer.add_method(gpu, method);
    }
    renderer
}

/// What the systems of a game have drawn.
fn drawn_lines(world: &GameWorld) -> Vec<Line> {
    let Some(draw) = world.ecs.get_resource::<Draw>() else { return Vec::new() };
    let line = |drawn: &DrawnLine| {
        let line = Line::new(drawn.from, drawn.to, drawn.color);
        if drawn.is_on_top { line.on_top() } else { line }
    };
    draw.lines().map(line).collect()
}

/// The method of indirect light that the scene's file asks for.
pub(super) fn gi_of_scene(world: &GameWorld) -> GiMethod {
    world.ecs.get_resource::<SceneInfo>().map(|info| info.gi).unwrap_or_default()
}

pub(super) fn settings(world: &GameWorld) -> SceneSettings {
    world.ecs.get_resource::<SceneSettings>().cloned().unwrap_or_default()
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
