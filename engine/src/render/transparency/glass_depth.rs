//! Where glass is, and how near: a mask for the rays of [`glass`](super::glass), by the vertex shader of the G-buffer.

use crate::gpu::RasterKey;
use crate::graph::{Contents, Graph, Handle, Texture, TextureDesc};
use crate::render::frame::Frame;
use crate::render::geometry::gbuffer::{DEPTH_FORMAT, depth_state};
use crate::render::scene_gpu::{DrawFilter, MaterialClass, Motion, SceneDraws};
use std::rc::Rc;
use wgpu::TextureUsages;

/// Declares the pass; the result is the reversed depth of the nearest glass, 0 where there is none. What opaque surfaces hide is
/// in it too, and holes that alpha cuts are not.
pub(super) fn declare<'a>(graph: &mut Graph<'a>, frame: &Frame<'a>) -> Handle<Texture> {
    let [width, height] = frame.view.size;
    let usage = TextureUsages::RENDER_ATTACHMENT | TextureUsages::TEXTURE_BINDING;
    let depth = graph.texture("glass depth", TextureDesc::d2(width, height, DEPTH_FORMAT, usage));
    let mut pass = graph.raster("glass depth");
    let depth = pass.depth(depth, Contents::Cleared);
    frame.bind_view(&mut pass);
    let (scene, frustum) = (frame.gpu_scene, frame.frustum());
    let (motion, pipeline) = (Motion::Any, Rc::new(pipeline));
    pass.step().draws(SceneDraws { scene, frustum, filter: DrawFilter::glass, motion, pipeline });
    pass.finish();
    depth
}

fn pipeline(class: MaterialClass) -> RasterKey {
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
