//! Where glass is, and how near: a mask for the rays of [`glass`](super::glass), by the vertex shader of the G-buffer.

use crate::gpu::RasterKey;
use crate::graph::{Graph, Handle, Texture, TextureDesc};
use crate::render::frame::Frame;
use crate::render::geometry::gbuffer::{DEPTH_FORMAT, depth_attachment, depth_state};
use crate::render::scene_gpu::{DrawFilter, MaterialClass, Motion};
use wgpu::TextureUsages;

/// Declares the pass; the result is the reversed depth of the nearest glass, 0 where there is none. What opaque surfaces hide is
/// in it too, and holes that alpha cuts are not.
pub(super) fn declare<'a>(graph: &mut Graph<'a>, frame: &Frame<'a>) -> Handle<Texture> {
    let [width, height] = frame.view.size;
    let usage = TextureUsages::RENDER_ATTACHMENT | TextureUsages::TEXTURE_BINDING;
    let depth = graph.texture("glass depth", TextureDesc::d2(width, height, DEPTH_FORMAT, usage));
    let mut pass = graph.pass("glass depth");
    let depth = pass.write(depth);
    pass.key(&(frame.geometry_key(), frame.view_key()));
    let frame = frame.clone();
    pass.execute(move |cx| {
        let (view, target) = (frame.view_uniform(cx.gpu), cx.view(depth));
        let mut pass = cx
            .render_pass(&wgpu::RenderPassDescriptor {
                label: Some("glass depth"),
                color_attachments: &[],
                depth_stencil_attachment: Some(depth_attachment(&target, Motion::Any)),
                ..Default::default()
            })
            .forget_lifetime();
        let frustum = frame.frustum();
        frame.gpu_scene.draw(cx, &mut pass, &view, &DrawFilter::glass(&frustum), raster_key)
    });
    depth
}

fn raster_key(class: MaterialClass) -> RasterKey {
    RasterKey {
        shader: "geometry/gbuffer.wgsl",
        vertex: "vertex",
        fragment: None,
        defs: class.defs(),
        vertex_buffers: class.vertex_buffers(),
        primitive: class.primitive_state(),
        depth: Some(depth_state()),
        targets: Vec::new(),
    }
}
