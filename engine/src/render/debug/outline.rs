//! The silhouette of what is selected, from the identities in the G-buffer.

use super::overlay::{self, Draw};
use crate::gpu::{Binding, ComputeKey};
use crate::graph::{Graph, Handle, Texture, TextureDesc};
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

    let mut pass = graph.pass("selection");
    pass.read(object);
    pass.read(blended);
    let mask = pass.write(mask);
    pass.key(outlined);
    pass.execute(move |cx| {
        // Their number first: buffers are padded.
        let counted: Vec<u32> = std::iter::once(outlined.len() as u32).chain(outlined.iter().copied()).collect();
        let ids = cx.gpu.storage("outlined", &counted, wgpu::BufferUsages::empty());
        let [object, blended, target] = [object, blended, mask].map(|handle| cx.view(handle));
        cx.counts().texels += u64::from(width) * u64::from(height);
        cx.dispatch(
            &ComputeKey::new("debug/outline.wgsl", "mark"),
            &[
                ("outlined", Binding::Buffer(&ids)),
                ("object", Binding::Texture(&object)),
                ("blended", Binding::Texture(&blended)),
                ("mask_out", Binding::Texture(&target)),
            ],
            [width.div_ceil(8), height.div_ceil(8), 1],
        )
    });

    let mut pass = graph.pass("outline");
    pass.read(mask);
    let display = pass.write(display);
    pass.key(&());
    pass.execute(move |cx| {
        let (mask, target) = (cx.view(mask), cx.view(display));
        let bindings = [("mask", Binding::Texture(&mask))];
        let draw = Draw {
            shader: "debug/outline.wgsl",
            defs: Vec::new(),
            bindings: &bindings,
            target: &target,
            depth: None,
            vertices: 3,
            instances: 1,
        };
        overlay::draw(cx, &draw)
    });
    display
}
