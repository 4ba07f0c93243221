//! A Merkle-cached render graph, in place of the thesis's fixed order of passes (4.2.3) and its cache of render targets
//! (6.6.2).
//!
//! A frame is declared, compiled and executed:
//!
//! 1. **Declare** ([`Graph`]): resources, and passes that say what they read, what they write and,
//!    by [`PassBuilder::key`], what else their output depends on.
//! 2. **Compile** ([`Graph::compile`]): plain CPU code. Every version of a resource gets a content
//!    key, a hash of everything that went into it; a retained target that still holds the wanted
//!    key is reused and its pass does not run. What nobody wants is culled; transient targets with
//!    the same description and disjoint lifetimes share memory. Mistakes are errors that name the
//!    passes and the resource.
//! 3. **Execute** ([`Plan::execute`]): records and submits the passes that are left, each with one
//!    debug group and one pair of timestamps from its name, and returns a [`FrameReport`].
//!
//! Two rules keep cached and uncached frames equal bit by bit:
//!
//! - A pass states in its key everything that its output depends on besides what it reads. Compute and raster passes do so
//!   by what they bind ([`Graph::compute`], [`Graph::raster`]); an audit checks the others while frames are drawn
//!   ([`TargetCache::set_audit`]).
//! - The content of a target before its first write of the frame is undefined (it may be left over
//!   from another target or frame): the first writer writes all of it or clears it.

mod alias;
mod audit;
mod bindings;
mod builder;
mod cache;
mod compile;
mod compute;
mod context;
mod cost;
mod decision;
mod desc;
mod error;
mod execute;
mod frame_pacing;
mod handle;
mod key;
mod order;
mod plan;
mod raster;
mod reason;
mod report;
#[cfg(test)]
mod tests;
mod timer;

pub use bindings::{PassBindings, SharedGroup, Tracked};
pub use builder::{Graph, PassBuilder};
pub use cache::{CacheFigures, Target, TargetCache};
pub use compute::{ComputeBuilder, Piece, PieceWork, Step};
#[doc(hidden)]
pub use context::record_dispatch;
pub use context::{Groups, PassContext};
pub use decision::CompileOptions;
pub use desc::{BufferDesc, ResourceDesc, TextureDesc};
pub use error::{GraphError, PassError};
pub use frame_pacing::FramePacing;
pub use handle::{Buffer, Handle, Kind, PassId, Texture};
#[doc(hidden)]
pub use key::hash;
pub use plan::Plan;
pub use raster::{Contents, DrawBindings, Draws, RasterBuilder, RasterStep};
pub use report::{Counts, FrameReport, PassReport, PassState, ResourceReport};
pub use timer::Timing;
