//! Typed, versioned handles: a resource of one graph, as it is after a certain number of writes.

use std::marker::PhantomData;

/// Marks a handle of a texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Texture;

/// Marks a handle of a buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Buffer;

/// The kinds of resources: [`Texture`] and [`Buffer`].
pub trait Kind: Copy + sealed::Sealed {
    /// Whether it is the kind of textures.
    const IS_TEXTURE: bool;
}
impl Kind for Texture {
    const IS_TEXTURE: bool = true;
}
impl Kind for Buffer {
    const IS_TEXTURE: bool = false;
}

mod sealed {
    pub trait Sealed {}
    impl Sealed for super::Texture {}
    impl Sealed for super::Buffer {}
}

/// One version of a resource. Writing gives the handle of the next version; whoever reads the old
/// one is ordered before that write.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Handle<K> {
    pub(super) graph: u64,
    pub(super) at: Version,
    kind: PhantomData<K>,
}

impl<K> Handle<K> {
    pub(super) fn new(graph: u64, at: Version) -> Self {
        Self { graph, at, kind: PhantomData }
    }

    /// Casts the handle to another kind of resource, for code that serves all kinds.
    pub(super) fn cast<L>(self) -> Handle<L> {
        Handle::new(self.graph, self.at)
    }
}

/// A pass of one graph, for [`Graph::order`](super::Graph::order).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct PassId {
    pub(super) graph: u64,
    pub(super) index: usize,
}

/// A resource and how many times it was written. Number 0 is the state before any write: content
/// for an import, undefined for all others.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Version {
    pub resource: usize,
    pub number: usize,
}

impl Version {
    pub fn next(self) -> Self {
        Self { number: self.number + 1, ..self }
    }
}
