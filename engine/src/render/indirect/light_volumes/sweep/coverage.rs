//! Which faces of the cells surfaces close.

use crate::gpu::{Binding, RasterKey, ShaderDef};
use crate::graph::{Buffer, BufferDesc, Graph, Handle, PassContext, PassError, TextureDesc};
use crate::render::frame::Frame;
use crate::render::indirect::light_volumes::volume::Volume;
use crate::render::scene_gpu::{DrawFilter, MaterialClass};
use crate::scene::Frustum;
use glam::{Mat4, Vec3};
use wgpu::{BufferUsages, ColorTargetState, ColorWrites, TextureFormat, TextureUsages};

/// Of the texture that the scene is drawn into, and that nothing is written to.
const FORMAT: TextureFormat = TextureFormat::R8Unorm;

/// Parts of a cell along an axis, as in `lib/coverage.wgsl`.
pub(super) const PARTS: u32 = 3;

/// Bytes of a cell: a bit for each face of its parts and each side of it.
const CELL_BYTES: u64 = 24;

/// Declares the walls of a cascade between the parts of its cells, see `indirect/light_volumes/sweep/coverage.wgsl`. Surfaces with holes in them are
/// left out, and objects smaller than a cell: those stop light by their area.
pub(super) fn declare<'a>(graph: &mut Graph<'a>, frame: &Frame<'a>, level: &str, volume: &Volume) -> Handle<Buffer> {
    let name = format!("coverage, {level}");
    let usage = BufferUsages::STORAGE | BufferUsages::COPY_DST;
    let coverage =
        graph.retained_buffer(name.as_str(), BufferDesc::new(CELL_BYTES * u64::from(volume.cell_count()), usage));
    let columns = [0, 1, 2].map(|axis| {
        let [width, height] = across(volume, axis);
        let desc = TextureDesc::d2(width, height, FORMAT, TextureUsages::RENDER_ATTACHMENT);
        graph.texture(format!("{name}, columns along axis {axis}"), desc)
    });
    // By hand: each axis has a target of another size, and fragments write to a buffer of group 1 in place of it.
    let mut pass = graph.pass(name.as_str());
    let (coverage, columns) = (pass.write(coverage), columns.map(|texture| pass.write(texture)));
    pass.key(&(frame.geometry_key(), volume.key()));
    let (volume, frame) = (*volume, frame.clone());
    pass.execute(move |cx| {
        let buffer = cx.buffer(coverage).clone();
        cx.encoder().clear_buffer(&buffer, 0, None);
        for (axis, texture) in columns.into_iter().enumerate() {
            let target = cx.view(texture);
            draw_along(cx, &frame, &volume, axis, &target, &buffer)?;
        }
        Ok(())
    });
    coverage
}

/// Columns of parts of cells along an axis.
fn across(volume: &Volume, axis: usize) -> [u32; 2] {
    [1, 2].map(|next| PARTS * volume.cells[(axis + next) % 3])
}

fn draw_along(
    cx: &mut PassContext,
    frame: &Frame,
    volume: &Volume,
    axis: usize,
    target: &wgpu::TextureView,
    coverage: &wgpu::Buffer,
) -> Result<(), PassError> {
    let view = cx.gpu.uniform("volume", &volume.uniform());
    let pipeline = cx.gpu.pipelines.raster(cx.gpu, &raster_key(MaterialClass::SIMPLEST, axis))?;
    let group = pipeline.bind(cx.gpu, 1, &[("closed", Binding::Buffer(coverage))])?;
    let mut pass = cx
        .render_pass(&wgpu::RenderPassDescriptor {
            label: Some("coverage"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: target,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::BLACK), store: wgpu::StoreOp::Discard },
            })],
            ..Default::default()
        })
        .forget_lifetime();
    pass.set_bind_group(1, &group, &[]);
    let frustum = Frustum::new(&clip_from_world(volume));
    let filter = DrawFilter::walls(&frustum, volume.cell);
    frame.gpu_scene.draw(cx, &mut pass, &[("view", Binding::Buffer(&view))], &filter, |class| raster_key(class, axis))
}

/// The box of the cascade with a cell around it as clip space.
fn clip_from_world(volume: &Volume) -> Mat4 {
    let around = Vec3::splat(volume.cell);
    let (low, high) = (volume.bounds().min - around, volume.bounds().max + around);
    let scale = Vec3::new(2.0, 2.0, 1.0) / (high - low);
    let shift = -low * scale - Vec3::new(1.0, 1.0, 0.0);
    Mat4::from_translation(shift) * Mat4::from_scale(scale)
}

fn raster_key(class: MaterialClass, axis: usize) -> RasterKey {
    RasterKey {
        shader: "indirect/light_volumes/sweep/coverage.wgsl",
        vertex: "vertex",
        fragment: Some(if class.double_sided { "double_sided" } else { "one_sided" }),
        defs: vec![("AXIS", ShaderDef::Int(axis as i32))],
        vertex_buffers: class.vertex_buffers(),
        primitive: wgpu::PrimitiveState { cull_mode: None, ..class.primitive_state() },
        depth: None,
        targets: vec![Some(ColorTargetState { format: FORMAT, blend: None, write_mask: ColorWrites::empty() })],
    }
}
