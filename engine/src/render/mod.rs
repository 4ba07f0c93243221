//! The passes of a frame, by stage: in come a [`Scene`](crate::scene::Scene) and a view, out go its radiance and what a
//! display shows of it. [`Renderer`] keeps what outlives a frame; `frame_graph` lists the stages of one, in order. A pass
//! is one Rust file beside one WGSL file of the same name, in the folder of the same name under `shaders/`.
//!
//! ```text
//! geometry ─ shadows ─ direct ─ indirect (a method) ─ sky ─ haze ─ transparency ─ post ─ debug
//! ```
//! [`scene_gpu`] is the scene as rasterization reads it, `rays` the scene as rays meet it.

mod custom_passes;
pub mod debug;
mod debug_settings;
mod direct;
mod error;
pub mod frame;
mod frame_graph;
mod geometry;
mod haze;
mod history;
pub mod indirect;
#[cfg(test)]
mod layout_tests;
mod light_steps;
mod motion;
mod pixel_shift;
mod post;
mod probe_light;
mod rays;
mod renderer;
pub mod scene_gpu;
mod settings;
pub mod shadows;
mod sky;
mod surfaces;
mod transparency;
mod views;
mod zero_texture;

pub use custom_passes::Picture;
pub use error::RenderError;
pub use geometry::GBuffer;
pub use history::MOST_FRAMES;
pub use indirect::instant_radiosity as vpl;
pub use indirect::light_culling as slc;
pub use indirect::light_volumes as lpv;
pub use indirect::path_tracer as reference;
pub use indirect::{
    IndirectLight, IndirectMethod, MethodInfo, Methods, MissingSettings, PointLayout, Preset, RayUse, Runs, Subject,
};
pub use probe_light::PendingProbes;
pub use rays::{RayError, RayScene};
pub use renderer::Renderer;
pub use settings::{
    Beside, DisplaySettings, GiMethod, Layer, MlaaEdges, ReferenceSettings, RenderSettings, Shown, ToneMap, UpdateRate,
};
pub use shadows::{LightView, light_views, reflective as rsm};
pub use surfaces::Surfaces;
