//! Debug views: drawn over the display image, never into the radiance.
//!
//! ```text
//! gbuffer ─┬─ outline     silhouette of the selection
//!          ├─ coverage    which cascade lights a pixel
//!          ├─ cells       light and blockers of a cascade as spheres, voxels with their reflectance
//!          ├─ points      virtual lights
//!          └─ lines       lights, cameras, cascades, BVH, directions of the sweep
//! any target ─ targets    laid side by side over all of them
//! ```
//! Each reads the depth of what the camera sees, so that what lies behind a surface is dim or hidden.

mod cells;
mod coverage;
mod lines;
mod outline;
mod overlay;
mod points;
mod shapes;
mod targets;

pub use shapes::box_edges;

#[cfg(test)]
pub(crate) use self::{cells::CellsUniform, coverage::CoverageUniform, points::PointsUniform, targets::TileUniform};

pub use super::debug_settings::{DebugSettings, DebugView, Line, ShownTarget};

use super::frame::Frame;
use super::geometry::gbuffer::GBuffer;
use super::indirect::IndirectMethod;
use super::indirect::light_volumes::{self, Volume};
use crate::graph::{Graph, Handle, Texture};
use crate::world::Transport;
use glam::Vec3;

/// Declares all that the settings ask for; the result is the display image with it.
pub(super) fn declare<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    gbuffer: &GBuffer,
    method: &'a dyn IndirectMethod,
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
            DebugView::VirtualLights => points::declare(graph, frame, gbuffer, method, display),
            DebugView::Cascades | DebugView::Directions if volumes.is_empty() => skip(graph, *view, why, display),
            _ => display,
        };
    }
    display = lines::declare(graph, frame, gbuffer, &volumes, display);
    if !settings.outlined.is_empty() {
        display = outline::declare(graph, frame, gbuffer, display);
    }
    targets::declare(graph, frame, display)
}

fn skip(graph: &mut Graph, view: DebugView, why: &str, display: Handle<Texture>) -> Handle<Texture> {
    graph.skip(format!("debug {view}"), why);
    display
}

/// The light volumes of the frame, finest first; none: and why.
fn volumes(frame: &Frame) -> (Vec<Volume>, &'static str) {
    let Some(clpv) = &frame.scene.clpv else { return (Vec::new(), "the scene has no light volumes") };
    let found = match clpv.settings.transport {
        Transport::Sweep => light_volumes::sweep::volumes(
            clpv,
            light_volumes::sweep::quality(frame, &clpv.settings),
            &frame.bounds,
            frame.view,
        ),
        Transport::Diffusion => light_volumes::volumes(clpv, &frame.bounds, frame.view),
    };
    (found.unwrap_or_default(), "the settings of the light volumes make none")
}

/// Colour of a cascade, sRGB-encoded.
fn cascade_color(level: usize) -> Vec3 {
    [Vec3::new(1.0, 0.3, 0.25), Vec3::new(0.35, 0.9, 0.35), Vec3::new(0.35, 0.55, 1.0), Vec3::new(1.0, 0.85, 0.3)]
        [level % 4]
}
