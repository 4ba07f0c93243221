//! The silhouette of what is selected, from the identities in the G-buffer.

use super::overlay;
use crate::gpu::ComputeKey;
use crate::graph::{Contents, Graph, Handle, Texture, TextureDesc};
use crate::render::frame::Frame;
use crate::render::geometry::gbuffer::GBuffer;
use crate::render::transparency::blend::OBJECTS;
use wgpu::{TextureFormat, TextureUsages};

/// Declares the passes; the result is the display image with the outline.
pub(super) fn declare<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    gbuffer: &GBuffer,
    display: Handle<Texture>,
) -> Handle<Texture> {
    let [width, height] = frame.view.size;
    let usage = TextureUsages::STORAGE_BINDING | TextureUsages::TEXTURE_BINDING;
    let mask = graph.texture("selection", TextureDesc::d2(width, height, TextureFormat::R32Uint, usage));
    let outlined = &frame.settings.debug.outlined;
    let object = gbuffer.object;
    // Blended surfaces lie before those of the G-buffer.
    let blended = graph.latest::<Texture>(OBJECTS).unwrap_or(object);

    // Their number first: buffers are padded.
    let counted: Vec<u32> = std::iter::once(outlined.len() as u32).chain(outlined.iter().copied()).collect();
    let mut pass = graph.compute("selection", ComputeKey::new("debug/outline.wgsl", "mark"));
    pass.values("outlined", &counted);
    pass.read("object", object);
    pass.read("blended", blended);
    let mask = pass.write("mask_out", mask);
    pass.dispatch_over([width, height]);

    let mut pass = graph.raster("outline");
    let display = pass.color(display, Contents::Kept);
    pass.read("mask", mask);
    pass.step().draw(overlay::pipeline("debug/outline.wgsl", false), [3, 1]);
    pass.finish();
    display
}
