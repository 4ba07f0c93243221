//! The reference: path tracing of the same scene, materials and lights that the other methods draw.
//!
//! ```text
//! scene ─ ray scene (BVH, triangles, materials, lights) ─ path trace ─ sums of two halves ─ resolve
//! ```
//! Samples are summed in two independent halves, so that the image knows its own noise, and so that errors against
//! it can be measured without it (see [`crate::measure::two_halves`]).

mod content;
mod estimate;
mod host;
mod method;
mod path_trace;
mod state;
mod throughput;

pub use crate::render::settings::TraceSettings;
pub use content::content_key;
pub use estimate::Estimate;
pub use path_trace::{PathTracer, TraceError};
pub use state::StateError;
pub use throughput::{Throughput, measure_throughput};

#[cfg(test)]
pub(crate) use path_trace::{ResolveUniform, TraceUniform};

pub(in crate::render) use method::PathTracing;
pub(in crate::render) use path_trace::declare;
