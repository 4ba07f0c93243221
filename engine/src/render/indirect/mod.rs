//! Indirect light, by methods: in come what the camera sees, reflective shadow maps and the scene as rays meet it, out
//! goes the light that the visible surfaces reflect after it has met others. Each method has a folder of its own and one
//! door, [`IndirectMethod`]; [`Methods`] lists those that there are, and a game adds its own by
//! [`Renderer::add_method`](super::Renderer::add_method).

pub(super) mod accumulate;
pub(super) mod ambient;
pub(super) mod gloss;
pub mod instant_radiosity;
pub mod light_culling;
pub mod light_volumes;
pub(in crate::render) mod lobe_reflectance;
pub(in crate::render) mod lost_light;
mod methods;
pub(super) mod mirror_average;
mod none;
pub mod path_tracer;
mod preset;
mod scattered;
pub(super) mod second_lobe_reflection;
pub(in crate::render) mod sky_reflection;
pub(super) mod variance_filter;

pub use methods::{MethodInfo, Methods};
pub use preset::{Preset, Runs};
pub(crate) use scattered::Scattered;

use super::error::RenderError;
use super::frame::{Frame, Kept};
use super::geometry::GBuffer;
use super::settings::{GiMethod, RenderSettings};
use crate::gpu::Gpu;
use crate::graph::{Buffer, Graph, Handle, Texture};
use crate::scene::{Aabb, Scene, SceneView};
use crate::world::GameWorld;
use light_volumes::Field;
use std::any::Any;

/// Whether a method casts rays into the scene.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RayUse {
    /// It casts none.
    #[default]
    None,
    /// It does, and has another way where the scene does not fit the device as rays need it.
    Optional,
    /// It does, and a scene that does not fit is an error.
    Required,
}

/// The inputs of a frame, before any of them is on the device.
pub struct Subject<'a> {
    /// The scene's arrays.
    pub scene: &'a Scene,
    /// The view.
    pub view: &'a SceneView,
    /// Bounds of all primitives.
    pub bounds: &'a Aabb,
    /// Whether the scene is ready for rays.
    pub has_rays: bool,
}

/// The result of a method for a frame.
pub struct IndirectLight {
    /// Radiance that the visible surfaces reflect [W/(m² sr)], rgba32float.
    pub radiance: Handle<Texture>,
    /// Radiance that mirrors among them reflect \[W/(m² sr)\], and the distance of what they show \[m\], rgba32float: apart,
    /// since what mirrors show moves otherwise than they do. None: all is in `radiance`.
    pub(crate) mirrored: Option<Handle<Texture>>,
    /// Light to look up at any point, for blended surfaces; without it they take that of the pixels behind them.
    pub(crate) field: Option<Field>,
    /// What rays find that meet what is not seen.
    pub(crate) scattered: Scattered,
    /// How the light of the surfels' patches changed since the frame before, where frames are averaged and it is known: see
    /// `light_volumes/radiosity/change.wgsl`.
    pub(crate) change: Option<Handle<Buffer>>,
}

impl IndirectLight {
    /// Light that is known at the pixels of opaque surfaces alone.
    pub fn at_pixels(radiance: Handle<Texture>) -> Self {
        Self { radiance, mirrored: None, field: None, scattered: Scattered::default(), change: None }
    }
}

/// Settings that a method needs and a scene does not have.
#[derive(Clone, Copy, Debug)]
pub struct MissingSettings {
    /// Name of the component in scene files.
    pub component: &'static str,
    /// Adds an entity with the default settings to a world, whose scene is given.
    pub add: fn(&mut GameWorld, &Scene),
}

/// The door of a method. All but [`declare`](Self::declare) has a default that asks for nothing, so that a method whose
/// light is the same everywhere is a few lines.
pub trait IndirectMethod: Any + Send {
    /// Which it is.
    fn id(&self) -> GiMethod;

    /// Its full name, as the interface shows it.
    fn title(&self) -> &'static str;

