//! Lightwell.
pub mod assets;
pub mod gpu;
pub mod render;
pub mod scene;
pub mod world;
