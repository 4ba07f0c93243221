//! Rooms of Lightwell that need no device: assets and ray hierarchies ([`assets`], [`bvh`]), entities ([`world`]), scene
//! files ([`files`]), flat scenes for the renderer ([`scene`]) and games ([`game`]).
//!
//! Games and tools use them through the crate `lightwell`, which hands these rooms on under the same names.

// Derives name the crate `lightwell`, whose rooms they need are here.
extern crate self as lightwell;

pub mod assets;
pub mod bvh;
pub mod files;
pub mod game;
pub mod scene;
pub mod world;

use lightwell_core::{core, measure};

/// Items that the code of derives refers to.
#[doc(hidden)]
pub mod __private {
    use crate::files::{SceneData, TypeNote};
    pub use serde;
    use std::marker::PhantomData;

    /// Finds out whether a type is [`SceneData`]: by-value methods are found before those of a reference.
    pub struct Probe<T>(PhantomData<T>);

    impl<T> Probe<T> {
        #[allow(clippy::new_without_default)]
        pub fn new() -> Self {
            Self(PhantomData)
        }
    }

    pub trait OfSceneData {
        fn describe(&self, notes: &mut Vec<TypeNote>);
    }
    impl<T: SceneData> OfSceneData for Probe<T> {
        fn describe(&self, notes: &mut Vec<TypeNote>) {
            T::describe(notes);
        }
    }

    pub trait OfAnything {
        fn describe(&self, notes: &mut Vec<TypeNote>);
    }
    impl<T> OfAnything for &Probe<T> {
        fn describe(&self, _: &mut Vec<TypeNote>) {}
    }
}
