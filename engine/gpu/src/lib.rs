//! Rooms of Lightwell that know the device but no light: shaders, pipelines and buffers ([`gpu`]), and the render graph
//! ([`graph`]).
//!
//! Games and tools use them through the crate `lightwell`, which hands these rooms on under the same names.

pub mod gpu;
pub mod graph;

use lightwell_core::{core, packed};
