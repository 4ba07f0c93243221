//! What happens to the finished image on its way to a display.

mod auto_exposure;
pub mod mlaa;
pub mod tone_map;
