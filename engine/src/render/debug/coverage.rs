//! Which cascade lights a pixel: a tint with the lines of its cells.

use super::cascade_color;
use super::overlay;
use crate::graph::{Contents, Graph, Handle, Texture};
use crate::render::frame::Frame;
use crate::render::geometry::gbuffer::GBuffer;
use crate::render::indirect::light_volumes::{MAX_CASCADES, Volume, VolumeUniform};
use encase::ShaderType;
use glam::Vec4;

/// `Coverage` of `debug/coverage.wgsl`.
#[derive(ShaderType)]
pub(crate) struct CoverageUniform {
    volumes: [VolumeUniform; MAX_CASCADES],
    colors: [Vec4; MAX_CASCADES],
    count: u32,
    pad_a: u32,
    pad_b: u32,
    pad_c: u32,
}

/// Declares the pass; the result is the display image with the tint.
pub(super) fn declare<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    gbuffer: &GBuffer,
    volumes: &[Volume],
    display: Handle<Texture>,
) -> Handle<Texture> {
    let Some(last) = volumes.last() else { return display };
    let uniform = CoverageUniform {
        volumes: std::array::from_fn(|level| volumes.get(level).unwrap_or(last).uniform()),
        colors: std::array::from_fn(|level| cascade_color(level).extend(1.0)),
        count: volumes.len() as u32,
        pad_a: 0,
        pad_b: 0,
        pad_c: 0,
    };
    let mut pass = graph.raster("debug coverage");
    let display = pass.color(display, Contents::Kept);
    frame.bind_view(&mut pass);
    pass.uniform("coverage", &uniform);
    pass.read("depth", gbuffer.depth);
    pass.step().draw(overlay::pipeline("debug/coverage.wgsl", false), [3, 1]);
    pass.finish();
    display
}
