//! The axes of growth, and their numbers.

use lightwell::render::GiMethod;

/// An axis of growth.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    /// Boxes, each an entity.
    Objects,
    /// Triangles of a hundred spheres.
    Triangles,
    /// Point lights of short reach without shadows.
    Lights,
    /// Cells of the light volume.
    Cells,
    /// Directions that the light is swept along.
    Directions,
    /// Pixels of the image.
    Pixels,
}

/// How the scene is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Series {
    /// Direct light.
    Direct,
    /// One bounce of indirect light by the sweep.
    Sweep,
    /// One bounce of indirect light by the thesis's propagation, 16 steps.
    Diffusion,
}

impl Series {
    /// Name in tables and plots.
    pub fn name(self) -> &'static str {
        match self {
            Self::Direct => "direct",
            Self::Sweep => "sweep",
            Self::Diffusion => "diffusion",
        }
    }

    /// The method that draws it.
    pub fn gi(self) -> GiMethod {
        if self == Self::Direct { GiMethod::NONE } else { GiMethod::CLPV }
    }
}

impl Axis {
    /// All of them.
    pub const ALL: [Self; 6] =
        [Self::Objects, Self::Triangles, Self::Lights, Self::Cells, Self::Directions, Self::Pixels];

    /// Name on the command line, in tables and plots.
    pub fn name(self) -> &'static str {
        match self {
            Self::Objects => "objects",
            Self::Triangles => "triangles",
            Self::Lights => "lights",
            Self::Cells => "cells",
            Self::Directions => "directions",
            Self::Pixels => "pixels",
        }
    }

    /// How it is drawn.
    pub fn series(self) -> &'static [Series] {
        match self {
            Self::Objects | Self::Triangles | Self::Pixels => &[Series::Direct, Series::Sweep],
            Self::Lights => &[Series::Direct],
            Self::Cells => &[Series::Diffusion, Series::Sweep],
            Self::Directions => &[Series::Sweep],
        }
    }

    /// The numbers that are measured.
    pub fn counts(self, quick: bool) -> Vec<u64> {
        let cubes = |edges: &[u64]| edges.iter().map(|edge| edge * edge * edge).collect();
        let squares = |edges: &[u64]| edges.iter().map(|edge| edge * edge).collect();
        match (self, quick) {
            (Self::Objects, false) => vec![10, 100, 1_000, 10_000, 30_000, 100_000],
            (Self::Objects, true) => vec![10, 100],
            (Self::Triangles, false) => vec![10_000, 100_000, 1_000_000, 3_000_000, 10_000_000],
            (Self::Triangles, true) => vec![10_000, 20_000],
            (Self::Lights, false) => vec![1, 10, 100, 1_000, 10_000],
            (Self::Lights, true) => vec![1, 10],
            (Self::Cells, false) => cubes(&[8, 16, 32, 64, 88, 128]),
            (Self::Cells, true) => cubes(&[8, 16]),
            (Self::Directions, false) => vec![96, 192, 432, 768],
            (Self::Directions, true) => vec![96, 192],
            (Self::Pixels, false) => squares(&[128, 256, 512, 1024, 2048]),
            (Self::Pixels, true) => squares(&[32, 64]),
        }
    }
}
