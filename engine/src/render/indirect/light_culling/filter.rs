//! The cross bilateral filter, and the reflected radiance.

use super::{Method, Shaded, image_desc};
use crate::gpu::{Binding, ComputeKey};
use crate::graph::{Graph, Handle, Texture};
use crate::render::frame::Frame;
use crate::render::geometry::gbuffer::GBuffer;

/// Declares both passes; the result is reflected radiance.
pub(super) fn declare<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    gbuffer: &GBuffer,
    method: &Method,
    shaded: Shaded,
) -> Handle<Texture> {
    let key = method.key(frame);
    let half = Shaded {
        diffuse: graph.retained_texture("slc filtered diffuse", image_desc(frame)),
        specular: graph.retained_texture("slc filtered specular", image_desc(frame)),
    };
    let mut pass = graph.pass("slc filter, horizontal");
    let inputs = [gbuffer.normal, gbuffer.depth, shaded.diffuse, shaded.specular];
    inputs.into_iter().for_each(|handle| pass.read(handle));
    let half = Shaded { diffuse: pass.write(half.diffuse), specular: pass.write(half.specular) };
    pass.key(&key);
    let ([width, height], of_frame, settings) = (frame.view.size, frame.clone(), method.clone());
    let groups = [width.div_ceil(8), height.div_ceil(8), 1];
    pass.execute(move |cx| {
        let gpu = cx.gpu;
        let [normal, depth, diffuse, specular] = inputs.map(|handle| cx.view(handle));
        let [diffuse_out, specular_out] = [half.diffuse, half.specular].map(|handle| cx.view(handle));
        cx.counts().texels += u64::from(width) * u64::from(height);
        cx.dispatch(
            &ComputeKey::new("indirect/light_culling/filter.wgsl", "horizontal"),
            &[
                ("culling", Binding::Buffer(&settings.uniform(gpu, &of_frame, 0))),
                ("normal", Binding::Texture(&normal)),
                ("depth", Binding::Texture(&depth)),
                ("diffuse", Binding::Texture(&diffuse)),
                ("specular", Binding::Texture(&specular)),
                ("diffuse_out", Binding::Texture(&diffuse_out)),
                ("specular_out", Binding::Texture(&specular_out)),
            ],
            groups,
        )
    });

    let indirect = graph.retained_texture("indirect radiance", image_desc(frame));
    let mut pass = graph.pass("slc filter, vertical");
    let inputs = [gbuffer.base_color, gbuffer.normal, gbuffer.depth];
    let images = [half.diffuse, half.specular, shaded.diffuse, shaded.specular];
    inputs.into_iter().chain(images).for_each(|handle| pass.read(handle));
    let indirect = pass.write(indirect);
    pass.key(&key);
    let (frame, method) = (frame.clone(), method.clone());
    pass.execute(move |cx| {
        let gpu = cx.gpu;
        let [base_color, normal, depth] = inputs.map(|handle| cx.view(handle));
        let [diffuse, specular, tested, accepted] = images.map(|handle| cx.view(handle));
        let target = cx.view(indirect);
        cx.counts().texels += u64::from(width) * u64::from(height);
        cx.dispatch(
            &ComputeKey::new("indirect/light_culling/filter.wgsl", "vertical"),
            &[
                ("culling", Binding::Buffer(&method.uniform(gpu, &frame, 0))),
                ("base_color", Binding::Texture(&base_color)),
                ("normal", Binding::Texture(&normal)),
                ("depth", Binding::Texture(&depth)),
                ("diffuse", Binding::Texture(&diffuse)),
                ("specular", Binding::Texture(&specular)),
                ("tested", Binding::Texture(&tested)),
                ("accepted", Binding::Texture(&accepted)),
                ("indirect", Binding::Texture(&target)),
            ],
            groups,
        )
    });
    indirect
}
