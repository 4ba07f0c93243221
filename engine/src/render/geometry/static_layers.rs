//! The static layer cache: dynamic objects are drawn over a kept image of static ones.
//!
//! A view that rests, be it a light's or the camera's, needs static objects only once: they are kept in targets of its
//! own, and a frame copies those and draws dynamic objects on top. That takes the memory of the view's targets a second
//! time, while anything moves in the view. The depth test lets the first of equals stay, and dynamic objects are drawn last
//! whether they are drawn apart or not: both ways give the same bits.

use crate::graph::{Graph, Handle, PassContext, PassError, Texture, TextureDesc};
use crate::render::frame::Frame;
use crate::render::scene_gpu::{DrawFilter, Motion};
use crate::render::views::hash;
use std::hash::Hash;

/// Targets that hold what passes one of the `filters`, as seen by the views with that `key`. `draw` draws into the
/// targets that it is given: all into cleared ones, or dynamic objects over what they hold, see [`ops`].
pub(in crate::render) fn declare<'a, const N: usize>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    name: &str,
    targets: [(String, TextureDesc); N],
    filters: &[DrawFilter],
    key: &impl Hash,
    draw: impl Fn(&mut PassContext, &[Handle<Texture>; N], Motion) -> Result<(), PassError> + Clone + 'a,
) -> [Handle<Texture>; N] {
    let scene = frame.gpu_scene;
    let moving = scene.moving(filters);
    let view = hash(&(hash(key), &targets.each_ref().map(|(_, desc)| desc)));
    let apart = frame.views.are_apart(name, view, &moving)
        && filters.iter().any(|filter| scene.any_visible(&filter.of(Motion::Still)));
    let still = apart.then(|| {
        let kept =
            targets.each_ref().map(|(name, desc)| graph.retained_texture(format!("{name}, still"), desc.clone()));
        let mut pass = graph.pass(format!("{name}, still"));
        let kept = kept.map(|handle| pass.write(handle));
        pass.key(&(scene.still_key(), view));
        let draw = draw.clone();
        pass.execute(move |cx| draw(cx, &kept, Motion::Still));
        kept
    });
    let textures = targets.map(|(name, desc)| graph.retained_texture(name, desc));
    let mut pass = graph.pass(name);
    still.iter().flatten().for_each(|handle| pass.read(*handle));
    let textures = textures.map(|handle| pass.write(handle));
    pass.key(&(scene.still_key(), moving, view));
    pass.execute(move |cx| match still {
        Some(still) => {
            still.into_iter().zip(textures).for_each(|(from, to)| copy(cx, from, to));
            draw(cx, &textures, Motion::Moving)
        }
        None => draw(cx, &textures, Motion::Any),
    });
    textures
}

fn copy(cx: &mut PassContext, from: Handle<Texture>, to: Handle<Texture>) {
    let [from, to] = [from, to].map(|handle| cx.texture(handle).clone());
    cx.encoder().copy_texture_to_texture(from.as_image_copy(), to.as_image_copy(), from.size());
    cx.counts().bytes += TextureDesc::of(&from).bytes();
}

/// Whether nothing is to be drawn into a view: its target holds all already.
pub(in crate::render) fn is_done(frame: &Frame, filter: &DrawFilter) -> bool {
    filter.motion == Motion::Moving && !frame.gpu_scene.any_visible(filter)
}

/// Load operation of a target: dynamic objects are drawn over its contents, static ones into a cleared one.
pub(in crate::render) fn ops<V>(motion: Motion, clear: V) -> wgpu::Operations<V> {
    let load = if motion == Motion::Moving { wgpu::LoadOp::Load } else { wgpu::LoadOp::Clear(clear) };
    wgpu::Operations { load, store: wgpu::StoreOp::Store }
}
