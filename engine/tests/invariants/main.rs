//! Statements that hold for every scene: the same bits with and without reuse, work that grows with what changed, no light
//! without a source.

mod average;
mod batches;
mod cached_frames;
mod changes;
mod host;
mod keyed_fields;
mod mirroring;
mod mirrors;
mod mlaa;
mod moving;
mod moving_rays;
mod overlays;
mod posed_meshes;
mod shaders;
mod shared_light;
#[path = "../support/mod.rs"]
mod support;
mod temporal;
mod update_rate;
mod warnings;
