//! The static layer cache: dynamic objects are drawn over a kept image of static ones.
//!
//! A view that rests, be it a light's or the camera's, needs static objects only once: they are kept in targets of its
//! own, and a frame copies those and draws dynamic objects on top. That takes the memory of the view's targets a second
//! time, while anything moves in the view. The depth test lets the first of equals stay, and dynamic objects are drawn last
//! whether they are drawn apart or not: both ways give the same bits.

use crate::graph::{Contents, Graph, Handle, RasterBuilder, Texture, TextureDesc};
use crate::render::frame::Frame;
use crate::render::scene_gpu::{DrawFilter, FilterOf, Motion, PipelineOf, SceneDraws};
use crate::render::views::hash;
use crate::scene::Frustum;
use encase::ShaderType;
use encase::internal::WriteInto;
use std::rc::Rc;

/// A view of the scene, and the layer of the targets that it is drawn into.
pub(in crate::render) struct LayerView<'a, U> {
    /// The layer; `None` where the targets have no layers.
    pub layer: Option<u32>,
    /// What it sees.
    pub frustum: Frustum,
    /// What shaders bind as `view`.
    pub uniform: U,
    /// The pipelines that draw it.
    pub pipeline: PipelineOf<'a>,
}

/// Targets that hold what the views see of what passes the filter: colours, and last of all depth.
pub(in crate::render) fn declare<'a, U: ShaderType + WriteInto, const N: usize>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    name: &str,
    targets: [(String, TextureDesc); N],
    filter: FilterOf,
    views: &[LayerView<'a, U>],
) -> [Handle<Texture>; N] {
    let scene = frame.gpu_scene;
    let filters: Vec<DrawFilter> = views.iter().map(|view| filter(&view.frustum)).collect();
    let moving = scene.moving(&filters);
    let uniforms: Vec<_> = views.iter().map(|view| crate::gpu::uniform_bytes("view", &view.uniform)).collect();
    let key = hash(&(uniforms, &targets.each_ref().map(|(_, desc)| desc)));
    let are_apart = frame.views.are_apart(name, key, &moving)
        && filters.iter().any(|filter| scene.any_visible(&filter.of(Motion::Still)));
    let draw = |mut pass: RasterBuilder<'_, 'a>, motion| {
        for LayerView { layer, frustum, uniform, pipeline } in views {
            let mut step = pass.step();
            layer.iter().for_each(|layer| step.layer(*layer));
            step.uniform("view", uniform);
            step.draws(SceneDraws { scene, frustum: *frustum, filter, motion, pipeline: Rc::clone(pipeline) });
        }
        pass.finish();
    };
    let still = are_apart.then(|| {
        let kept =
            targets.each_ref().map(|(name, desc)| graph.retained_texture(format!("{name}, still"), desc.clone()));
        let mut pass = graph.raster(format!("{name}, still"));
        let kept = draw_into(&mut pass, kept, Contents::Cleared);
        draw(pass, Motion::Still);
        kept
    });
    let textures = targets.map(|(name, desc)| graph.retained_texture(name, desc));
    let mut pass = graph.raster(name);
    let (contents, motion) = match still {
        Some(_) => (Contents::Kept, Motion::Moving),
        None => (Contents::Cleared, Motion::Any),
    };
    let textures = draw_into(&mut pass, textures, contents);
    still.into_iter().flatten().zip(textures).for_each(|(from, to)| pass.copy(from, to));
    draw(pass, motion);
    textures
}

fn draw_into<const N: usize>(
    pass: &mut RasterBuilder,
    targets: [Handle<Texture>; N],
    contents: Contents,
) -> [Handle<Texture>; N] {
    let mut last = N;
    targets.map(|target| {
        last -= 1;
        if last == 0 { pass.depth(target, contents) } else { pass.color(target, contents) }
    })
}
