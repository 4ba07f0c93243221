//! The passes of a frame, one Rust file beside one WGSL file of the same name.

mod ambient;
mod average;
mod blend;
mod compare;
mod compose;
pub mod debug;
mod deferred;
mod direct;
mod direct_tiled;
mod environment;
mod error;
mod extra;
pub mod frame;
mod gbuffer;
mod gloss;
pub mod gpu_scene;
mod layers;
#[cfg(test)]
mod layout_tests;
mod light_uniform;
mod light_view;
pub mod lpv;
mod needs;
mod post;
mod ray_scene;
pub mod reference;
pub mod rsm;
mod settings;
mod shadow;
mod sky;
mod sky_light;
pub mod slc;
pub mod vpl;

pub use average::MOST_FRAMES;
pub use deferred::Renderer;
pub use error::RenderError;
pub use extra::Picture;
pub use gbuffer::GBuffer;
pub use light_view::{LightView, light_views};
pub use ray_scene::{RayError, RayScene};
pub use settings::{
    Beside, DisplaySettings, GiMethod, Layer, MlaaEdges, ReferenceSettings, RenderSettings, Shown, ToneMap,
};
