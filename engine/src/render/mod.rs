//! The passes of a frame, one Rust file beside one WGSL file of the same name.

mod light_view;
mod settings;

pub use light_view::{LightView, light_views};
pub use settings::{GiMethod, Layer, RenderSettings};
