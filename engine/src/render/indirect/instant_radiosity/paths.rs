//! The ways of particles as lines over the image, hidden where a surface lies before them.

use super::particles::VirtualLights;
use crate::gpu::RasterKey;
use crate::graph::{Contents, Graph, Handle, Texture};
use crate::render::frame::Frame;
use crate::render::geometry::gbuffer::{GBuffer, depth_state};
use glam::Vec3;
use wgpu::TextureFormat;

/// Declares the pass; it draws into the radiance image.
pub(in crate::render) fn declare<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    gbuffer: &GBuffer,
    state: &'a VirtualLights,
    radiance: Handle<Texture>,
) -> Handle<Texture> {
    let most = frame.settings.particle_paths;
    let ends = move || vertices(&state.particles().paths, most as usize);
    let revision = (state.key(frame.scene), most);
    let mut pass = graph.raster("particle paths");
    let radiance = pass.color(radiance, Contents::Kept);
    pass.test_depth(gbuffer.depth);
    frame.bind_view(&mut pass);
    pass.values_of("ends", &revision, ends);
    pass.step().draw_later(pipeline(), &revision, move || [ends().len() as u32, 1]);
    pass.finish();
    radiance
}

/// Both ends of every flight, with its number on the particle's way.
fn vertices(paths: &[Vec<Vec3>], most: usize) -> Vec<[f32; 4]> {
    let flights = paths.iter().take(most).flat_map(|path| path.windows(2).zip(0..));
    flights.flat_map(|(ends, bounce)| [ends[0], ends[1]].map(|end| end.extend(bounce as f32).to_array())).collect()
}

fn pipeline() -> RasterKey {
    RasterKey {
        shader: "indirect/instant_radiosity/paths.wgsl",
        vertex: "vertex",
        fragment: Some("fragment"),
        defs: Vec::new(),
        vertex_buffers: Vec::new(),
        primitive: wgpu::PrimitiveState { topology: wgpu::PrimitiveTopology::LineList, ..Default::default() },
        depth: Some(wgpu::DepthStencilState {
            depth_write_enabled: Some(false),
            depth_compare: Some(wgpu::CompareFunction::GreaterEqual),
            ..depth_state()
        }),
        targets: vec![Some(TextureFormat::Rgba32Float.into())],
    }
}
