//! Meshes, materials and textures: import, procedural shapes, and the cache of loaded assets.

mod material;
mod mesh;
mod texture;

pub use material::{AlphaMode, Material};
pub use mesh::{Mesh, Vertex};
pub use texture::{Sampling, Texture, Wrap};

use std::sync::atomic::{AtomicU64, Ordering};

/// Identity of an immutable asset within the process. Caches key by it; it is never reused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct AssetId(u64);

impl AssetId {
    /// An identity that no other asset of this process has.
    pub fn fresh() -> Self {
        static NEXT: AtomicU64 = AtomicU64::new(1);
        Self(NEXT.fetch_add(1, Ordering::Relaxed))
    }
}
