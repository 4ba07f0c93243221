//! Lobes that the G-buffer has no room for, of clear coats and of stretched highlights, as a second surface of the pixels that show
//! them: a G-buffer of their own, for the same passes that light the nearest surfaces. See `geometry/second_lobe.wgsl`. It is
//! drawn where such a lobe is in view, and all that reads it is left out elsewhere.

use super::gbuffer::{COLOR_TARGETS, DEPTH_FORMAT, GBuffer, USAGE, depth_state};
use crate::gpu::RasterKey;
use crate::graph::{Contents, Graph, TextureDesc};
use crate::render::frame::Frame;
use crate::render::scene_gpu::{DrawFilter, FilterOf, MaterialClass, Motion, SceneDraws};
use crate::render::surfaces::Surfaces;
use std::rc::Rc;

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
    let mut pass = graph.raster(NAME);
    let [base_color, normal, object] = targets.map(|target| pass.color(target, Contents::Cleared));
    let depth = pass.depth(depth, Contents::Cleared);
    frame.bind_view(&mut pass);
    pass.read("seen", gbuffer.object);
    let filter: FilterOf = DrawFilter::with_second_lobe;
    let scene = frame.gpu_scene;
    pass.step().draws(SceneDraws { scene, frustum, filter, motion: Motion::Any, pipeline: Rc::new(pipeline) });
    pass.finish();
    Some(GBuffer { base_color, normal, emissive: gbuffer.emissive, object, depth, surfaces: Surfaces::SecondLobes })
}

fn pipeline(class: MaterialClass) -> RasterKey {
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
