//! What helps to see what is going on: drawn over the display image, never into the radiance.
//!
//! ```text
//! gbuffer ─┬─ outline     silhouette of the selection
//!          ├─ coverage    which cascade lights a pixel
//!          ├─ cells       light and blockers of a cascade as spheres, voxels with their reflectance
//!          ├─ points      virtual lights
//!          └─ lines       lights, cameras, cascades, BVH, directions of the sweep
//! ```
//! Each reads the depth of what the camera sees, so that what lies behind a surface is dim or hidden.

mod cells;
mod coverage;
mod lines;
mod outline;
mod overlay;
mod points;
mod shapes;

pub use shapes::{Line, box_edges};

#[cfg(test)]
pub(crate) use self::{cells::CellsUniform, coverage::CoverageUniform, points::PointsUniform};

use super::frame::Frame;
use super::geometry::gbuffer::GBuffer;
use super::indirect::light_volumes::{self, Volume};
use crate::graph::{Graph, Handle, Texture};
use crate::world::Transport;
use glam::Vec3;
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
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct DebugSettings {
    /// Views that are on.
    pub views: BTreeSet<DebugView>,
    /// Cascade whose cells are shown, 0 the finest; beyond the last: the last.
    pub cascade: u32,
    /// Level of the ray hierarchy, 0 the box around everything.
    pub bvh_level: u32,
    /// Primitives with an outline: the low 32 bits of their identities, ascending.
    pub outlined: Vec<u32>,
}

impl Default for DebugSettings {
    fn default() -> Self {
        Self { views: BTreeSet::new(), cascade: 0, bvh_level: 8, outlined: Vec::new() }
    }
}

impl DebugSettings {
    /// Whether nothing is drawn.
    pub fn is_empty(&self) -> bool {
        self.views.is_empty() && self.outlined.is_empty()
    }

    /// Whether a view is on.
    pub fn shows(&self, view: DebugView) -> bool {
        self.views.contains(&view)
    }
}

/// Declares all that the settings ask for; the result is the display image with it.
pub(super) fn declare<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    gbuffer: &GBuffer,
    mut display: Handle<Texture>,
) -> Handle<Texture> {
    let settings = &frame.settings.debug;
    let (volumes, why) = volumes(frame);
    for view in &settings.views {
        display = match view {
            DebugView::Coverage if volumes.is_empty() => skip(graph, *view, why, display),
            DebugView::Coverage => coverage::declare(graph, frame, gbuffer, &volumes, display),
            DebugView::Light | DebugView::Blockers | DebugView::Voxels => {
                cells::declare(graph, frame, gbuffer, *view, &volumes, display)
            }
            DebugView::VirtualLights => points::declare(graph, frame, gbuffer, display),
            DebugView::Cascades | DebugView::Directions if volumes.is_empty() => skip(graph, *view, why, display),
            _ => display,
        };
    }
    display = lines::declare(graph, frame, gbuffer, &volumes, display);
    if !settings.outlined.is_empty() {
        display = outline::declare(graph, frame, gbuffer, display);
    }
    display
}

fn skip(graph: &mut Graph, view: DebugView, why: &str, display: Handle<Texture>) -> Handle<Texture> {
    graph.skip(format!("debug {view}"), why);
    display
}

/// The light volumes of the frame, finest first; none: and why.
fn volumes(frame: &Frame) -> (Vec<Volume>, &'static str) {
    let Some(clpv) = &frame.scene.clpv else { return (Vec::new(), "the scene has no light volumes") };
    let found = match clpv.settings.transport {
        Transport::Sweep => {
            light_volumes::sweep::volumes(clpv, frame.sweep_quality(&clpv.settings), &frame.bounds, frame.view)
        }
        Transport::Diffusion => light_volumes::volumes(clpv, &frame.bounds, frame.view),
    };
    (found.unwrap_or_default(), "the settings of the light volumes make none")
}

/// Colour of a cascade, sRGB-encoded.
fn cascade_color(level: usize) -> Vec3 {
    [Vec3::new(1.0, 0.3, 0.25), Vec3::new(0.35, 0.9, 0.35), Vec3::new(0.35, 0.55, 1.0), Vec3::new(1.0, 0.85, 0.3)]
        [level % 4]
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
