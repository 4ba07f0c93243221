//! Morphological anti-aliasing (Reshetov 2009; thesis 5.7): edges, blend weights, blend. Edges are found by colour in
//! the tone-mapped image; colours are mixed in linear light and encoded last.

use super::tone_map::DISPLAY;
use crate::gpu::{Binding, ComputeKey};
use crate::graph::{Graph, Handle, Texture, TextureDesc};
use wgpu::TextureFormat;

const USAGE: wgpu::TextureUsages = wgpu::TextureUsages::STORAGE_BINDING.union(wgpu::TextureUsages::TEXTURE_BINDING);

/// Declares the three passes; the result is the display image. Pixels that no edge touches keep their bits.
pub fn declare(graph: &mut Graph, image: Handle<Texture>, [width, height]: [u32; 2]) -> Handle<Texture> {
    let desc = |format| TextureDesc::d2(width, height, format, USAGE);
    let edges = graph.texture("mlaa edges", desc(TextureFormat::R32Uint));
    let weights = graph.texture("mlaa weights", desc(TextureFormat::Rgba16Float));
    let mut shown = desc(TextureFormat::Rgba8Unorm);
    // Overlays are drawn into it.
    shown.usage |= wgpu::TextureUsages::RENDER_ATTACHMENT;
    let display = graph.retained_texture(DISPLAY, shown);
    let size = [width, height];
    let edges = pass(graph, ["mlaa edges", "edges_main"], &[("image", image)], ("edges_out", edges), size);
    let weights = pass(graph, ["mlaa weights", "weights_main"], &[("edges", edges)], ("weights_out", weights), size);
    let inputs = [("image", image), ("weights", weights)];
    pass(graph, ["mlaa blend", "blend_main"], &inputs, ("display", display), size)
}

/// Declares a pass by its name and entry point.
fn pass(
    graph: &mut Graph,
    [name, entry]: [&'static str; 2],
    inputs: &[(&'static str, Handle<Texture>)],
    output: (&'static str, Handle<Texture>),
    [width, height]: [u32; 2],
) -> Handle<Texture> {
    let inputs = inputs.to_vec();
    let mut pass = graph.pass(name);
    for (_, input) in &inputs {
        pass.read(*input);
    }
    let written = pass.write(output.1);
    pass.key(&());
    pass.execute(move |cx| {
        let views: Vec<_> = inputs.iter().map(|&(name, handle)| (name, cx.view(handle))).collect();
        let target = cx.view(written);
        let mut bindings: Vec<_> = views.iter().map(|(name, view)| (*name, Binding::Texture(view))).collect();
        bindings.push((output.0, Binding::Texture(&target)));
        cx.counts().texels += u64::from(width) * u64::from(height);
        let groups = [width.div_ceil(8), height.div_ceil(8), 1];
        cx.dispatch(&ComputeKey::new("post/mlaa.wgsl", entry), &bindings, groups)
    });
    written
}
