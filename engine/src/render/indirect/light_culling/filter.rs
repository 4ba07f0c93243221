//! The cross bilateral filter, and the reflected radiance.

use super::{Method, Shaded, image_desc};
use crate::gpu::ComputeKey;
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
    let culling = method.values(frame, 0);
    let half = Shaded {
        diffuse: graph.retained_texture("slc filtered diffuse", image_desc(frame)),
        specular: graph.retained_texture("slc filtered specular", image_desc(frame)),
    };
    let mut pass = graph.compute("slc filter, horizontal", shader("horizontal"));
    pass.uniform("culling", &culling);
    pass.read("normal", gbuffer.normal);
    pass.read("depth", gbuffer.depth);
    pass.read("diffuse", shaded.diffuse);
    pass.read("specular", shaded.specular);
    let diffuse = pass.write("diffuse_out", half.diffuse);
    let specular = pass.write("specular_out", half.specular);
    pass.dispatch_over(frame.view.size);

    let indirect = graph.retained_texture("indirect radiance", image_desc(frame));
    let mut pass = graph.compute("slc filter, vertical", shader("vertical"));
    pass.uniform("culling", &culling);
    pass.read("base_color", gbuffer.base_color);
    pass.read("normal", gbuffer.normal);
    pass.read("depth", gbuffer.depth);
    pass.read("diffuse", diffuse);
    pass.read("specular", specular);
    pass.read("tested", shaded.diffuse);
    pass.read("accepted", shaded.specular);
    let indirect = pass.write("indirect", indirect);
    pass.dispatch_over(frame.view.size);
    indirect
}

fn shader(entry: &'static str) -> ComputeKey {
    ComputeKey::new("indirect/light_culling/filter.wgsl", entry)
}
