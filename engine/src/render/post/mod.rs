//! What happens to the finished image on its way to a display.

pub mod tone_map;
