//! Lightwell.
pub mod assets;
pub mod scene;
pub mod world;
