//! Morphological anti-aliasing (Reshetov 2009; thesis 5.7): edges, blend weights, blend. Edges are found by colour in
//! the tone-mapped image, or by depth or normal in the G-buffer; colours are mixed in linear light and encoded last.

use crate::gpu::{ComputeKey, ShaderDef};
use crate::graph::{Graph, Handle, Texture, TextureDesc};
use crate::render::geometry::gbuffer::GBuffer;
use crate::render::settings::MlaaEdges;
use wgpu::TextureFormat;

const USAGE: wgpu::TextureUsages = wgpu::TextureUsages::STORAGE_BINDING.union(wgpu::TextureUsages::TEXTURE_BINDING);

/// Declares the three passes; the result is an image of that name. Pixels that no edge touches keep their bits. Without a
/// G-buffer edges are told by colour.
pub fn declare(
    graph: &mut Graph,
    image: Handle<Texture>,
    name: &str,
    [width, height]: [u32; 2],
    by: MlaaEdges,
    gbuffer: Option<&GBuffer>,
) -> Handle<Texture> {
    let desc = |format| TextureDesc::d2(width, height, format, USAGE);
    let edges = graph.texture("mlaa edges", desc(TextureFormat::R32Uint));
    let weights = graph.texture("mlaa weights", desc(TextureFormat::Rgba16Float));
    let mut shown = desc(TextureFormat::Rgba8Unorm);
    // Overlays are drawn into it.
    shown.usage |= wgpu::TextureUsages::RENDER_ATTACHMENT;
    let display = graph.retained_texture(name, shown);
    let size = [width, height];
    let (source, define) = match (by, gbuffer) {
        (MlaaEdges::Depth, Some(gbuffer)) => (vec![("depth", gbuffer.depth)], Some("BY_DEPTH")),
        (MlaaEdges::Normal, Some(gbuffer)) => {
            (vec![("normal", gbuffer.normal), ("depth", gbuffer.depth)], Some("BY_NORMAL"))
        }
        _ => (vec![("image", image)], None),
    };
    let names = ["mlaa edges", "edges_main"];
    let edges = pass(graph, names, define, &source, ("edges_out", edges), size);
    let names = ["mlaa weights", "weights_main"];
    let weights = pass(graph, names, None, &[("edges", edges)], ("weights_out", weights), size);
    let inputs = [("image", image), ("weights", weights)];
    pass(graph, ["mlaa blend", "blend_main"], None, &inputs, ("display", display), size)
}

/// Declares a pass by its name and entry point.
fn pass(
    graph: &mut Graph,
    [name, entry]: [&'static str; 2],
    define: Option<&'static str>,
    inputs: &[(&'static str, Handle<Texture>)],
    output: (&'static str, Handle<Texture>),
    size: [u32; 2],
) -> Handle<Texture> {
    let mut pass = graph.compute(name, ComputeKey::new("post/mlaa.wgsl", entry));
    define.into_iter().for_each(|define| pass.define(define, ShaderDef::Flag(true)));
    inputs.iter().for_each(|&(name, input)| pass.read(name, input));
    let written = pass.write(output.0, output.1);
    pass.dispatch_over(size);
    written
}
