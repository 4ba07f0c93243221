//! Which debug views there are, and which of them are on.

use super::debug::Line;
use std::collections::BTreeSet;
use std::fmt;
use std::str::FromStr;

/// What can be drawn over the image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum DebugView {
    /// Reach and shape of all lights.
    Lights,
    /// What the other cameras see.
    Cameras,
    /// Boxes of the cascades.
    Cascades,
    /// Which cascade lights a pixel, and its cells.
    Coverage,
    /// Light in the cells of a cascade, as spheres.
    Light,
    /// What stops light in the cells of a cascade, by direction, as spheres.
    Blockers,
    /// Cells with surfaces in them, in the colour of their reflectance.
    Voxels,
    /// Boxes of one level of the ray hierarchy.
    Bvh,
    /// Virtual lights of instant radiosity or stochastic light culling.
    VirtualLights,
    /// Directions that light is swept along.
    Directions,
}

impl DebugView {
    /// All of them.
    pub const ALL: [Self; 10] = [
        Self::Lights,
        Self::Cameras,
        Self::Cascades,
        Self::Coverage,
        Self::Light,
        Self::Blockers,
        Self::Voxels,
        Self::Bvh,
        Self::VirtualLights,
        Self::Directions,
    ];

    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Lights => "lights",
            Self::Cameras => "cameras",
            Self::Cascades => "cascades",
            Self::Coverage => "coverage",
            Self::Light => "light",
            Self::Blockers => "blockers",
            Self::Voxels => "voxels",
            Self::Bvh => "bvh",
            Self::VirtualLights => "virtual-lights",
            Self::Directions => "directions",
        }
    }

    /// What it shows, in a line.
    pub fn help(self) -> &'static str {
        match self {
            Self::Lights => "reach and shape of all lights; without a range: as far as 0.1 W/m² reach",
            Self::Cameras => "what the other cameras see",
            Self::Cascades => "boxes of the light volumes, finest red, then green, blue, yellow",
            Self::Coverage => "which light volume lights a pixel, with its cells",
            Self::Light => "light in the cells of one light volume, as spheres",
            Self::Blockers => "what stops light in the cells of one light volume, by direction, as spheres",
            Self::Voxels => "cells with surfaces in them, in the colour of their reflectance",
            Self::Bvh => "boxes of one level of the ray hierarchy",
            Self::VirtualLights => "virtual lights, in the colour of their light",
            Self::Directions => "directions that light is swept along",
        }
    }
}

impl fmt::Display for DebugView {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for DebugView {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let known = Self::ALL.into_iter().find(|view| view.name() == text);
        known.ok_or_else(|| {
            let names = Self::ALL.map(Self::name).join(", ");
            format!("there is no debug view `{text}`; there are {names}")
        })
    }
}

/// What is drawn over the image.
#[derive(Clone, Debug, PartialEq)]
pub struct DebugSettings {
    /// Views that are on.
    pub views: BTreeSet<DebugView>,
    /// Cascade whose cells are shown, 0 the finest; beyond the last: the last.
    pub cascade: u32,
    /// Level of the ray hierarchy, 0 the box around everything.
    pub bvh_level: u32,
    /// Primitives with an outline: the low 32 bits of their identities, ascending.
    pub outlined: Vec<u32>,
    /// Lines that a game draws.
    pub lines: Vec<Line>,
}

impl Default for DebugSettings {
    fn default() -> Self {
        Self { views: BTreeSet::new(), cascade: 0, bvh_level: 8, outlined: Vec::new(), lines: Vec::new() }
    }
}

impl DebugSettings {
    /// Whether nothing is drawn.
    pub fn is_empty(&self) -> bool {
        self.views.is_empty() && self.outlined.is_empty() && self.lines.is_empty()
    }

    /// Whether a view is on.
    pub fn shows(&self, view: DebugView) -> bool {
        self.views.contains(&view)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_back_and_others_are_refused() {
        for view in DebugView::ALL {
            assert_eq!(view.to_string().parse(), Ok(view));
        }
        let error = "lamps".parse::<DebugView>().expect_err("no such view");
        assert!(error.contains("lamps") && error.contains("virtual-lights"), "{error}");
    }
}
