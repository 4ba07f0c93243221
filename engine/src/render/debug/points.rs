//! Virtual lights as discs of their colour, with their normals.

use super::overlay::{self, DEPTH};
use crate::graph::{Buffer, Contents, Graph, Handle, Texture, TextureDesc};
use crate::render::frame::Frame;
use crate::render::geometry::gbuffer::GBuffer;
use crate::render::indirect::{IndirectMethod, PointLayout};
use encase::ShaderType;
use wgpu::TextureUsages;

/// `Points` of `debug/points.wgsl`.
#[derive(ShaderType)]
pub(crate) struct PointsUniform {
    stride: u32,
    normal: u32,
    light: u32,
    is_culled: u32,
    radius: f32,
    count: u32,
}

/// Declares the pass; the result is the display image with the lights.
pub(super) fn declare<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    gbuffer: &GBuffer,
    method: &'a dyn IndirectMethod,
    display: Handle<Texture>,
) -> Handle<Texture> {
    let lights = graph.latest::<Buffer>("virtual lights");
    let (Some(layout), Some(lights)) = (method.point_layout(), lights) else {
        graph.skip("debug virtual-lights", "the method of indirect light makes none");
        return display;
    };
    let [width, height] = frame.view.size;
    let own = graph.texture(
        "debug virtual-lights, depth",
        TextureDesc::d2(width, height, DEPTH, TextureUsages::RENDER_ATTACHMENT),
    );
    let in_buffer = (graph.buffer_bytes(lights) / (16 * u64::from(layout.stride))) as u32;
    // How many there are is known when the pass runs. What lies behind the last light of a buffer is older.
    let layout = move || method.point_layout().unwrap_or(layout);
    let count = move || layout().count.unwrap_or(in_buffer).min(in_buffer);
    let radius = 0.006 * frame.bounds.size().length();
    let mut pass = graph.raster("debug virtual-lights");
    let display = pass.color(display, Contents::Kept);
    let _ = pass.depth(own, Contents::Cleared);
    frame.bind_view(&mut pass);
    pass.read("lights", lights);
    pass.read("depth", gbuffer.depth);
    pass.uniform_of("points", &radius.to_bits(), move || {
        let PointLayout { stride, normal, light, has_gaps, .. } = layout();
        PointsUniform { stride, normal, light, is_culled: u32::from(has_gaps), radius, count: count() }
    });
    pass.step().draw_later(overlay::pipeline("debug/points.wgsl", true), &(), move || [6, count()]);
    pass.finish();
    display
}
