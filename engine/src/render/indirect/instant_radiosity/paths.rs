//! The ways of particles as lines over the image, hidden where a surface lies before them.

use super::particles::VirtualLights;
use crate::gpu::{Binding, RasterKey};
use crate::graph::{Graph, Handle, PassError, Texture};
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
    let mut pass = graph.pass("particle paths");
    let depth = gbuffer.depth;
    pass.read(depth);
    let radiance = pass.write(radiance);
    pass.key(&(frame.view_key(), frame.settings.particle_paths));
    let frame = frame.clone();
    pass.execute(move |cx| {
        let gpu = cx.gpu;
        let vertices = vertices(&state.particles().paths, frame.settings.particle_paths as usize);
        if vertices.is_empty() {
            return Ok(());
        }
        let pipeline = gpu.pipelines.raster(gpu, &raster_key())?;
        let buffer = gpu.storage("particle paths", &vertices, wgpu::BufferUsages::empty());
        let (target, depth) = (cx.view(radiance), cx.view(depth));
        let view = frame.view_uniform(gpu);
        let group = pipeline.bind(gpu, 0, &[("view", Binding::Buffer(&view)), ("ends", Binding::Buffer(&buffer))])?;
        let raster = pipeline.raster().ok_or_else(|| PassError::message("paths.wgsl makes no raster pipeline"))?;
        let mut pass = cx.render_pass(&wgpu::RenderPassDescriptor {
            label: Some("particle paths"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &target,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations { load: wgpu::LoadOp::Load, store: wgpu::StoreOp::Store },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &depth,
                depth_ops: None,
                stencil_ops: None,
            }),
            ..Default::default()
        });
        pass.set_pipeline(raster);
        pass.set_bind_group(0, &group, &[]);
        pass.draw(0..vertices.len() as u32, 0..1);
        drop(pass);
        cx.counts().draws += 1;
        Ok(())
    });
    radiance
}

/// Both ends of every flight, with its number on the particle's way.
fn vertices(paths: &[Vec<Vec3>], most: usize) -> Vec<[f32; 4]> {
    let flights = paths.iter().take(most).flat_map(|path| path.windows(2).zip(0..));
    flights.flat_map(|(ends, bounce)| [ends[0], ends[1]].map(|end| end.extend(bounce as f32).to_array())).collect()
}

fn raster_key() -> RasterKey {
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
