//! What the camera sees: in comes the scene on the device, out goes the G-buffer, the surface of each pixel. Every later
//! stage reads it. Views of all kinds, of lights too, keep static objects apart from dynamic objects (`static_layers`).

pub(in crate::render) mod gbuffer;
pub(in crate::render) mod second_lobe;
pub(in crate::render) mod static_layers;

pub use gbuffer::GBuffer;
