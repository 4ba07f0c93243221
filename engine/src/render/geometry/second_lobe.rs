//! Lobes that the G-buffer has no room for, of clear coats and of stretched highlights, as a second surface of the pixels that show
//! them: a G-buffer of their own, for the same passes that light the nearest surfaces. See `geometry/second_lobe.wgsl`. It is
//! drawn where such a lobe is in view, and all that reads it is left out elsewhere.

use super::gbuffer::{COLOR_TARGETS, DEPTH_FORMAT, GBuffer, USAGE, depth_attachment, depth_state};
use crate::gpu::{Binding, RasterKey};
use crate::graph::{Graph, Handle, PassContext, PassError, Texture, TextureDesc};
use crate::render::frame::Frame;
use crate::render::scene_gpu::{DrawFilter, MaterialClass, Motion};
use crate::render::surfaces::Surfaces;

/// The colour targets that such lobes have: they emit nothing.
const TARGETS: [usize; 3] = [0, 1, 3];

const NAME: &str = "second lobe";

/// Declares the pass; none, with the reason in the report, where no such lobe is in view.
pub(in crate::render) fn declare<'a>(graph: &mut Graph<'a>, frame: &Frame<'a>, gbuffer: &GBuffer) -> Option<GBuffer> {
    let frustum = frame.frustum();
    if !frame.settings.only.is_light() {
        graph.skip(NAME, "the layer that is shown holds no reflections");
        return None;
    }
    if !frame.gpu_scene.any_visible(&DrawFilter::with_second_lobe(&frustum)) {
        graph.skip(NAME, "no surface with a clear coat or a stretched highlight is in view");
        return None;
    }
    let [width, height] = frame.view.size;
    let texture = |graph: &mut Graph<'a>, name: &str, format| {
        graph.retained_texture(Surfaces::SecondLobes.name(name), TextureDesc::d2(width, height, format, USAGE))
    };
    let targets = TARGETS.map(|index| COLOR_TARGETS[index]).map(|(name, format)| texture(graph, name, format));
    let depth = texture(graph, "gbuffer depth", DEPTH_FORMAT);
    let mut pass = graph.pass(NAME);
    pass.read(gbuffer.object);
    let [base_color, normal, object] = targets.map(|target| pass.write(target));
    let depth = pass.write(depth);
    let moving = frame.gpu_scene.moving(&[DrawFilter::with_second_lobe(&frustum)]);
    pass.key(&(frame.gpu_scene.still_key(), moving, frame.view_key()));
    let (frame, seen) = (frame.clone(), gbuffer.object);
    pass.execute(move |cx| draw(cx, &frame, seen, &[base_color, normal, object, depth]));
    Some(GBuffer { base_color, normal, emissive: gbuffer.emissive, object, depth, surfaces: Surfaces::SecondLobes })
}

fn draw(
    cx: &mut PassContext,
    frame: &Frame,
    seen: Handle<Texture>,
    targets: &[Handle<Texture>; 4],
) -> Result<(), PassError> {
    let (view, seen) = (frame.view_uniform(cx.gpu), cx.view(seen));
    let [color @ .., depth] = targets.map(|handle| cx.view(handle));
    let attachments = color.each_ref().map(|view| {
        let ops = wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT), store: wgpu::StoreOp::Store };
        Some(wgpu::RenderPassColorAttachment { view, depth_slice: None, resolve_target: None, ops })
    });
    let mut pass = cx
        .render_pass(&wgpu::RenderPassDescriptor {
            label: Some(NAME),
            color_attachments: &attachments,
            depth_stencil_attachment: Some(depth_attachment(&depth, Motion::Any)),
            ..Default::default()
        })
        .forget_lifetime();
    let frustum = frame.frustum();
    let group = [("view", Binding::Buffer(&view)), ("seen", Binding::Texture(&seen))];
    frame.gpu_scene.draw_with(cx, &mut pass, &group, &DrawFilter::with_second_lobe(&frustum), raster_key)
}

fn raster_key(class: MaterialClass) -> RasterKey {
    RasterKey {
        shader: "geometry/second_lobe.wgsl",
        vertex: "vertex",
        fragment: Some("fragment"),
        defs: class.defs(),
        vertex_buffers: class.vertex_buffers(),
        primitive: class.primitive_state(),
        depth: Some(depth_state()),
        targets: TARGETS.iter().map(|&index| Some(COLOR_TARGETS[index].1.into())).collect(),
    }
}
