//! Lightwell.
pub mod assets;
pub mod files;
pub mod gpu;
pub mod graph;
pub mod measure;
pub mod profile;
pub mod render;
pub mod scene;
pub mod world;
