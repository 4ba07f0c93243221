//! What happens to the finished image on its way to a display.

pub mod mlaa;
pub mod tone_map;
