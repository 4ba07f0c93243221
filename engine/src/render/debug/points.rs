//! Virtual lights as discs of their colour, with their normals.

use super::overlay::{self, DEPTH, Draw};
use crate::gpu::Binding;
use crate::graph::{Buffer, Graph, Handle, Texture, TextureDesc};
use crate::render::frame::Frame;
use crate::render::geometry::gbuffer::GBuffer;
use crate::render::indirect::IndirectMethod;
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
    let mut pass = graph.pass("debug virtual-lights");
    let depth = gbuffer.depth;
    pass.read(depth);
    pass.read(lights);
    let (display, own) = (pass.write(display), pass.write(own));
    pass.key(&frame.view_key());
    let frame = frame.clone();
    pass.execute(move |cx| {
        let buffer = cx.buffer(lights).clone();
        // How many there are is known by now. What lies behind the last light of a buffer is older.
        let layout = method.point_layout().unwrap_or(layout);
        let in_buffer = (buffer.size() / (16 * u64::from(layout.stride))) as u32;
        let count = layout.count.unwrap_or(in_buffer).min(in_buffer);
        let uniform = PointsUniform {
            stride: layout.stride,
            normal: layout.normal,
            light: layout.light,
            is_culled: u32::from(layout.has_gaps),
            radius: 0.006 * frame.bounds.size().length(),
            count,
        };
        let (view, uniform) = (frame.view_uniform(cx.gpu), cx.gpu.uniform("points", &uniform));
        let (depth, target, own) = (cx.view(depth), cx.view(display), cx.view(own));
        let bindings = [
            ("view", Binding::Buffer(&view)),
            ("points", Binding::Buffer(&uniform)),
            ("lights", Binding::Buffer(&buffer)),
            ("depth", Binding::Texture(&depth)),
        ];
        let draw = Draw {
            shader: "debug/points.wgsl",
            defs: Vec::new(),
            bindings: &bindings,
            target: &target,
            depth: Some(&own),
            vertices: 6,
            instances: count,
        };
        overlay::draw(cx, &draw)
    });
    display
}
