//! What lights see: in come the scene and its lights, out go shadow maps, which say how far a light reaches, and
//! reflective shadow maps, which say what it meets there. Direct light reads the first, methods of indirect light the
//! second.

pub(in crate::render) mod light_view;
pub mod reflective;
pub(in crate::render) mod shadow_map;
pub(in crate::render) mod through_glass;

pub use light_view::{LightView, light_views};
