//! Virtual lights as discs of their colour, with their normals.

use super::overlay::{self, DEPTH, Draw};
use crate::gpu::Binding;
use crate::graph::{Buffer, Graph, Handle, Texture, TextureDesc};
use crate::render::frame::Frame;
use crate::render::gbuffer::GBuffer;
use crate::render::settings::GiMethod;
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

/// Where a method keeps what of a light, in vectors of four numbers.
fn layout(method: GiMethod) -> Option<(u32, u32, u32)> {
    match method {
        // `VirtualLight` of `lib/vpl.wgsl`: place, normal, intensity, and two more.
        GiMethod::Vpl => Some((5, 1, 2)),
        // `VirtualLight` of `lib/slc.wgsl`: position, direction, normal, flux, and two more.
        GiMethod::Slc => Some((6, 2, 3)),
        _ => None,
    }
}

/// Declares the pass; the result is the display image with the lights.
pub(super) fn declare<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    gbuffer: &GBuffer,
    display: Handle<Texture>,
) -> Handle<Texture> {
    let lights = graph.latest::<Buffer>("virtual lights");
    let (Some((stride, normal, light)), Some(lights)) = (layout(frame.settings.gi), lights) else {
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
        let in_buffer = (buffer.size() / (16 * u64::from(stride))) as u32;
        // What lies behind the last light of a buffer is older.
        let count = match frame.virtual_lights.filter(|_| frame.settings.gi == GiMethod::Vpl) {
            Some(state) if !state.particles().lights.is_empty() => state.particles().lights.len() as u32,
            _ => in_buffer,
        };
        let uniform = PointsUniform {
            stride,
            normal,
            light,
            is_culled: u32::from(frame.settings.gi == GiMethod::Slc),
            radius: 0.006 * frame.bounds.size().length(),
            count: count.min(in_buffer),
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
            bindings: &bindings,
            target: &target,
            depth: Some(&own),
            vertices: 6,
            instances: count.min(in_buffer),
        };
        overlay::draw(cx, &draw)
    });
    display
}
