//! What participating media do to light on its way to the eye: in come the lights with their shadow maps and the volumes of
//! light of further bounces, out goes what is scattered towards the eye up to any distance, in a grid of columns and slices
//! before the camera. The sum of all light and blended surfaces look it up; how much of what lies behind passes they compute
//! exactly.

mod grid;
mod integrate;
mod scatter;

#[cfg(test)]
pub(crate) use grid::HazeUniform;

use super::direct::lamps::Lamps;
use super::frame::Frame;
use super::geometry::GBuffer;
use super::indirect::light_volumes::Field;
use crate::gpu::ShaderDef;
use crate::graph::{Buffer, Graph, Handle, PassBindings};
use grid::Grid;

/// Whether the frame shows media.
pub(in crate::render) fn is_needed(frame: &Frame) -> bool {
    frame.settings.only.is_light() && !frame.scene.media.is_empty()
}

/// What media scatter towards the eye.
#[derive(Clone, Copy)]
pub(in crate::render) struct Haze {
    grid: Grid,
    /// By column and slice.
    in_scattered: Handle<Buffer>,
}

/// Declares the passes; the light is that of the lamps, if the frame shows it, and that of the field. None, with the reason in
/// the report, if there are no media.
pub(in crate::render) fn declare<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    gbuffer: &GBuffer,
    lamps: Option<Lamps<'a>>,
    field: Option<Field>,
) -> Option<Haze> {
    if !is_needed(frame) {
        let reason = if frame.scene.media.is_empty() {
            "the scene has no fog"
        } else {
            "the layer that is shown holds no light"
        };
        graph.skip("haze", reason);
        return None;
    }
    // Of light that was propagated from cell to cell the mean over directions is not known well enough.
    let field = field.filter(|field| matches!(field, Field::Swept { .. }));
    let grid = Grid::of(frame);
    let scattered = scatter::declare(graph, frame, gbuffer.depth, &grid, lamps, field);
    let in_scattered = integrate::declare(graph, frame, &grid, scattered);
    Some(Haze { grid, in_scattered })
}

impl Haze {
    /// Binds it to a pass that looks it up.
    pub fn bind(&self, pass: &mut PassBindings, frame: &Frame) {
        pass.define("HAZE", ShaderDef::Flag(true));
        self.grid.bind(pass);
        pass.read("in_scattered", self.in_scattered);
        frame.gpu_scene.bind_media(pass);
    }
}
