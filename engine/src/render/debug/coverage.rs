//! Which cascade lights a pixel: a tint with the lines of its cells.

use super::cascade_color;
use super::overlay::{self, Draw};
use crate::gpu::Binding;
use crate::graph::{Graph, Handle, Texture};
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
    let mut pass = graph.pass("debug coverage");
    let depth = gbuffer.depth;
    pass.read(depth);
    let display = pass.write(display);
    pass.key(&(frame.view_key(), volumes.iter().map(Volume::key).collect::<Vec<_>>()));
    let (frame, volumes) = (frame.clone(), volumes.to_vec());
    pass.execute(move |cx| {
        let Some(last) = volumes.last() else { return Ok(()) };
        let uniform = CoverageUniform {
            volumes: std::array::from_fn(|level| volumes.get(level).unwrap_or(last).uniform()),
            colors: std::array::from_fn(|level| cascade_color(level).extend(1.0)),
            count: volumes.len() as u32,
            pad_a: 0,
            pad_b: 0,
            pad_c: 0,
        };
        let (view, uniform) = (frame.view_uniform(cx.gpu), cx.gpu.uniform("coverage", &uniform));
        let (depth, target) = (cx.view(depth), cx.view(display));
        let bindings = [
            ("view", Binding::Buffer(&view)),
            ("coverage", Binding::Buffer(&uniform)),
            ("depth", Binding::Texture(&depth)),
        ];
        let shader = "debug/coverage.wgsl";
        overlay::draw(
            cx,
            &Draw {
                shader,
                defs: Vec::new(),
                bindings: &bindings,
                target: &target,
                depth: None,
                vertices: 3,
                instances: 1,
            },
        )
    });
    display
}
