//! Lightwell.
pub mod assets;
pub mod render;
pub mod scene;
pub mod world;