    /// One line of help for command line and interface.
    fn about(&self) -> &'static str {
        ""
    }

    /// Shaders that it adds to those of the engine: names and texts. [`Renderer::add_method`] gives them to the device.
    ///
    /// [`Renderer::add_method`]: super::Renderer::add_method
    fn shaders(&self) -> &'static [(&'static str, &'static str)] {
        &[]
    }

    /// Whether frames with other random numbers have other noise, which averaging them removes.
    fn varies(&self, scene: &Scene) -> bool {
        let _ = scene;
        false
    }

    /// Whether it gathers light along rays from the visible surfaces, which images whose pixel grids are shifted may share:
    /// see [`RenderSettings::gathered_at`].
    fn gathers(&self, scene: &Scene) -> bool {
        let _ = scene;
        false
    }

    /// Whether it casts rays into the scene: [`Frame::rays`] is ready then.
    fn rays(&self, scene: &Scene) -> RayUse {
        let _ = scene;
        RayUse::None
    }

    /// Whether the sky's light is part of its own.
    fn has_sky_light(&self, scene: &Scene) -> bool {
        let _ = scene;
        false
    }

    /// How far apart the surfels may lie that it needs \[m\], if it needs any: [`Frame::surfels`] holds them then.
    ///
    /// # Errors
    /// Settings that make no sense.
    fn surfel_spacing(&self, subject: &Subject) -> Result<Option<f32>, RenderError> {
        let _ = subject;
        Ok(None)
    }

    /// Whether participating media scatter and absorb its light, or it has none that could pass them.
    fn scatters_in_media(&self, scene: &Scene) -> bool {
        let _ = scene;
        false
    }

    /// Light of the scene that it leaves out in a frame: a sentence each, with the name of the entity, for the warnings of the
    /// frame's report.
    fn lost_light(&self, frame: &Frame) -> Vec<String> {
        let _ = frame;
        Vec::new()
    }

    /// The settings component that it needs and a scene does not have, if so.
    fn missing_settings(&self, scene: &Scene) -> Option<MissingSettings> {
        let _ = scene;
        None
    }

    /// Settings of it that `bench` compares.
    fn presets(&self) -> &'static [Preset] {
        &[]
    }

    /// Updates what it keeps of the scene. Costs nothing if nothing changed.
    ///
    /// # Errors
    /// A scene or settings that the device cannot hold.
    fn update(&mut self, gpu: &Gpu, scene: &Scene) -> Result<(), RenderError> {
        let _ = (gpu, scene);
        Ok(())
    }

    /// Resources of this frame that the next one continues from, as [`Frame::kept`].
    fn keeps(&self, frame: &Frame) -> Option<Kept> {
        let _ = frame;
        None
    }

    /// Declares its passes; none, with the reason in the report, where no light is indirect.
    ///
    /// # Errors
    /// Settings that make no sense, or do not fit the device.
    fn declare<'a>(
        &'a self,
        graph: &mut Graph<'a>,
        frame: &Frame<'a>,
        gbuffer: &GBuffer,
        gpu: &Gpu,
    ) -> Result<Option<IndirectLight>, RenderError>;

    /// Declares direct light of its own in place of the usual one, for methods whose publication defines both.
    fn declare_direct<'a>(
        &'a self,
        graph: &mut Graph<'a>,
        frame: &Frame<'a>,
        gbuffer: &GBuffer,
    ) -> Option<Handle<Texture>> {
        let _ = (graph, frame, gbuffer);
        None
    }

    /// Declares what it draws over the radiance of the whole frame where the settings ask for it.
    fn declare_overlay<'a>(
        &'a self,
        graph: &mut Graph<'a>,
        frame: &Frame<'a>,
        gbuffer: &GBuffer,
        radiance: Handle<Texture>,
    ) -> Handle<Texture> {
        let _ = (graph, frame, gbuffer);
        radiance
    }

    /// Whether its image is all light there is, so that the frame has no other passes: the path tracer alone.
    fn is_whole_frame(&self, settings: &RenderSettings) -> bool {
        let _ = settings;
        false
    }

    /// Targets whose last channel counts the virtual lights that each pixel tested and accepted, if it counts them.
    fn light_counts(&self) -> Option<[&'static str; 2]> {
        None
    }

    /// How the buffer `virtual lights` is laid out, if it keeps one, for the debug view of that name.
    fn point_layout(&self) -> Option<PointLayout> {
        None
    }
}

/// Where a buffer of virtual lights holds what, in vectors of four numbers.
#[derive(Clone, Copy, Debug)]
pub struct PointLayout {
    /// From one light to the next.
    pub stride: u32,
    /// The normal's place. The position comes first.
    pub normal: u32,
    /// The place of its intensity or flux.
    pub light: u32,
    /// Whether lights without flux lie between the others.
    pub has_gaps: bool,
    /// Number of lights, where fewer are in use than the buffer can hold.
    pub count: Option<u32>,
}
